"""Rows of a board's devices: what each is, and what the simulated world feeds of them.

A driver whose folder has `CLASS_PART_world.hpp` is a part of the simulated world: boards/world.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.names import upper_camel

if TYPE_CHECKING:
    from stator.graph.model import Board, Device


@dataclass(frozen=True)
class DeviceRow:
    name: str
    class_name: str
    lines: list[str]


@dataclass(frozen=True)
class DevicesRow:
    headers: list[str]
    devices: list[DeviceRow]
    raised_lines: list[str]  # of bare metal, by software


@dataclass(frozen=True)
class SensorRow:
    name: str
    class_name: str
    line: str  # that says that there is a sample; empty for a device that is asked now and then


@dataclass(frozen=True)
class SensorsRow:
    headers: list[str]  # without their ends
    devices: list[SensorRow]
    is_bare: bool


def header(driver: str) -> str:
    """Without its end, below the folder that holds drivers/."""
    return f"drivers/{driver}/{_stem(driver)}"


def class_name(driver: str) -> str:
    """Inside namespace stator."""
    return f"drivers::{driver.replace('/', '::')}::{upper_camel(_stem(driver))}"


def devices(board: Board) -> DevicesRow:
    """Those that have a driver. Lines of bare metal are vectors (lines.hpp)."""
    bound = _bound(board)
    is_bare = board.executor == "cortex_m"
    lines = {device.name: [f"{device.name}_{line}" for line in _lines(device)] for device in bound}
    headers = {f"{header(device.driver)}.hpp" for device in bound}
    if not is_bare and any(lines.values()):
        headers.add(f"stator/{board.executor}.hpp")
    return DevicesRow(
        headers=sorted(headers),
        devices=[
            DeviceRow(device.name, class_name(device.driver), [] if is_bare else lines[device.name])
            for device in bound
        ],
        raised_lines=[
            line for device in bound if is_bare and _is_fed(device) for line in lines[device.name]
        ],
    )


def sensors(board: Board) -> SensorsRow:
    """Those that the simulated world feeds."""
    fed = [device for device in _bound(board) if _is_fed(device)]
    is_bare = board.executor == "cortex_m"
    scope = "lines::" if is_bare else ""
    return SensorsRow(
        headers=sorted({header(device.driver) for device in fed}),
        devices=[
            SensorRow(
                device.name,
                class_name(device.driver),
                next((f"{scope}{device.name}_{line}" for line in _lines(device)), ""),
            )
            for device in fed
        ],
        is_bare=is_bare,
    )


def _stem(driver: str) -> str:
    return driver.replace("/", "_")


def _bound(board: Board) -> list[Device]:
    return [device for device in board.devices.values() if device.driver != "none"]


def _lines(device: Device) -> list[str]:
    assert device.interface is not None
    return list(device.interface.lines)


def _is_fed(device: Device) -> bool:
    assert device.interface is not None
    folder = device.interface.file.parents[1] / device.driver
    return (folder / f"{_stem(device.driver)}_world.hpp").is_file()
