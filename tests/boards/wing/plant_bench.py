"""The plant of a vehicle, asked line by line: wing_bench.cpp."""

from __future__ import annotations

import functools
import subprocess
from typing import TYPE_CHECKING

from tests.host_program import host_program

from stator import HOME
from stator.emit.vehicles import world_lines
from stator.graph.vehicle import Vehicle, check_vehicle

if TYPE_CHECKING:
    from pathlib import Path

VEHICLES = HOME / "graph" / "vehicles"


def vehicle_of(name: str) -> Vehicle:
    return check_vehicle(VEHICLES / f"{name}.yaml")


@functools.cache
def _program() -> Path:
    return host_program("tests/boards/wing/wing_bench")


def ask(vehicle: Vehicle, lines: list[str], folder: Path) -> list[list[float]]:
    """The answers to all lines, empty for those without one."""
    text = folder / f"{vehicle.name}.vehicle"
    text.write_text("\n".join([*world_lines(vehicle), ""]), encoding="utf-8")
    finished = subprocess.run(
        [_program(), "--vehicle", text],
        input="\n".join([*lines, ""]),
        capture_output=True,
        text=True,
        check=False,
    )
    assert finished.returncode == 0, finished.stderr
    return [[float(word) for word in row.split()] for row in finished.stdout.splitlines()]


def words(*values: float) -> str:
    return " ".join(repr(float(value)) for value in values)
