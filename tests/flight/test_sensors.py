"""The sensors of a vehicle outdoors and their drivers: graph/examples/sensors.yaml, logged."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from pyulog import ULog

from stator import HOME
from stator.build.cmake import build

if TYPE_CHECKING:
    from numpy.typing import NDArray

SECONDS = 20
GRAPH = HOME / "graph" / "examples" / "sensors.yaml"
FAULTS = ["gnss_loss@5+5", "rc_loss@8+4", "battery_low=0.2@15"]


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> ULog:
    """Standing on the ground, with faults."""
    file = tmp_path_factory.mktemp("flight") / "sensors.ulg"
    command = [build(GRAPH, "sitl"), "--log", file, "--duration", str(SECONDS)]
    command += [word for fault in FAULTS for word in ("--fail", fault)]
    subprocess.run(command, check=True, capture_output=True)
    return ULog(str(file))


def column(log: ULog, topic: str, name: str) -> NDArray[np.float64]:
    values: NDArray[np.float64] = log.get_dataset(topic).data[name].astype(np.float64)
    return values


def times(log: ULog, topic: str) -> NDArray[np.float64]:
    return column(log, topic, "timestamp") * 1e-6


@pytest.mark.parametrize(
    ("topic", "rate_hz"),
    [
        ("sensor_baro", 50),
        ("sensor_mag", 50),  # what is logged of 100 Hz
        ("battery_status", 10),
        ("manual_control_setpoint", 50),
        ("sensor_gps", 5),
    ],
)
def test_each_has_its_rate(log: ULog, topic: str, rate_hz: float) -> None:
    assert times(log, topic).size == pytest.approx(SECONDS * rate_hz, rel=0.05)


def test_they_measure_where_the_vehicle_stands(log: ULog) -> None:
    """Zurich: PX4's home, the standard atmosphere at 488 m, a field of 0.48 gauss."""
    fixed = column(log, "sensor_gps", "fix_type") == 3
    assert np.all(np.abs(column(log, "sensor_gps", "latitude_deg")[fixed] - 47.397742) < 1e-4)
    assert np.all(np.abs(column(log, "sensor_gps", "longitude_deg")[fixed] - 8.545594) < 1e-4)
    assert np.all(np.abs(column(log, "sensor_gps", "altitude_msl_m")[fixed] - 488.0) < 15.0)
    assert np.all(np.abs(column(log, "sensor_baro", "pressure") - 95600.0) < 300.0)
    field = np.column_stack([column(log, "sensor_mag", f"xyz[{axis}]") for axis in range(3)])
    assert np.all(np.abs(np.linalg.norm(field, axis=1) - 0.484) < 0.06)


def test_a_fix_is_older_than_its_arrival(log: ULog) -> None:
    delay = times(log, "sensor_gps") - column(log, "sensor_gps", "timestamp_sample") * 1e-6
    assert np.all((delay > 0.0899) & (delay < 0.1301))


def test_faults_are_seen(log: ULog) -> None:
    fix_s = column(log, "sensor_gps", "timestamp_sample") * 1e-6
    lost = column(log, "sensor_gps", "fix_type") == 1
    assert np.array_equal(lost, (fix_s >= 5) & (fix_s < 10))
    heard = column(log, "manual_control_setpoint", "valid") == 1
    radio_s = times(log, "manual_control_setpoint")
    assert np.array_equal(~heard, (radio_s >= 8) & (radio_s < 12))
    # The graph warns below a quarter.
    warned = column(log, "battery_status", "warning") == 1
    battery_s = times(log, "battery_status")
    assert warned[battery_s > 15.1].all()
    assert not warned[battery_s < 15.0].any()


def test_the_pilot_arms_after_a_second(log: ULog) -> None:
    armed = column(log, "manual_control_switches", "arm_switch") == 1
    assert np.array_equal(armed, times(log, "manual_control_switches") >= 1)


def test_a_script_moves_the_sticks(tmp_path: Path) -> None:
    script = tmp_path / "pilot.txt"
    script.write_text("# a comment\n0.5 0.25 0 0 -1 3 0 0 0\n")
    file = tmp_path / "sensors.ulg"
    command = [build(GRAPH, "sitl"), "--log", file, "--duration", "1", "--pilot", script]
    subprocess.run(command, check=True, capture_output=True)
    flown = ULog(str(file))
    moved = times(flown, "manual_control_setpoint") >= 0.5
    assert np.array_equal(column(flown, "manual_control_setpoint", "roll"), 0.25 * moved)
    assert np.array_equal(column(flown, "manual_control_switches", "mode_slot"), 1 + 2 * moved)


@pytest.mark.parametrize(
    ("text", "wrong"),
    [
        ("1 2 0 0 0 1 0 0 0", "line 1: expected: seconds"),
        ("2 0 0 0 0 1 0 0 0\n1 0 0 0 0 1 0 0 0", "line 2"),
    ],
)
def test_a_wrong_script_is_refused(tmp_path: Path, text: str, wrong: str) -> None:
    script = tmp_path / "pilot.txt"
    script.write_text(text)
    command = [build(GRAPH, "sitl"), "--pilot", script]
    result = subprocess.run(command, check=False, capture_output=True, text=True)
    assert result.returncode == 2
    assert result.stderr.startswith(f"error: --pilot '{script}': {wrong}")
