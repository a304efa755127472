"""A ground station connects to a simulated flight, and flies it."""

from __future__ import annotations

import socket
import subprocess
from typing import TYPE_CHECKING

import pytest
from tests.flight.mavlink.vehicle import (
    COMMAND,
    HANGS_S,
    NAN,
    OUTDOOR,
    Station,
    flying,
    free_port,
    met,
)

if TYPE_CHECKING:
    from pathlib import Path

from pymavlink.dialects.v20 import common as mavlink

SPEED = ("--speed", "5")


def test_a_flight_by_commands_which_replays(tmp_path: Path) -> None:
    log = tmp_path / "flight.ulg"
    with met(log) as (station, facts):
        beat = station.wait("HEARTBEAT")
        assert (beat.autopilot, beat.type) == (mavlink.MAV_AUTOPILOT_PX4, 2)
        assert station.command(31999) == mavlink.MAV_RESULT_UNSUPPORTED
        station.take_off()
        refused = station.command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 0)
        assert refused == mavlink.MAV_RESULT_TEMPORARILY_REJECTED
        station.wait_mode("LOITER")
        there = station.place(15.0, 5.0)
        here = station.wait("GLOBAL_POSITION_INT")
        station.link.mav.command_int_send(
            1, 1, 0, mavlink.MAV_CMD_DO_REPOSITION, 0, 0, -1, 1, 0, NAN, *there, here.alt * 1e-3
        )
        assert station.wait("COMMAND_ACK").result == mavlink.MAV_RESULT_ACCEPTED
        station.wait(
            "GLOBAL_POSITION_INT",
            lambda p: abs(p.lat - there[0]) < 100 and abs(p.lon - there[1]) < 150,
        )
        station.accept(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH)
        station.wait_mode("RTL")
        station.wait_armed(False)
        station.take_off()  # again
        station.accept(mavlink.MAV_CMD_NAV_LAND)
        station.wait_armed(False)
    assert facts["success"], facts["reason"]
    assert facts["refused_publications"] == 0
    replayed = subprocess.run(
        [*COMMAND, "replay", str(log)], capture_output=True, text=True, check=False
    )
    assert replayed.returncode == 0, replayed.stdout + replayed.stderr


@pytest.mark.parametrize(
    "place",
    ["udp", "udp:0", "udp:70000", "udp:nowhere:14550", "tcp:x", "serial:/dev/null", "14550"],
)
def test_what_no_place_is_shows_the_forms(place: str) -> None:
    finished = subprocess.run(
        [*COMMAND, "fly", str(OUTDOOR), "--mavlink", place],
        capture_output=True,
        text=True,
        check=False,
        timeout=HANGS_S,
    )
    assert finished.returncode == 2
    assert f"expected udp:[HOST:]PORT, tcp:PORT or serial:PATH:BAUD, found '{place}'" in (
        finished.stderr
    )


def test_a_busy_port_is_an_error() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        finished = subprocess.run(
            [*COMMAND, "fly", str(OUTDOOR), "--mavlink", f"tcp:{port}"],
            capture_output=True,
            text=True,
            check=False,
        )
    assert finished.returncode == 2
    assert f"error: --mavlink 'tcp:{port}': Address already in use" in finished.stderr


def test_a_graph_without_the_app_is_refused() -> None:
    finished = subprocess.run(
        [*COMMAND, "fly", str(OUTDOOR.with_name("quad.yaml")), "--mavlink", "udp:14550"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert finished.returncode == 2
    assert "error: missing node of app 'mavlink' in graph/quad.yaml" in finished.stderr


@pytest.mark.parametrize(
    ("options", "error"),
    [
        (["--lockstep", "s"], "error: --lockstep: missing --mavlink\n"),
        (["--mavlink", "udp:14550", "--lockstep", "s", "--speed", "2"], "error: --speed: not with"),
        (["--mavlink", "udp:14550", "--lockstep", "/none"], "--lockstep '/none': No such file"),
        (["--mavlink", "udp:14550", "--lockstep", "x" * 200], "expected a path of at most 107"),
    ],
)
def test_a_lockstep_that_cannot_be_is_an_error(options: list[str], error: str) -> None:
    command = [*COMMAND, "fly", str(OUTDOOR), *options]
    finished = subprocess.run(command, capture_output=True, text=True, check=False)
    assert finished.returncode == 2
    assert error in finished.stderr


def test_two_flights_in_lockstep_are_equal(tmp_path: Path) -> None:
    logs = [tmp_path / name for name in ("one.ulg", "two.ulg")]
    for log in logs:
        with met(log) as (station, _):
            station.take_off()
    assert logs[0].read_bytes() == logs[1].read_bytes()


def test_a_client_of_a_listening_port(tmp_path: Path) -> None:
    port = free_port(socket.SOCK_STREAM)
    with flying(tmp_path / "tcp.ulg", "--mavlink", f"tcp:{port}", *SPEED) as facts:
        station = Station(f"tcp:127.0.0.1:{port}")
        station.connect()
        station.close()
        station = Station(f"tcp:127.0.0.1:{port}", system=251)  # the next one
        station.connect()
        station.accept(mavlink.MAV_CMD_REQUEST_MESSAGE, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
        station.close()
    assert facts["success"], facts["reason"]
