"""Parameters that a node changes in flight: they act, they are logged, and a replay has them."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyulog import ULog
from tests.emulation.firmware_tools import needs_emulator

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import PREEMPTION, RECORDING, build

QUAD = HOME / "graph" / "quad.yaml"
TUNED = HOME / "tests" / "apps" / "parameters" / "graphs" / "tuned_quad.yaml"
VARIANT = PREEMPTION | RECORDING
# What the tuner asks for, and when: its pitch_p is halved by its own parameter, changed before.
CHANGES = [
    ("tuner.scale", 1.4, 0.5),
    ("rate_control.pitch_p", 4.0, 0.14),
    ("allocation.airmode", 4.1, 1),
    ("allocation.airmode", 4.3, 0),
    ("rate_control.pitch_p", 4.4, 0.35),
]
UNKNOWN, WRONG_TYPE, OUT_OF_RANGE, NOT_A_NUMBER, WRITTEN = 2, 3, 4, 5, 1
RESULTS = [UNKNOWN, OUT_OF_RANGE, NOT_A_NUMBER, WRONG_TYPE, *[WRITTEN] * 5]


def flown(graph: Path, log: Path, *options: str) -> ULog:
    command = [build(graph, "sitl", VARIANT), "--log", log, "--duration", "5", *options]
    subprocess.run(command, check=True, capture_output=True)
    return ULog(str(log))


def replay(capsys: pytest.CaptureFixture[str], log: Path) -> dict[str, Any]:
    capsys.readouterr()
    cli.main(["replay", str(log), "--json"])
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    return facts


def check_changes(log: ULog, tolerance_s: float) -> None:
    assert log.initial_parameters["rate_control.pitch_p"] == pytest.approx(0.35)
    assert [name for _, name, _ in log.changed_parameters] == [name for name, _, _ in CHANGES]
    for (time_us, _, value), (_, wanted_s, wanted) in zip(
        log.changed_parameters, CHANGES, strict=True
    ):
        assert value == pytest.approx(wanted)
        assert 0 <= time_us / 1e6 - wanted_s <= tolerance_s
    assert list(log.get_dataset("parameter_value").data["result"]) == RESULTS


def check_replayed(replayed: dict[str, Any]) -> None:
    assert replayed["equal"], replayed
    assert replayed["topics"]["parameter_value"]
    assert replayed["topics"]["rate_control_params"]
    assert replayed["replayed_until_s"] > 4.5


def test_a_changed_gain_changes_the_flight_from_then_on(tmp_path: Path) -> None:
    plain = flown(QUAD, tmp_path / "plain.ulg").get_dataset("actuator_motors").data
    log = flown(TUNED, tmp_path / "tuned.ulg")
    tuned = log.get_dataset("actuator_motors").data
    check_changes(log, 0.02)
    # A log with more definitions begins later.
    times, *places = np.intersect1d(plain["timestamp"], tuned["timestamp"], return_indices=True)
    assert len(times) > 0.95 * len(plain["timestamp"])
    before = times <= 4_000_000
    columns = list(zip((plain, tuned), places, strict=True))
    for i in range(4):
        # Motors that stand are not a number.
        one, other = (np.nan_to_num(d[f"control[{i}]"][at], nan=-1) for d, at in columns)
        assert (one == other)[before].all()
        assert (one != other)[~before].mean() > 0.9


def test_a_virtual_flight_with_changes_replays_equal(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    log = tmp_path / "random.ulg"
    check_changes(flown(TUNED, log, "--times", "random"), 0.02)
    check_replayed(replay(capsys, log))


def test_a_run_of_threads_with_changes_replays_equal(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    log = tmp_path / "threads.ulg"
    words = ["--duration", "5", "-o", str(log), "--link", str(tmp_path / "link")]
    cli.main(["run", str(TUNED), *words, "--json"])
    facts = json.loads(capsys.readouterr().out)
    check_changes(ULog(str(log)), 2.0)
    replayed = replay(capsys, log)
    if facts[
        "unrecorded_activations"
    ]:  # the machine was too busy: the recording says where it ends
        assert (replayed["ends_early"], replayed["different_samples"]) == (True, 0)
    else:
        check_replayed(replayed)


@pytest.mark.long
def test_a_flight_of_the_firmware_with_changes_replays_equal(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    needs_emulator()
    log = tmp_path / "firmware.ulg"
    cli.main(["emulate", str(TUNED), "--duration", "5", "--json", "-o", str(log)])
    check_changes(ULog(str(log)), 0.02)
    check_replayed(replay(capsys, log))
