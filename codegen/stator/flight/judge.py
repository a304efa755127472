"""Judges a simulated flight: compares its log with the truth."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from stator.flight.log import DISARMED, HOLD, NAV_STATES, in_flight, newest

if TYPE_CHECKING:
    from stator.flight.log import Flight, Floats, Truth

MAX_LANDED_TILT_DEG = 20.0
UPSIDE_DOWN_DEG = 120.0


@dataclass(frozen=True)
class Limits:
    """A flight outside these limits has failed. None: no limit."""

    hover_m: float | None
    hover_horizontal_rms_m: float | None
    hover_vertical_rms_m: float | None
    tilt_error_deg: float  # RMS
    touchdown_m_s: float

    def as_json(self) -> dict[str, float | None]:
        return dataclasses.asdict(self)


CALM = Limits(
    hover_m=0.15,
    hover_horizontal_rms_m=None,
    hover_vertical_rms_m=None,
    tilt_error_deg=0.5,
    touchdown_m_s=0.7,
)
# A gust moves the vehicle before the controller can react, so the mean counts. The acceleration of
# a gust lasts as long as the average of the specific force that gives gravity, so it tilts the
# estimate.
IN_WIND = Limits(
    hover_m=None,
    hover_horizontal_rms_m=1.0,
    hover_vertical_rms_m=0.5,
    tilt_error_deg=1.5,
    touchdown_m_s=1.0,
)


@dataclass(frozen=True)
class Hover:
    seconds: float
    height_m: float
    max_error_m: float
    rms_error_m: float
    horizontal_rms_m: float
    vertical_rms_m: float
    worst_s: float
    worst_position: Floats


@dataclass(frozen=True)
class Tilt:
    rms_deg: float
    max_deg: float
    worst_s: float


@dataclass(frozen=True)
class Problem:
    """A broken limit; with time and place, if it happened at one instant."""

    text: str
    time_s: float | None = None
    position: Floats | None = None  # N, m

    def as_json(self) -> dict[str, object]:
        position = None if self.position is None else [float(x) for x in self.position]
        return {"text": self.text, "time_s": self.time_s, "position_m": position}


@dataclass(frozen=True)
class Judgement:
    """`problems` is empty for a successful flight."""

    hover: Hover | None
    tilt: Tilt | None
    problems: list[Problem]


def judge(flight: Flight, limits: Limits = CALM) -> Judgement:
    if not np.isfinite(flight.truth.position).all():
        left = Problem("the state of the simulated vehicle is not finite")
        return Judgement(None, None, [left])
    broken = attitude_problems(flight)
    if flight.take_off_s is None:
        left = at_end(flight, f"no take-off: {ending(flight)}")
        return Judgement(None, None, [*broken, left])
    hover = _hover(flight)
    tilt = None if broken else _tilt(flight)
    problems = [
        *_hover_problems(hover, limits),
        *(broken or _tilt_problems(tilt, limits.tilt_error_deg)),
        *landing_problems(flight, limits.touchdown_m_s),
    ]
    return Judgement(hover, tilt, problems)


# --- hover ---


def _hover(flight: Flight) -> Hover | None:
    """How far the true position was from the setpoint while the vehicle flew in hold."""
    time = flight.truth.time_s
    nav_state = newest(flight.status_time_s, flight.nav_state.astype(np.float64), time)
    setpoint = newest(flight.setpoint_time_s, flight.setpoint, time)
    offset = np.nan_to_num(flight.truth.position - setpoint)
    error = np.linalg.norm(offset, axis=1)
    rows = np.flatnonzero((nav_state == HOLD) & in_flight(flight, time))
    if rows.size < 2:
        return None
    worst = rows[np.argmax(error[rows])]
    return Hover(
        seconds=float(time[rows[-1]] - time[rows[0]]),
        height_m=-float(np.mean(flight.truth.position[rows, 2])),
        max_error_m=float(error[worst]),
        rms_error_m=rms(error[rows]),
        horizontal_rms_m=rms(np.linalg.norm(offset[rows, :2], axis=1)),
        vertical_rms_m=rms(offset[rows, 2]),
        worst_s=float(time[worst]),
        worst_position=flight.truth.position[worst],
    )


def _hover_problems(hover: Hover | None, limits: Limits) -> list[Problem]:
    if hover is None:
        return [Problem("no hover: vehicle_status had no hold mode in flight")]
    worst = (
        f"{hover.max_error_m:.3f} m from the setpoint at {hover.worst_s:.2f} s, "
        f"{place(hover.worst_position)}"
    )
    texts = []
    if limits.hover_m is not None and hover.max_error_m > limits.hover_m:
        texts.append(f"hover: {worst} (limit {limits.hover_m:g} m)")
    for way, error, most in (
        ("horizontally", hover.horizontal_rms_m, limits.hover_horizontal_rms_m),
        ("vertically", hover.vertical_rms_m, limits.hover_vertical_rms_m),
    ):
        if most is not None and error > most:
            texts.append(f"hover: {error:.2f} m RMS {way} (limit {most:g} m), at most {worst}")
    return [Problem(text, hover.worst_s, hover.worst_position) for text in texts]


# --- tilt ---


def attitude_problems(flight: Flight) -> list[Problem]:
    """An estimate that is not a number; everything that reads it follows."""
    broken = np.flatnonzero(~np.isfinite(flight.attitude_q).all(axis=1))
    if broken.size == 0:
        return []
    time_s = float(flight.attitude_time_s[broken[0]])
    return [Problem(f"vehicle_attitude.q is not a number at {time_s:.2f} s", time_s)]


def _tilt(flight: Flight) -> Tilt | None:
    """Angle between the true and the estimated vertical in B; heading does not count."""
    rows = in_flight(flight, flight.attitude_time_s)
    time = flight.attitude_time_s[rows]
    if time.size == 0:
        return None
    true_down = _down_in_body(_q_at(flight.truth, time))
    down = _down_in_body(flight.attitude_q[rows])
    sine = np.linalg.norm(np.cross(true_down, down), axis=1)
    error_deg = np.degrees(np.arctan2(sine, np.sum(true_down * down, axis=1)))
    worst = int(np.argmax(error_deg))
    return Tilt(rms(error_deg), float(error_deg[worst]), float(time[worst]))


def _tilt_problems(tilt: Tilt | None, most_deg: float) -> list[Problem]:
    if tilt is None:
        return [Problem("no attitude estimate was logged in flight")]
    if tilt.rms_deg <= most_deg:
        return []
    text = (
        f"estimated tilt: RMS error {tilt.rms_deg:.2f} deg (limit {most_deg:g} deg), greatest "
        f"error {tilt.max_deg:.2f} deg at {tilt.worst_s:.2f} s"
    )
    return [Problem(text, tilt.worst_s)]


def _q_at(truth: Truth, time_s: Floats) -> Floats:
    """True attitude between rows of 10 ms: linear interpolation, normalised."""
    q = truth.q.copy()
    turned = np.sum(q[1:] * q[:-1], axis=1) < 0.0
    q[1:][np.cumsum(turned) % 2 == 1] *= -1.0
    chord = np.column_stack([np.interp(time_s, truth.time_s, q[:, i]) for i in range(4)])
    unit: Floats = chord / np.linalg.norm(chord, axis=1, keepdims=True)
    return unit


def _down_in_body(q: Floats) -> Floats:
    """Third row of R_NB."""
    w, x, y, z = q.T
    return np.column_stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)])


# --- landing ---


def landing_problems(flight: Flight, most_m_s: float) -> list[Problem]:
    if not flight.landed or flight.touchdown_m_s is None:
        return [at_end(flight, f"not landed and disarmed: {ending(flight)}")]
    problems = []
    if flight.touchdown_m_s >= most_m_s:
        text = (
            f"touchdown: {flight.touchdown_m_s:.2f} m/s down at {flight.touchdown_s:.2f} s "
            f"(limit {most_m_s:g} m/s)"
        )
        problems.append(at_end(flight, text, flight.touchdown_s))
    if not flight.truth.on_ground[-1]:
        problems.append(at_end(flight, f"the motors stopped in the air: {ending(flight)}"))
    if lies := lying(flight.truth):
        problems.append(at_end(flight, lies))
    if flight.arming_state.size == 0 or flight.arming_state[-1] != DISARMED:
        problems.append(Problem("vehicle_status was not disarmed at the end"))
    return problems


def lying(truth: Truth) -> str:
    """How the vehicle came to rest, if not on its feet."""
    tilt_deg = math.degrees(math.acos(np.clip(_down_in_body(truth.q[-1:])[0, 2], -1, 1)))
    if tilt_deg <= MAX_LANDED_TILT_DEG:
        return ""
    how = "upside down" if tilt_deg > UPSIDE_DOWN_DEG else "on its side"
    return f"landed {how}: tilted {tilt_deg:.0f} deg (limit {MAX_LANDED_TILT_DEG:g} deg)"


def at_end(flight: Flight, text: str, time_s: float | None = None) -> Problem:
    """A problem at the end of the flight, with the place where the vehicle came to rest."""
    at_s = float(flight.truth.time_s[-1]) if time_s is None else time_s
    return Problem(text, at_s, flight.truth.position[-1])


def ending(flight: Flight) -> str:
    """The mode and the place at the end of the flight."""
    state = int(flight.nav_state[-1]) if flight.nav_state.size else -1
    return (
        f"at {flight.truth.time_s[-1]:.2f} s in mode {NAV_STATES.get(state, 'unknown')}, "
        f"{place(flight.truth.position[-1])}"
    )


# --- parts ---


def rms(values: Floats) -> float:
    return float(np.sqrt(np.mean(values**2)))


def place(position: Floats) -> str:
    north, east, down = position
    return f"{north:.2f} m north, {east:.2f} m east, {-down:.2f} m up"
