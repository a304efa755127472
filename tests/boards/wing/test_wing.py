"""The plant of aeroplanes against published figures, and against what must be."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import pytest
from tests.boards.wing.flight_mechanics import SERVOS, Mechanics
from tests.boards.wing.plant_bench import ask, vehicle_of, words

if TYPE_CHECKING:
    from pathlib import Path

    from tests.boards.wing.flight_mechanics import Modes

AT_100_M = 1.2133  # kg/m^3
SEA = 1.225

# Vehicle, density, speed; angle of attack and elevator in degrees, CL, CD. Computed from each
# table by a program that shares nothing with the plant. The laboratory's own JSBSim model of the
# Ultra Stick, flown until steady, gives at 13.07 m/s 6.18 deg, 0.591, 0.0558; at 16.95 m/s
# 3.18 deg, 0.355, 0.0458; at 19.95 m/s 1.93 deg, 0.256, 0.0444. The X8's own script gives L/D 9.5
# at 1.77 deg.
TRIMS = {
    "ultra_stick_25e 13": (AT_100_M, 6.27, -6.49, 0.599, 0.0560),
    "ultra_stick_25e 17": (AT_100_M, 3.12, -4.11, 0.351, 0.0456),
    "ultra_stick_25e 20": (AT_100_M, 1.89, -3.18, 0.254, 0.0442),
    "aerosonde 25": (1.2682, 2.85, -7.1, 0.493, 0.0507),
    "x8 18": (SEA, 1.77, 2.1, 0.221, 0.0233),
}
# Short period, phugoid and dutch roll as rad/s and damping ratio; roll and spiral in 1/s. From the
# same program.
MODES = {
    "ultra_stick_25e 13": ((11.1, 0.80), (0.73, 0.084), (4.26, 0.34), -12.2, 0.011),
    "ultra_stick_25e 17": ((14.5, 0.80), (0.56, 0.13), (5.44, 0.34), -16.1, -0.019),
    "ultra_stick_25e 20": ((17.1, 0.80), (0.48, 0.18), (6.34, 0.33), -18.9, -0.026),
    "aerosonde 25": ((11.0, 0.44), (0.50, 0.07), (4.8, 0.24), -22.4, 0.089),
}


def mechanics(case: str, folder: Path) -> tuple[Mechanics, float]:
    name, speed = case.split()
    return Mechanics(vehicle_of(name), TRIMS[case][0], folder), float(speed)


@pytest.mark.parametrize("case", TRIMS)
def test_trim_as_published(case: str, tmp_path: Path) -> None:
    model, speed = mechanics(case, tmp_path)
    trim = model.trim(speed)
    _, alpha, elevator, lift, drag = TRIMS[case]
    # Half of the last digit that is given, and half a percent.
    assert math.degrees(trim.alpha) == pytest.approx(alpha, abs=0.01)
    assert math.degrees(trim.elevator) == pytest.approx(elevator, abs=0.02)
    assert trim.lift == pytest.approx(lift, rel=0.005)
    assert trim.drag == pytest.approx(drag, rel=0.005)


@pytest.mark.parametrize("case", MODES)
def test_modes_as_published(case: str, tmp_path: Path) -> None:
    model, speed = mechanics(case, tmp_path)
    modes: Modes = model.modes(speed, model.trim(speed))
    short_period, phugoid, dutch_roll, roll, spiral = MODES[case]
    for found, due in (
        (modes.short_period, short_period),
        (modes.phugoid, phugoid),
        (modes.dutch_roll, dutch_roll),
    ):
        assert found == pytest.approx(due, rel=0.005, abs=0.01)
    assert modes.roll == pytest.approx(roll, rel=0.005)
    assert modes.spiral == pytest.approx(spiral, abs=0.001)


def wing_forces(alpha_deg: float, folder: Path, **more: float) -> tuple[float, ...]:
    """CL, CD, Cl, Cm of the Ultra Stick at 20 m/s."""
    vehicle = vehicle_of("ultra_stick_25e")
    assert vehicle.wing is not None
    alpha = math.radians(alpha_deg)
    motion = (20.0 * math.cos(alpha), 0.0, 20.0 * math.sin(alpha), more.get("p", 0.0), 0.0, 0.0)
    deflections = [more.get("aileron", 0.0), more.get("elevator", 0.0)] + [0.0] * (SERVOS - 2)
    (found,) = ask(vehicle, [f"wing {words(*motion, SEA, *deflections)}"], folder)
    size = 0.5 * SEA * 400.0 * vehicle.wing.area
    x, z = found[0], found[2]
    pitch = found[4] + vehicle.wing.reference[0] * z
    return (
        (x * math.sin(alpha) - z * math.cos(alpha)) / size,
        -(x * math.cos(alpha) + z * math.sin(alpha)) / size,
        found[3] / size / vehicle.wing.span,
        pitch / size / vehicle.wing.chord,
    )


def test_stalls_as_in_the_tunnel(tmp_path: Path) -> None:
    """NASA's tunnel, the Ultra Stick 120: UltraStick120_Aero.mat."""
    for alpha, lift, drag, pitch in ((15.5, 0.944, 0.211, -0.288), (32.0, 1.011, 0.639, -0.474)):
        found = wing_forces(alpha, tmp_path)
        assert found[0] == pytest.approx(lift, abs=1e-6)
        assert found[1] == pytest.approx(drag, abs=1e-6)
        assert found[3] == pytest.approx(pitch, abs=1e-6)
        mirrored = wing_forces(-alpha, tmp_path)
        assert mirrored[0] == pytest.approx(-lift, abs=1e-6)
        assert mirrored[3] == pytest.approx(-pitch, abs=1e-6)
    # The largest lift is in the blend, and the nose goes down behind it.
    lifts = [wing_forces(alpha, tmp_path)[0] for alpha in (10.0, 12.0, 13.0, 15.0)]
    assert max(lifts) == pytest.approx(1.05, abs=0.03)
    # 25 deg of aileron: 0.066 of roll at -3 deg, 0.035 at 19.5 deg, 0.015 from 30 deg on.
    for alpha, roll in ((-3.0, 0.066), (19.5, 0.035), (32.0, 0.015)):
        found = wing_forces(alpha, tmp_path, aileron=math.radians(25.0))
        assert -found[2] == pytest.approx(roll, abs=0.008)
    # p b / 2V = 0.063: it damps by 0.025 before the stall, and drives itself by 0.002 in it.
    rolling = 0.063 * 2.0 * 20.0 / 1.27
    assert wing_forces(10.0, tmp_path, p=rolling)[2] == pytest.approx(-0.0265, abs=0.002)
    assert wing_forces(27.0, tmp_path, p=rolling)[2] == pytest.approx(0.002, abs=0.0005)


def test_propeller_as_in_the_tunnel(tmp_path: Path) -> None:
    """Static thrust and thrust in flight at full throttle: 14.2 N, 11.7 N at 10 m/s, 7.9 N at
    17 m/s, by the laboratory's curves of the APC 12x6E and its motor at 100 m."""
    vehicle = vehicle_of("ultra_stick_25e")
    for speed, thrust in ((0.0, 14.2), (10.0, 11.7), (17.0, 7.9)):
        low, high = 300.0, 1500.0
        for _ in range(25):
            middle = 0.5 * (low + high)
            line = f"propeller {words(speed, 0, 0, 0, 0, 0, AT_100_M, middle, 240.2)}"
            (found,) = ask(vehicle, [line], tmp_path)
            low, high = (middle, high) if found[6] > 0.0 else (low, middle)
        assert math.hypot(*found[:3]) == pytest.approx(thrust, abs=0.15)
        # It turns clockwise, so its motor rolls the vehicle to the left; and so does its thrust,
        # which points to the right below the centre of mass.
        motor = 240.2 / middle * math.cos(math.radians(3.0))
        assert found[3] == pytest.approx(-motor - 0.046 * found[1], rel=1e-6)


def at(answer: list[float]) -> dict[str, float]:
    """What `until` answers, by name."""
    w, x, y, z = answer[6:10]
    return {
        "north": answer[0],
        "height": -answer[2],
        "speed": math.hypot(*answer[3:6]),
        "pitch": math.degrees(math.asin(2.0 * (w * y - x * z))),
        "yaw": math.degrees(math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))),
        "propeller": answer[13],
        "elevator": answer[15],
        "felt_x": answer[22],
        "felt_z": answer[24],
        "pressure": answer[28],
        "density": answer[29],
        "on_ground": answer[30],
        "remaining": answer[31],
    }


def fly(name: str, lines: list[str], folder: Path) -> list[dict[str, float]]:
    return [at(answer) for answer in ask(vehicle_of(name), lines, folder) if answer]


@pytest.mark.parametrize("name", ["ultra_stick_25e", "aerosonde", "x8"])
def test_stands_at_rest_into_the_wind(name: str, tmp_path: Path) -> None:
    lines = ["world --wind-from 90", "until 0.002", "until 3"]
    begin, end = fly(name, lines, tmp_path)
    for moment in (begin, end):
        assert moment["yaw"] == pytest.approx(90.0, abs=2.01)
        assert moment["height"] == pytest.approx(0.0, abs=1e-3)
        assert moment["speed"] < 1e-3
        assert math.hypot(moment["felt_x"], moment["felt_z"]) == pytest.approx(9.80665, abs=0.01)
    assert end["pitch"] == pytest.approx(begin["pitch"], abs=0.01)
    assert begin["density"] == pytest.approx(1.1686, abs=1e-4)  # ISO 2533 at 488 m


def test_waits_on_its_brakes_and_rolls_when_the_motor_may_turn(tmp_path: Path) -> None:
    lines = ["world --wind 8", "until 0.002", "until 5", "throttle 0", "until 10"]
    begin, waited, rolled = fly("ultra_stick_25e", lines, tmp_path)
    assert waited["north"] == pytest.approx(begin["north"], abs=1e-3)
    assert rolled["north"] < begin["north"] - 1.0  # the wind pushes it back
    assert waited["pressure"] == pytest.approx(0.5 * 1.1686 * 64.0, rel=0.15)


def test_takes_off_within_its_run(tmp_path: Path) -> None:
    """At full throttle 14 N on 1.96 kg: 10 m/s after about 9 m."""
    lines = ["world", "until 1", "throttle 1", "servos 0 -0.1 0 0 0 0 0 0"]
    times = [1.0 + 0.1 * i for i in range(1, 40)]
    moments = fly("ultra_stick_25e", [*lines, *(f"until {time:.2f}" for time in times)], tmp_path)
    start = moments[0]
    airborne = next(m for m in moments if m["on_ground"] == 0.0)
    assert 8.0 < airborne["speed"] < 12.0
    assert 5.0 < airborne["north"] - start["north"] < 14.0
    assert moments[-1]["remaining"] < 1.0


def test_the_tail_wheel_steers_with_the_rudder(tmp_path: Path) -> None:
    lines = ["world", "until 1", "throttle 0.3", "servos 0 0 RUDDER 0 0 0 0 0", "until 2.5"]
    for rudder, sign in ((0.5, -1.0), (-0.5, 1.0)):
        steered = [line.replace("RUDDER", str(rudder)) for line in lines]
        begin, end = fly("ultra_stick_25e", steered, tmp_path)
        assert end["speed"] < 6.0  # the air does little
        assert sign * (end["yaw"] - begin["yaw"]) > 5.0


@pytest.mark.parametrize(
    ("launch", "speed", "felt"), [("catapult", 15.0, 50.0), ("hand", 8.0, 25.0)]
)
def test_is_launched_once_its_motor_may_turn(
    launch: str, speed: float, felt: float, tmp_path: Path
) -> None:
    lines = [f"world --launch {launch}", "until 5", "throttle 0.6"]
    times = [5.0 + 0.01 * i for i in range(1, 160)]
    moments = fly("ultra_stick_25e", [*lines, *(f"until {time:.2f}" for time in times)], tmp_path)
    held, later = moments[0], moments[1:]
    assert held["height"] > 1.4
    assert held["speed"] == 0.0
    first = next(i for i, moment in enumerate(later) if moment["speed"] > 0.0)
    assert times[first] == pytest.approx(6.0, abs=0.03)  # 1 s after the command
    thrown = max(moment["felt_x"] for moment in later)
    assert thrown == pytest.approx(felt + 9.81 * math.sin(math.radians(10.0)), abs=1.0)
    free = next(m for m in later[first + 1 :] if m["felt_x"] < 0.5 * felt)
    assert free["speed"] == pytest.approx(speed, rel=0.05)


FLOWN = ["--launch catapult", "throttle 0.6", "servos -0.04 -0.15 0 0 0 0 0 0"]


def pressures(fault: str, folder: Path) -> list[tuple[float, float]]:
    """What a pitot tube reads in a flight in which it goes wrong at 4 s, and the airspeed."""
    options, *commands = FLOWN
    lines = [f"world {options} {fault}", "until 0.1", *commands]
    times = [2.5 + 0.5 * i for i in range(8)]
    moments = fly("ultra_stick_25e", [*lines, *(f"until {time}" for time in times)], folder)
    return [(m["pressure"], 0.5 * m["density"] * m["speed"] ** 2) for m in moments[1:]]


def test_a_pitot_tube_reads_the_airspeed_and_goes_wrong_as_tubes_do(tmp_path: Path) -> None:
    for read, due in pressures("", tmp_path):
        assert read == pytest.approx(due, rel=0.06, abs=10.0)
    healthy = dict(enumerate(pressures("", tmp_path)))
    for fault, holds in {
        "blocked": lambda read, due: abs(read) < 10.0,
        "ice=1": lambda read, due: abs(read) < 10.0,
        "trapped": lambda read, due: abs(read - due) > 5.0,
        "static_blocked": lambda read, due: abs(read - due) > 5.0,
    }.items():
        found = pressures(f"--fail airspeed0.{fault}@4", tmp_path)
        for i, (read, due) in enumerate(found):
            if i < 3:
                assert (read, due) == healthy[i]
            elif i > 5:
                assert holds(read, due), (fault, found)


def test_servos_turn_at_their_rate_and_fail(tmp_path: Path) -> None:
    lines = ["world --fail servo_2.stuck@2 --fail servo_1.loss@2", "until 1"]
    lines += ["servos 1 1 1 0 0 0 0 0", "until 1.1", "until 2.001", "servos -1 -1 -1 0 0 0 0 0"]
    answers = ask(vehicle_of("ultra_stick_25e"), [*lines, "until 3"], tmp_path)
    turning, after = answers[3], answers[-1]
    assert turning[14:17] == pytest.approx([math.radians(15.0)] * 3, abs=math.radians(0.2))
    whole = math.radians(25.0)
    assert after[14:17] == pytest.approx([0.0, whole, -whole], abs=1e-6)
