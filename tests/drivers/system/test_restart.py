"""A restart that a node asks for, on each kind of board: the vehicle is there again, with what it
kept."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from pyulog import ULog
from tests.emulation.firmware_tools import needs_emulator

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import build, build_plant
from stator.emulator.qemu import fly

GRAPH = HOME / "tests" / "drivers" / "system" / "graph" / "restart.yaml"


def facts_of(capsys: pytest.CaptureFixture[str], *arguments: str) -> dict[str, Any]:
    """In real time on a busy machine a task may be late, which makes `run` no success."""
    capsys.readouterr()
    assert cli.main([arguments[0], str(GRAPH), *arguments[1:], "--json"]) in (0, 1)
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    return facts


def starts_before(log: Path) -> list[int]:
    """What the memory told at the start."""
    topics = {data.name: data.data for data in ULog(str(log)).data_list}
    return list(topics["stored_record"]["data[0]"]) if "stored_record" in topics else []


def test_it_ends_a_simulated_flight(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "restart.ulg"
    facts = facts_of(capsys, "fly", "-o", str(log), "--duration", "5")
    assert facts["success"]
    assert facts["reason"] == "ended by an authorised restart request"
    assert starts_before(log) == []
    (asked,) = ULog(str(log)).get_dataset("restart_request").data["timestamp"]
    # Half a second, and the period of the driver.
    assert 500_000 <= facts["duration_s"] * 1e6 - asked <= 550_000


def test_run_starts_the_process_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "restart.ulg"
    facts = facts_of(
        capsys, "run", "-o", str(log), "--duration", "5", "--link", str(tmp_path / "link")
    )
    earlier = [Path(path) for path in facts["logs_before_restart"]]
    assert [path.name for path in earlier] == ["restart.1.ulg", "restart.2.ulg"]
    assert [starts_before(path) for path in [*earlier, log]] == [[], [1], [2]]
    assert facts["reason"].endswith("ran to its end")
    assert facts["nonvolatile"] == {
        "file": str(tmp_path / "restart.records"), "state": "loaded", "records": 1,
        "most_records": 255, "mended": 0, "damaged": 0, "refused": 0, "lost": 0,
    }  # fmt: skip


def test_firmware_resets(tmp_path: Path) -> None:
    emulator = needs_emulator()
    image = build(GRAPH, "qemu_f405", executor="cortex_m")
    log = tmp_path / "restart.ulg"
    plant = [str(build_plant()), "--duration", "3"]
    finished = fly(emulator, image, plant, log, argument="restart")
    assert finished.returncode == 0, finished.stderr
    assert "record" not in finished.stderr, "no fault"
    assert json.loads(finished.stdout)["ended"] == "time_limit"
    assert starts_before(log) == [2]


def test_an_emulated_flight_ends(tmp_path: Path) -> None:
    """Unless it is told to go on, as the world has gone on meanwhile."""
    emulator = needs_emulator()
    image = build(GRAPH, "qemu_f405", executor="cortex_m")
    finished = fly(emulator, image, [str(build_plant()), "--duration", "3"], tmp_path / "one.ulg")
    assert finished.returncode == 0, finished.stderr
    assert json.loads(finished.stdout)["ended"] == "restart"
