"""The quad flies on a CAN bus of a real kernel, its motor controllers and receiver played by the
package dronecan (bench.py, inside tests/with-can), and so does what goes wrong there.

Time is slower than real time and uneven there: what counts is function, order and number."""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pyulog import ULog
from tests.drivers.can.kernel_bus import on_bus

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import RECORDING, build
from stator.flight.log import Truth, read_truth

GRAPH = Path(__file__).parent / "graph" / "short_can.yaml"
QUAD_CAN = HOME / "graph" / "quad_can.yaml"
BENCH = "tests.flight.can_bus.bench"
# A second of a flight takes 1.4 s of a processor on user-mode Linux.
SPEED = 0.25
BUS_OFF, DOWN = 3, 4  # CanInterfaceStatus
MOTOR_LOST = 4  # VehicleStatus.failsafe_event
ARMED, LAND = 2, 18


@dataclass(frozen=True)
class Flight:
    bench: dict[str, Any]  # what bench.py prints
    log: Path
    truth: Truth

    @cached_property
    def facts(self) -> dict[str, Any]:
        facts: dict[str, Any] = json.loads(self.bench["stdout"])
        return facts

    @cached_property
    def topics(self) -> dict[str, dict[str, Any]]:
        return {topic.name: topic.data for topic in ULog(str(self.log)).data_list}

    @property
    def bus(self) -> dict[str, Any]:
        """At the end."""
        return {key: row[-1] for key, row in self.topics["can_interface_status"].items()}

    def states_of_bus(self) -> set[int]:
        return set(self.topics["can_interface_status"]["state"])

    def failsafes(self) -> set[int]:
        return set(self.topics["vehicle_status"]["failsafe_event"])

    def height(self) -> float:
        return float(-self.truth.position[:, 2].min())

    def drift(self) -> float:
        """From where it stood, horizontally."""
        return float(np.abs(self.truth.position[:, :2] - self.truth.position[0, :2]).max())


def fly(
    graph: Path,
    folder: Path,
    *faults: str,
    seconds: int = 20,
    speed: float = SPEED,
    capsys: pytest.CaptureFixture[str],
) -> Flight:
    """A flight, which replays equal."""
    program = build(graph, "linux", RECORDING, executor="pthread")
    log, truth = folder / "flight.ulg", folder / "flight.truth"
    words: list[str | Path] = [sys.executable, "-X", "utf8", "-m", BENCH, program, log, truth]
    finished = on_bus(
        int(600 + 2 * seconds / speed),
        *words,
        str(speed),
        str(seconds),
        *faults,
        options=["-p", "-w", str(folder)],
        PYTHONPATH=str(HOME),
    )
    assert finished.returncode == 0, finished.stderr
    bench = json.loads(finished.stdout)
    assert (bench["returncode"], bench["stderr"]) == (0, "")
    assert bench["not_done"] == []
    capsys.readouterr()
    status = cli.main(["replay", str(log), "--graph", str(graph), "--json"])
    replayed = json.loads(capsys.readouterr().out)
    print(bench)
    assert (status, replayed["reason"]) == (0, "every sample is equal")
    assert {"actuator_motors", "esc_status", "sensor_gps", "can_send"} <= set(replayed["topics"])
    return Flight(bench, log, read_truth(truth))


def assert_flew_well(flight: Flight, height: float) -> None:
    assert flight.facts["ended"] == "motors_stopped"
    assert abs(flight.height() - height) < 0.25
    assert flight.drift() < 1.0
    assert flight.facts["touchdown_m_s"] < 1.5
    assert set(flight.topics["vehicle_status"]["nav_state"]) >= {17, 4, LAND}
    # The first report may be older than the first word of a controller.
    assert set(flight.topics["esc_status"]["esc_online_flags"][5:]) == {0b1111}
    assert flight.failsafes() == {0}


def test_it_flies_through_a_flooded_bus_bus_off_and_an_interface_that_goes_down(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    faults = ["babble@0.8", "bus_off@2.2", "down@3"]
    flight = fly(GRAPH, tmp_path, *faults, capsys=capsys)
    bench, bus = flight.bench, flight.bus
    assert_flew_well(flight, 0.8)
    assert len(set(bench["commands"])) == 1, "every controller got every command"
    assert 0 < bench["commands"][0] < bus["frames_tx"]
    assert max(bench["disordered"]) <= bus["tx_lost"], "in order, but for what was lost"
    assert min(bench["reports"]) > 20
    escs = flight.topics["esc_status"]
    assert max(escs["esc_rpm[0]"]) > 5000
    assert np.isnan(escs["esc_temperature[0]"][5:]).all(), "not measured, and no reason to refuse"
    assert abs(escs["esc_temperature[1]"][-1] - (310.0 - 273.15)) < 0.25
    assert len(flight.topics["sensor_gps"]["timestamp"]) > 0.7 * bench["fixes"] / 2
    assert bench["babbled"] > 500
    assert bench["malformed"] > 5
    rejected = flight.topics["esc_status"]["rejected"][-1]
    assert rejected > 0.5 * bench["babbled"]
    assert {0, BUS_OFF, DOWN} <= flight.states_of_bus()
    assert (bus["state"], bus["bus_off_count"]) == (0, 1)
    assert bus["tx_lost"] > 0, "commands that waited for too long"


def test_a_controller_that_falls_silent_in_flight_ends_it_in_a_landing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Its motor still turns as commanded."""
    flight = fly(GRAPH, tmp_path, "silence@0.9", capsys=capsys)
    assert flight.facts["ended"] == "motors_stopped"
    assert flight.facts["touchdown_m_s"] < 1.5
    assert flight.failsafes() == {0, MOTOR_LOST}
    assert flight.topics["esc_status"]["esc_online_flags"][-1] == 0b1011
    status = flight.topics["vehicle_status"]
    forced = int(np.argmax(status["failsafe_event"]))
    assert (status["arming_state"][forced], status["nav_state"][forced]) == (ARMED, LAND)
    assert len(set(flight.bench["commands"])) == 1, "and is commanded to the end"


@pytest.mark.long
def test_a_controller_that_dies_in_flight_is_reported_and_the_bus_lives_on(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """No quad flies with three motors: it falls, and nothing else fails."""
    flight = fly(GRAPH, tmp_path, "die@2", capsys=capsys)
    assert flight.facts["take_off_s"] > 0.0
    assert flight.failsafes() == {0, MOTOR_LOST}
    flags = flight.topics["esc_status"]["esc_online_flags"]
    assert 0b1111 in flags
    assert flags[-1] == 0b1011
    assert len(set(flight.bench["commands"])) == 1, "all are commanded to the end"
    assert flight.bus["tx_lost"] == 0


@pytest.mark.long
def test_a_controller_that_babbles_is_cut_off_and_the_flight_ends_well(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Only so many frames of it count. Whether its reports are among them is chance."""
    flight = fly(GRAPH, tmp_path, "babble_of_controller@0.8", speed=0.2, capsys=capsys)
    assert flight.facts["ended"] == "motors_stopped"
    assert flight.facts["touchdown_m_s"] < 1.5
    assert flight.failsafes() <= {0, MOTOR_LOST}
    assert flight.topics["esc_status"]["rejected"][-1] > 500
    assert len(set(flight.bench["commands"])) == 1, "every controller got every command"


@pytest.mark.long
def test_the_whole_flight_of_quad_can(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    flight = fly(QUAD_CAN, tmp_path, seconds=100, capsys=capsys)
    assert_flew_well(flight, 2.0)
    bench = flight.bench
    assert (len(set(bench["commands"])), max(bench["disordered"])) == (1, 0)
    assert (flight.bus["tx_lost"], flight.bus["rx_lost"]) == (0, 0)
