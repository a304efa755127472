"""What must be true of every flight, whatever was asked of it; and the first of it that was not.

A flight is judged by the truth. The log says what the software did and believed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from stator.build.cpp_source import constant
from stator.flight import log as flight_log
from stator.flight.judge import UPSIDE_DOWN_DEG, place
from stator.flight.log import ARMED, MODES, NAV_STATES, UnreadableFlight, newest

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from numpy.typing import NDArray
    from pyulog import ULog

    from stator.flight.log import Floats

    Rows = NDArray[np.bool_]

# The software may stop the motors from this height down.
LOW_M = 0.5
# Beyond this tilt a vehicle on the ground is on its side or upside down.
FALLEN_DEG = 60.0
MOST_TURNING_S = 5.0
# Slower than any motor that is commanded: its driver has stopped it.
STANDS_RAD_S = 5.0
# A vehicle that stood for so long and then leaves the ground takes off; less is a bounce.
STOOD_S = 1.0
AIRBORNE_M = 0.3
ASKED_BEFORE_S = 2.0
# Beyond the fence: reaction and lag, and the deceleration of a careful turn; the estimate is off,
# too. A stronger wind carries the vehicle wherever it steers.
FENCE_MARGIN_M, FENCE_REACTION_S, BRAKING_M_S2, CARRIES_M_S = 5.0, 1.0, 2.0, 12.0
MOST_WITHOUT_ESTIMATE_S = 1.0
MOST_WRONG_S, MOST_DEVIATIONS = 2.0, 5.0
EARTH = "boards/world/world/earth.hpp"
METRES_PER_DEGREE = 111_320.0
BY_HAND = ("manual", "stabilized", "altitude", "position")
ATTITUDE_BY_HAND = ("manual", "stabilized")


@dataclass(frozen=True)
class Setting:
    """What the flight was flown with. By default nothing is known of it."""

    needs: Mapping[int, frozenset[str]] = field(default_factory=dict)  # of each flight mode
    fence_radius: float = 0.0  # m; 0: none
    fence_height: float = 0.0
    origin: tuple[float, float] | None = None  # of the world, in deg; None: the usual one
    # From when on a failure takes away the means to steer, and from when on one shows in no sensor.
    cannot_steer_s: float = math.inf
    unseen_s: float = math.inf


class Broken(NamedTuple):
    name: str
    time_s: float
    position: Floats
    text: str

    def as_json(self) -> dict[str, object]:
        position = [float(x) for x in self.position]
        return {"name": self.name, "time_s": self.time_s, "position_m": position}

    def in_words(self) -> str:
        return f"{self.name} at {self.time_s:.2f} s, {place(self.position)}: {self.text}"


class _Course:
    """The truth, and what the log says, at the times of the truth."""

    def __init__(self, log: ULog, truth: Mapping[str, Floats], ended: str) -> None:
        self.log, self.ended = log, ended
        self._rows: dict[str, NDArray[np.int64]] = {}  # of each topic, the newest at each time
        self.time_s = truth["time_us"] * 1e-6
        self.position = np.column_stack([truth[f"position_{axis}"] for axis in "ned"])
        self.velocity = np.column_stack([truth[f"velocity_{axis}"] for axis in "ned"])
        self.wind = np.hypot(truth["wind_n"], truth["wind_e"])
        self.height = self.position[0, 2] - self.position[:, 2]
        level = 1.0 - 2.0 * (truth["q_x"] ** 2 + truth["q_y"] ** 2)
        self.tilt_deg = np.degrees(np.arccos(np.clip(level, -1.0, 1.0)))
        q = [truth[f"q_{axis}"] for axis in "wxyz"]
        self.heading = np.arctan2(
            2.0 * (q[0] * q[3] + q[1] * q[2]), 1.0 - 2.0 * (q[2] ** 2 + q[3] ** 2)
        )
        self.on_ground: Rows = np.not_equal(truth["on_ground"], 0.0)
        self.mode = self.at("vehicle_status", "nav_state", -1.0)
        self.armed: Rows = np.equal(self.at("vehicle_status", "arming_state", 0.0), ARMED)
        self.failsafe: Rows = np.not_equal(self.at("vehicle_status", "failsafe", 0.0), 0.0)
        self.turning = self._turning()
        rotors = [speed for name, speed in truth.items() if name.startswith("rotor_")]
        fastest = np.max(rotors, axis=0) if rotors else np.full(self.time_s.size, math.inf)
        self.spinning: Rows = np.greater(fastest, STANDS_RAD_S)

    def has(self, topic: str) -> bool:
        return any(data.name == topic and data.multi_id == 0 for data in self.log.data_list)

    def at(self, topic: str, key: str, before: float = math.nan) -> Floats:
        """A field at the times of the truth; `before` its first sample, and without the topic."""
        values = np.full(self.time_s.size, before)
        if not self.has(topic):
            return values
        data = flight_log.topic(self.log, topic)
        if topic not in self._rows:
            stamp = flight_log.seconds(data["timestamp"])
            self._rows[topic] = np.searchsorted(stamp, self.time_s, side="right") - 1
        rows = self._rows[topic]
        if key in data:
            values[rows >= 0] = data[key][rows[rows >= 0]].astype(np.float64)
        return values

    def _turning(self) -> Rows:
        """Whether the software lets a motor turn."""
        if not self.has("actuator_motors"):
            armed: Rows = self.armed
            return armed
        commands = np.column_stack([self.at("actuator_motors", f"control[{i}]") for i in range(12)])
        turning: Rows = np.sum(np.isfinite(commands), axis=1) > 0
        return turning

    def is_in(self, modes: tuple[str, ...]) -> Rows:
        rows: Rows = np.isin(self.mode, [MODES[mode] for mode in modes])
        return rows

    def broken(self, name: str, row: int, text: str) -> Broken:
        return Broken(name, float(self.time_s[row]), self.position[row], text)

    def mode_name(self, row: int) -> str:
        return NAV_STATES.get(int(self.mode[row]), "unknown")


def first_broken(
    log: ULog, truth: Mapping[str, Floats], ended: str, setting: Setting
) -> Broken | None:
    """The first invariant that the flight broke. `ended`: how the flight program ended."""
    course = _Course(log, truth, ended)
    if not np.isfinite(course.position).all():
        raise UnreadableFlight("the state of the simulated vehicle is not finite")
    found = [check(course, setting) for check in CHECKS]
    return min((b for b in found if b is not None), key=lambda b: b.time_s, default=None)


# --- the list ---


def _stopped_in_the_air(course: _Course, _: Setting) -> Broken | None:
    """The software stops no motor above 0.5 m, except by kill or termination."""
    stops = course.turning[:-1] & ~course.turning[1:]
    allowed = course.mode[1:] == MODES["termination"]
    rows = np.flatnonzero(stops & ~allowed & (course.height[1:] > LOW_M)) + 1
    if rows.size == 0:
        return None
    row = int(rows[0])
    text = f"the motors stopped {course.height[row]:.1f} m up in mode {course.mode_name(row)}"
    return course.broken("motors_stopped_in_the_air", row, text)


def _turning_after_a_crash(course: _Course, _: Setting) -> Broken | None:
    """The motors turn for at most 5 s after the vehicle is down, upside down or on its side."""
    down = (
        course.turning & course.spinning & (course.height < LOW_M) & (course.tilt_deg > FALLEN_DEG)
    )
    row = _lasting(course.time_s, down, MOST_TURNING_S)
    if row is None:
        return None
    how = "upside down" if course.tilt_deg[row] > UPSIDE_DOWN_DEG else "on its side"
    text = f"the motors still turn, and the vehicle has been {how} for {MOST_TURNING_S:g} s"
    return course.broken("motors_turn_after_a_crash", row, text)


def _unasked_take_off(course: _Course, _: Setting) -> Broken | None:
    """Nothing leaves the ground that no pilot and no mission started."""
    if not course.has("manual_control_setpoint"):
        return None  # a fixed sequence starts by itself
    throttle = course.at("manual_control_setpoint", "throttle", -1.0)
    by_stick = course.is_in(BY_HAND) & (throttle > 0.0)
    by_stick |= course.is_in(ATTITUDE_BY_HAND) & (throttle > -0.5)
    asked = (course.is_in(("mission", "takeoff", "offboard")) & ~course.failsafe) | by_stick
    last_asked = np.maximum.accumulate(np.where(asked, course.time_s, -np.inf))
    still = course.on_ground & (np.linalg.norm(course.velocity, axis=1) < 0.5)
    stood_from, left_s = None, -math.inf
    stood = False
    for row in range(course.time_s.size):
        now = course.time_s[row]
        if still[row]:
            stood_from = now if stood_from is None else stood_from
            stood = stood or now - stood_from >= STOOD_S
            left_s = now
        elif not course.on_ground[row]:
            stood_from = None
        if stood and course.height[row] > AIRBORNE_M and course.turning[row]:
            stood = False
            if last_asked[row] < left_s - ASKED_BEFORE_S:
                text = f"it left the ground in mode {course.mode_name(row)}, and no pilot or "
                return course.broken("unasked_take_off", row, text + "mission asked for it")
    return None


def _outside_the_fence(course: _Course, setting: Setting) -> Broken | None:
    """The vehicle does not pass the fence by more than its braking distance while it can steer."""
    armed = np.flatnonzero(course.armed)
    if armed.size == 0:
        return None
    home = course.position[armed[0]]
    offset = course.position - home
    away = np.linalg.norm(offset[:, :2], axis=1)
    outward = np.sum(offset[:, :2] * course.velocity[:, :2], axis=1) / np.maximum(away, 1.0)
    beyond = np.zeros_like(away)
    speed = np.zeros_like(away)
    if setting.fence_radius > 0.0:
        beyond, speed = away - setting.fence_radius, outward
    if setting.fence_height > 0.0:
        over = -offset[:, 2] - setting.fence_height
        higher = over > beyond
        beyond = np.where(higher, over, beyond)
        speed = np.where(higher, -course.velocity[:, 2], speed)
    knows = course.at("vehicle_local_position", "xy_valid", 0.0) != 0.0
    steers = course.armed & knows & ~course.is_in((*ATTITUDE_BY_HAND, "descend"))
    steers &= (course.wind < CARRIES_M_S) & (course.time_s < setting.cannot_steer_s)
    steers &= course.time_s < setting.unseen_s
    fastest = 0.0
    for row in np.flatnonzero(beyond > 0.0):
        if not steers[row]:
            fastest = 1e3  # it begins to brake from wherever it got
        elif beyond[row - 1] <= 0.0 or fastest == 0.0:
            fastest = max(float(speed[row]), 0.0)
        braking = FENCE_REACTION_S * fastest + fastest**2 / (2.0 * BRAKING_M_S2)
        if steers[row] and beyond[row] > FENCE_MARGIN_M + braking:
            mode = course.mode_name(int(row))
            text = f"{beyond[row]:.1f} m outside the fence in mode {mode}"
            return course.broken("outside_the_fence", int(row), text)
    return None


def _armed_at_the_end(course: _Course, _: Setting) -> Broken | None:
    """Each flight ends disarmed."""
    if course.ended == "restart" or not course.armed[-1]:
        return None
    text = f"the flight ended armed in mode {course.mode_name(-1)}"
    return course.broken("armed_at_the_end", -1, text)


def _mode_without_estimate(course: _Course, setting: Setting) -> Broken | None:
    """A mode that needs an estimate is left within 1 s of losing it."""
    if not setting.needs or not course.has("vehicle_local_position"):
        return None
    stamp = flight_log.seconds(flight_log.topic(course.log, "vehicle_local_position")["timestamp"])
    silent = course.time_s - newest(stamp, stamp, course.time_s) > 0.5
    for what, keys in (
        ("height", ("z_valid", "v_z_valid")),
        ("position", ("xy_valid", "v_xy_valid")),
    ):
        known = ~silent
        for key in keys:
            known &= course.at("vehicle_local_position", key, 0.0) != 0.0
        needing = [mode for mode, needs in setting.needs.items() if what in needs]
        rows = course.armed & np.isin(course.mode, needing) & ~known
        row = _lasting(course.time_s, rows, MOST_WITHOUT_ESTIMATE_S)
        if row is not None:
            text = f"mode {course.mode_name(row)} went on without a valid {what}"
            return course.broken("mode_without_estimate", row, text)
    return None


def _valid_but_wrong(course: _Course, setting: Setting) -> Broken | None:
    """Nothing reports valid what is off by more than five times what it says for more than 2 s."""
    if not course.has("vehicle_local_position"):
        return None
    says = {key: course.at("vehicle_local_position", key) for key in (
        "x", "y", "z", "vx", "vy", "vz", "heading", "eph", "epv", "evh", "evv", "xy_valid",
        "z_valid", "v_xy_valid", "v_z_valid", "heading_good_for_control",
    )}  # fmt: skip
    shift = _frame_shift(course, setting)
    horizontal = np.column_stack([says["x"], says["y"]]) + shift - course.position[:, :2]
    level = np.column_stack([says["vx"], says["vy"]]) - course.velocity[:, :2]
    turned = np.angle(np.exp(1j * (says["heading"] - course.heading)))
    nose = course.at("estimator_status", "heading_accuracy")
    figures = (
        ("position", np.linalg.norm(horizontal, axis=1), "eph", "xy_valid", "m"),
        ("height", np.abs(says["z"] - course.position[:, 2]), "epv", "z_valid", "m"),
        ("horizontal velocity", np.linalg.norm(level, axis=1), "evh", "v_xy_valid", "m/s"),
        (
            "vertical velocity",
            np.abs(says["vz"] - course.velocity[:, 2]),
            "evv",
            "v_z_valid",
            "m/s",
        ),
        ("heading", np.abs(turned), "", "heading_good_for_control", "rad"),
    )
    for name, error, key, valid, unit in figures:
        deviation = says[key] if key else nose
        # An estimator that gives no deviation says nothing that could be wrong.
        claims = np.isfinite(deviation) & (deviation > 0.0) & (says[valid] == 1.0)
        wrong = course.armed & claims & (error > MOST_DEVIATIONS * deviation)
        wrong &= course.time_s < setting.unseen_s
        row = _lasting(course.time_s, wrong, MOST_WRONG_S)
        if row is not None:
            text = (
                f"the {name} is off by {error[row]:.2f} {unit}, and is said to be valid, with a "
                f"standard deviation of {deviation[row]:.2f} {unit}"
            )
            return course.broken("valid_but_wrong", row, text)
    return None


CHECKS: tuple[Callable[[_Course, Setting], Broken | None], ...] = (
    _stopped_in_the_air,
    _turning_after_a_crash,
    _unasked_take_off,
    _outside_the_fence,
    _armed_at_the_end,
    _mode_without_estimate,
    _valid_but_wrong,
)


# --- parts ---


def _lasting(time_s: Floats, rows: Rows, most_s: float) -> int | None:
    """The first row at which the condition has held for longer than `most_s` without a break."""
    broke = np.maximum.accumulate(np.where(rows, -np.inf, time_s))
    late = np.flatnonzero(rows & (time_s - broke > most_s))
    return int(late[0]) if late.size else None


def _frame_shift(course: _Course, setting: Setting) -> Floats:
    """From the origin of the world to the origin of the estimate, as places on Earth."""
    ref = [course.at("vehicle_local_position", key) for key in ("ref_lat", "ref_lon")]
    known = course.at("vehicle_local_position", "xy_global", 0.0) == 1.0
    latitude, longitude = setting.origin or (
        constant(EARTH, "latitude_deg"),
        constant(EARTH, "longitude_deg"),
    )
    north = (ref[0] - latitude) * METRES_PER_DEGREE
    east = (ref[1] - longitude) * METRES_PER_DEGREE * math.cos(math.radians(latitude))
    shift: Floats = np.where(known[:, None], np.column_stack([north, east]), 0.0)
    return shift
