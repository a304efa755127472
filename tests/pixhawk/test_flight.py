"""The quad's own image flies on the emulated chip: its drivers, DMA and interrupts between the
vehicle's sensors, motors and motion capture. Virtual time: the machine's load changes nothing."""

from __future__ import annotations

import hashlib
import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from tests.pixhawk.chip_tools import needs_chip

from stator import HOME
from stator import __main__ as cli

if TYPE_CHECKING:
    from stator.emulator.qemu import Emulator

QUAD = HOME / "graph" / "quad.yaml"
SECONDS = 9.0  # it takes off at 3 s, and hovers from 8 s on


@pytest.fixture(scope="module")
def emulator() -> Emulator:
    return needs_chip()


def emulate(capsys: pytest.CaptureFixture[str], log: Path, *arguments: str) -> dict[str, Any]:
    cli.main(["emulate", str(QUAD), "--board", "fmu_v2", "--json", "-o", str(log), *arguments])
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    return facts


def test_the_quad_hovers_and_two_flights_are_equal(
    emulator: Emulator, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    log = tmp_path / "flight.ulg"
    options = ["--duration", f"{SECONDS:g}", "--figures"]
    facts = emulate(capsys, log, *options)
    assert facts["emulator"] == emulator.version
    assert facts["duration_s"] == SECONDS
    assert 3.0 < facts["take_off_s"] < 3.5
    assert facts["max_error_m"] < 0.05
    assert facts["hover_height_m"] == pytest.approx(2.0, abs=0.03)
    assert (facts["lost_samples"], facts["missed_samples"]) == (0, 0)
    assert facts["recording"] is None
    figures = {row["task"]: row for row in facts["figures"]}
    assert sum(row["activations"] for row in figures.values()) == facts["activations"]
    # A sample a millisecond, once the sensor has started; and all that follows from it.
    assert figures["imu0"]["activations"] >= (SECONDS - 0.01) * 1000
    assert 0 < figures["rate_control"]["response_us"] < 200
    assert figures["rate_control"]["activations"] > (SECONDS - 0.3) * 1000
    # The file that `flash` writes.
    assert cli.main(["flash", str(QUAD), "--board", "fmu_v2", "--dry-run"]) == 0
    flashed = capsys.readouterr().out
    assert f"SHA-256 {facts['image_sha256']}\n" in flashed
    image = Path(facts["image"])
    assert hashlib.sha256(image.read_bytes()).hexdigest() == facts["image_sha256"]
    assert emulate(capsys, log, *options)["log_sha256"] == facts["log_sha256"]


@pytest.mark.long
def test_a_recorded_flight_lands_and_replays_on_this_machine(
    emulator: Emulator, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    log = tmp_path / "flight.ulg"
    facts = emulate(capsys, log, "--record")
    assert facts["emulator"] == emulator.version
    assert facts["success"], facts
    assert facts["recording"] == str(log)
    assert cli.main(["replay", str(log), "--json"]) == 0
    replayed = json.loads(capsys.readouterr().out)
    assert replayed["equal"], replayed
    assert replayed["board"] == "fmu_v2"


@pytest.mark.long
def test_an_imu_that_is_stuck_is_reset_by_its_driver(
    emulator: Emulator, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    facts = emulate(capsys, tmp_path / "flight.ulg", "--fail", "imu0.stuck@20", "--duration", "25")
    assert facts["emulator"] == emulator.version
    assert facts["failures"] == ["imu0.stuck@20"]
    assert not facts["success"]


@pytest.mark.parametrize(
    ("option", "reason"),
    [
        ("--link", "its link has no driver"),
        ("--nonvolatile=records", "its memory of records has no driver"),
        ("--pilot=pilot.yaml", "its receiver has no driver"),
        ("--sleep", "the image that is flashed does not sleep"),
        ("--speed=1", "it is not paced"),
    ],
)
def test_what_a_flight_on_the_chip_cannot_have_is_refused_by_name(
    option: str, reason: str, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    name = option.partition("=")[0]
    log = str(tmp_path / "flight.ulg")
    assert cli.main(["emulate", str(QUAD), "--board", "fmu_v2", "-o", log, option]) == 2
    expected = f"error: {name}: not on board fmu_v2: {reason}\nhint: omit {name}, or use --board"
    assert expected in capsys.readouterr().err


def test_a_graph_whose_devices_have_no_driver_is_refused(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    outdoor = HOME / "graph" / "quad_outdoor.yaml"
    log = str(tmp_path / "flight.ulg")
    assert cli.main(["emulate", str(outdoor), "--board", "fmu_v2", "-o", log]) == 2
    expected = "error: cannot fly this image: board fmu_v2 has no driver for "
    assert expected in capsys.readouterr().err
