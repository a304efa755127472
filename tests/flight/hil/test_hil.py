"""HIL messages in both roles: our graph as the autopilot of another simulator, our world as the
simulator of another autopilot, and each with the other."""

from __future__ import annotations

import math
import socket
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest
from pyulog import ULog
from tests.flight.hil.peers import (
    ACCEL,
    ARMED,
    BARO,
    COMMAND,
    GYRO,
    LOCKSTEP,
    MAG,
    OUTDOOR,
    at_rest,
    command,
    connect,
    fix,
    flying,
    free_port,
    mavlink,
    sensor,
    serve,
)

from stator import HOME
from stator.__main__ import main
from stator.build.cmake import RECORDING, build, build_hil_simulator

if TYPE_CHECKING:
    from tests.flight.hil.peers import Ended, Peer

MISSIONS = HOME / "graph" / "missions"


@pytest.fixture(scope="module", autouse=True)
def _programs() -> None:
    build(OUTDOOR, "sitl", RECORDING, executor="virtual")
    build_hil_simulator()


def topic(log: Path, name: str) -> Any:
    return next(data.data for data in ULog(str(log)).data_list if data.name == name)


def row_at(samples: Any, time_us: int) -> int:
    return list(samples["timestamp_sample"]).index(time_us)


# --- each with the other ---


def both(folder: Path, *options: str) -> tuple[Ended, Ended]:
    """A mission in wind; the ends of the simulator and of the autopilot."""
    folder.mkdir()
    port = free_port()
    world = ["--hil", f"tcp:{port}", "--truth", str(folder / "truth"), "--wind", "3", *options]
    mission = ["--mission", str(MISSIONS / "square.yaml")]
    with command("simulate", *world) as simulator, flying(port, folder / "log.ulg", *mission) as us:
        pass
    return simulator, us


def test_our_autopilot_flies_in_our_simulator_and_each_time_alike(tmp_path: Path) -> None:
    simulator, autopilot = both(tmp_path / "one")
    assert (simulator.status, autopilot.status) == (0, 0), (simulator, autopilot)
    assert simulator.facts["success"]
    assert simulator.facts["touchdown_m_s"] < 1.0
    assert autopilot.facts["reason"].startswith("flown, and the motors stopped at")
    assert autopilot.facts["truth"] is None
    assert autopilot.facts["missed_life_signs"] == 0
    position = topic(tmp_path / "one" / "log.ulg", "vehicle_local_position")
    assert max(position["x"]) == pytest.approx(20.0, abs=1.5)  # it has flown its square of 20 m
    assert max(position["y"]) == pytest.approx(20.0, abs=1.5)
    assert abs(position["x"][-1]) < 1.5

    both(tmp_path / "two")
    for name in ("truth", "log.ulg"):
        first, second = ((tmp_path / run / name).read_bytes() for run in ("one", "two"))
        assert first == second, name
    both(tmp_path / "other", "--seed", "2")
    assert (tmp_path / "one" / "log.ulg").read_bytes() != (
        tmp_path / "other" / "log.ulg"
    ).read_bytes()

    assert main(["replay", str(tmp_path / "one" / "log.ulg")]) == 0


# --- our autopilot ---


def test_each_sensor_message_is_answered_once_with_its_time(tmp_path: Path) -> None:
    port, start_us = free_port(), 1_700_000_000_000_000  # another clock than the vehicle's
    with flying(port, tmp_path / "log.ulg", "--duration", "2.5") as autopilot, serve(port) as peer:
        assert peer.receive("HEARTBEAT").autopilot == mavlink.MAV_AUTOPILOT_PX4
        answers = at_rest(peer, 2.0, start_us)
        assert [answer.time_usec for answer in answers] == [
            start_us + 4000 * step for step in range(500)
        ]
        for answer in answers:  # it has no mission, so it does not arm
            assert answer.flags == LOCKSTEP
            assert answer.mode == mavlink.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
            assert answer.controls == [0.0] * 16
        at_rest(peer, 0.5, start_us + 2_000_000)
        peer.send(sensor(start_us + 2_600_000))
        assert peer.receive("HIL_ACTUATOR_CONTROLS") is None
    assert autopilot.status == 1
    assert autopilot.facts["reason"].startswith("--duration 2.5 s ended the flight early; motors ")
    assert "never started" in autopilot.facts["reason"]


def test_sensors_arrive_in_our_units_at_their_times(tmp_path: Path) -> None:
    port, log = free_port(), tmp_path / "log.ulg"
    with flying(port, log) as autopilot, serve(port) as peer:
        at_rest(peer, 0.1)
        numbers = {"xacc": 1.0, "yacc": 2.0, "zacc": -9.0, "xgyro": 0.1, "ygyro": 0.2, "zgyro": 0.3}
        peer.send(
            fix(1_700_000_000_000_000, north_m=1.0),  # of another clock
            sensor(100_000, ACCEL | GYRO | MAG, xmag=0.1, ymag=0.2, zmag=0.3, **numbers),
        )
        peer.receive("HIL_ACTUATOR_CONTROLS")
        peer.send(fix(45_000, north_m=3.0), sensor(104_000, BARO, abs_pressure=900.5, xgyro=7.0))
        peer.receive("HIL_ACTUATOR_CONTROLS")
        peer.send(sensor(108_000, ACCEL | GYRO | MAG, xgyro=math.nan, ymag=math.inf))
        peer.receive("HIL_ACTUATOR_CONTROLS")
        for time_us in (112_000, 116_000, 120_000):  # then the barometer's driver asks for it
            peer.send(sensor(time_us, ACCEL | GYRO))
            peer.receive("HIL_ACTUATOR_CONTROLS")
        at_rest(peer, 0.2, 124_000)
    assert autopilot.facts["lost_samples"] == 0
    gyro, accel, mag, baro, gps = (
        topic(log, f"sensor_{name}") for name in ("gyro", "accel", "mag", "baro", "gps")
    )
    row = row_at(gyro, 100_000)
    assert [gyro[f"xyz[{i}]"][row] for i in range(3)] == pytest.approx([0.1, 0.2, 0.3])
    row = row_at(accel, 100_000)
    assert [accel[f"xyz[{i}]"][row] for i in range(3)] == pytest.approx([1.0, 2.0, -9.0])
    row = row_at(mag, 100_000)
    assert [mag[f"xyz[{i}]"][row] for i in range(3)] == pytest.approx([0.1, 0.2, 0.3])
    row = row_at(baro, 104_000)
    assert baro["pressure"][row] == pytest.approx(90_050.0)
    assert baro["temperature"][row] == pytest.approx(20.0)
    for samples in (gyro, accel, mag):  # not of the barometer's message, nor what is not finite
        assert not {104_000, 108_000} & set(samples["timestamp_sample"])
    assert gps["latitude_deg"][row_at(gps, 100_000)] == pytest.approx(47.397742 + 9e-6, abs=1e-9)
    row = row_at(gps, 45_000)
    assert gps["latitude_deg"][row] == pytest.approx(47.397742 + 270e-7, abs=1e-9)
    assert gps["longitude_deg"][row] == pytest.approx(8.545594, abs=1e-9)
    assert gps["altitude_msl_m"][row] == pytest.approx(488.0)
    assert [gps[f"vel_{axis}_m_s"][row] for axis in "ned"] == pytest.approx([0.12, -0.34, 0.56])
    assert (gps["eph"][row], gps["epv"][row]) == pytest.approx((1.2, 2.4))
    assert gps["satellites_used"][row] == 11


def test_frames_in_parts_and_noise_change_nothing(tmp_path: Path) -> None:
    logs = []
    for name, noise in (("whole", b""), ("parts", b"\xfd\x09noise \x00\xfe")):
        port, log = free_port(), tmp_path / f"{name}.ulg"
        with flying(port, log) as autopilot, serve(port) as peer:

            def in_parts(message: Any, peer: Peer = peer, noise: bytes = noise) -> None:
                data = noise + peer.packed(message)
                for at in range(0, len(data), 11):
                    peer.connection.sendall(data[at : at + 11])

            at_rest(peer, 1.0, send=in_parts if noise else None)
        assert autopilot.status == 1
        logs.append(log.read_bytes())
    assert logs[0] == logs[1]
    assert len(logs[0]) > 50_000


def test_a_lost_connection_ends_the_flight_in_order(tmp_path: Path) -> None:
    port, log = free_port(), tmp_path / "log.ulg"
    with flying(port, log) as autopilot, serve(port) as peer:
        at_rest(peer, 1.0)
        peer.connection.sendall(peer.packed(sensor(1_000_000))[:20])  # in the middle of a frame
    assert autopilot.status == 1
    reason = "the simulator closed the connection at 0.996 s, with the motors stopped"
    assert autopilot.facts["reason"] == reason
    assert not autopilot.facts["success"]
    assert topic(log, "vehicle_status")["timestamp"][-1] > 900_000  # the log is whole
    assert autopilot.facts["unrecorded_activations"] == 0


def test_a_clock_that_goes_back_or_jumps_is_refused(tmp_path: Path) -> None:
    for name, wrong_us in (("back", 90_000), ("far", 90_000_000)):
        port = free_port()
        with flying(port, tmp_path / f"{name}.ulg") as autopilot, serve(port) as peer:
            at_rest(peer, 0.1)
            peer.send(sensor(wrong_us))
            assert peer.receive("HIL_ACTUATOR_CONTROLS") is None
        assert autopilot.status == 1
        wanted = f"HIL_SENSOR.time_usec: expected 96000 us, or at most 60 s more, found {wrong_us}"
        assert autopilot.facts["reason"].startswith(wanted)


@pytest.mark.parametrize(
    ("options", "error"),
    [
        (["--hil", "udp:4560"], "expected tcp:PORT or tcp:HOST:PORT, found 'udp:4560'"),
        (["--hil", "tcp:70000"], "expected tcp:PORT or tcp:HOST:PORT, found 'tcp:70000'"),
        (["--hil", "tcp:4560", "--wind", "3"], "error: --wind: not with --hil"),
        (["--hil", "tcp:4560", "--speed", "3"], "error: --speed: not with --hil"),
        (
            [str(HOME / "graph" / "quad.yaml"), "--hil", "tcp:4560"],
            "error: --hil: no HIL message feeds the device 'mocap0' of",
        ),
    ],
)
def test_what_cannot_be_is_an_error(
    options: list[str], error: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main(["fly", *options])
    except SystemExit as ended:
        status = int(str(ended.code))
    assert status == 2
    assert error in capsys.readouterr().err


# --- our simulator ---


def controls(time_us: int, mode: int, *motors: float) -> Any:
    return mavlink.MAVLink_hil_actuator_controls_message(
        time_usec=time_us,
        controls=[*motors, *[0.0] * (16 - len(motors))],
        mode=mode,
        flags=LOCKSTEP,
    )


def test_our_simulator_says_what_a_vehicle_at_rest_measures(tmp_path: Path) -> None:
    port, truth = free_port(), str(tmp_path / "truth")
    with (
        command("simulate", "--hil", f"tcp:{port}", "--truth", truth) as simulator,
        connect(port) as peer,
    ):
        seen = []
        for _ in range(250):
            seen.append(peer.receive("HIL_SENSOR"))
            peer.send(controls(seen[-1].time_usec, 1, *[1.0] * 4))  # not armed
    assert [message.time_usec for message in seen] == [4000 * step for step in range(250)]
    assert all(message.fields_updated & (ACCEL | GYRO) == ACCEL | GYRO for message in seen)
    assert sum(message.fields_updated & MAG == MAG for message in seen) == 100
    assert sum(message.fields_updated & BARO == BARO for message in seen) == 50
    level = [sum(getattr(message, f"{axis}acc") for message in seen) / 250 for axis in "xyz"]
    assert level == pytest.approx([0.0, 0.0, -9.80665], abs=0.1)
    newest = next(message for message in reversed(seen) if message.fields_updated & BARO)
    assert newest.abs_pressure == pytest.approx(956.0, abs=5.0)  # hPa
    assert newest.pressure_alt == pytest.approx(488.0, abs=40.0)
    newest = next(message for message in reversed(seen) if message.fields_updated & MAG)
    assert math.hypot(newest.xmag, newest.ymag, newest.zmag) == pytest.approx(0.484, abs=0.05)
    assert simulator.status == 1
    assert simulator.facts["reason"].startswith(
        "the autopilot closed the connection before the take-off, at 1.00 s"
    )


def test_our_simulator_obeys_only_an_armed_autopilot(tmp_path: Path) -> None:
    """Full thrust lifts it; an autopilot that then goes away has left it in flight."""
    port, truth = free_port(), str(tmp_path / "truth")
    with (
        command("simulate", "--hil", f"tcp:{port}", "--truth", truth) as simulator,
        connect(port) as peer,
    ):
        for step in range(375):
            message = peer.receive("HIL_SENSOR")
            armed = ARMED if step > 250 else 0
            peer.send(controls(message.time_usec, 1 | armed, *[0.9] * 4))
    assert simulator.status == 1
    assert simulator.facts["take_off_s"] == pytest.approx(1.05, abs=0.05)
    assert simulator.facts["reason"].startswith("the autopilot closed the connection in flight, at")


def test_our_simulator_lives_in_real_time_for_an_autopilot_without_lockstep(tmp_path: Path) -> None:
    port, truth = free_port(), str(tmp_path / "truth")
    with (
        command("simulate", "--hil", f"tcp:{port}", "--truth", truth) as simulator,
        connect(port) as peer,
    ):
        free = controls(0, 1)
        free.flags = 0
        peer.receive("HIL_SENSOR")
        peer.send(free)
        while peer.receive("HIL_SENSOR").time_usec < 200_000:  # goes on without answers
            pass
    assert simulator.facts["speed_vs_real_time"] < 1.2


def test_a_busy_port_is_named() -> None:
    with socket.create_server(("127.0.0.1", 0)) as server:
        port = server.getsockname()[1]
        finished = subprocess.run(
            [*COMMAND, "simulate", "--hil", f"tcp:{port}"],
            capture_output=True,
            text=True,
            check=False,
        )
    assert finished.returncode == 2
    assert finished.stderr == f"error: --hil 'tcp:{port}': Address already in use\n"
