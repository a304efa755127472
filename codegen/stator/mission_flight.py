"""Judges a simulated mission: what the log and the truth say against the mission and its limits.

Positions count from home, which is where the vehicle was armed: for the truth, where it truly was.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from stator import flight as fl
from stator.mission import EIGHT, LAND, RETURN, TAKEOFF, WAYPOINT, Mission

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from pyulog import ULog

    from stator.flight import Flight, Floats

ARMED, IN_MISSION = 2, 3  # graph/messages/VehicleStatus.yaml
USUAL_LIMITS = {"touchdown_speed": 1.0}
# How long the setpoint must have rested before a vehicle counts as staying.
SETTLED_S = 3.0
CHECKS = {
    "sensors_ok": "a sensor is silent",
    "estimator_ok": "the position is not known",
    "battery_ok": "the battery is low",
    "rc_ok": "the pilot is not heard",
    "logging_ok": "no log is written",
    "mission_ok": "the mission cannot be flown",
}


@dataclass
class MissionFlight:
    """What was measured, under the names that --json has. None: there was nothing to measure."""

    facts: dict[str, object] = field(default_factory=dict)
    problems: list[str] = field(default_factory=list)

    def limit(self, key: str, value: float | None, most: float | None, what: str) -> None:
        self.facts[key] = value
        if most is None:
            return
        if value is None:
            self.problems.append(f"{what} could not be measured")
        elif value > most:
            self.problems.append(f"{what} {value:.2f} m (limit {most:g} m)")


def judge_mission(log: ULog, flight: Flight, mission: Mission) -> MissionFlight:
    result = MissionFlight()
    limits = USUAL_LIMITS | mission.limits
    status = fl.topic(log, "vehicle_status")
    result.facts["modes"] = _modes(status)
    progress = fl.topic(log, "mission_result")
    total = sum(item.kind not in (RETURN, LAND) for item in mission.items)
    reached = int(np.max(progress["seq_reached"], initial=-1)) + 1
    result.facts |= {"items_total": total, "items_reached": min(reached, total)}
    armed = np.flatnonzero(flight.arming_state == ARMED)
    if armed.size == 0:
        result.problems.append(f"never armed: {_why_not(log)}")
        return result
    if flight.take_off_s is None:
        result.problems.append(f"never took off: {fl.ending(flight)}")
        return result
    home = _at(flight.truth.time_s, flight.truth.position, flight.status_time_s[armed[0]])
    if reached < total:
        result.problems.append(f"reached {reached} of {total} items of the mission")
    result.problems += _failsafes(result.facts["modes"])
    result.problems += fl.landing_problems(flight, limits["touchdown_speed"])
    _measure(result, log, flight, mission, limits, home)
    return result


def _measure(
    result: MissionFlight,
    log: ULog,
    flight: Flight,
    mission: Mission,
    limits: dict[str, float],
    home: Floats,
) -> None:
    truth = flight.truth.position - home
    setpoint = _setpoints(log, flight)
    flown = fl.in_flight(flight, flight.truth.time_s)
    away = _distance_from_way(truth[flown, :2], _way(mission))
    result.limit("corridor_m", _most(away), limits.get("corridor"), "off the straight way")
    landing = float(np.linalg.norm(truth[-1, :2]))
    result.limit("landing_error_m", landing, limits.get("landing_error"), "landed off home by")

    staying = _at_rest(flight, setpoint) & flown
    error = truth[staying] - setpoint[staying]
    horizontal = fl.rms(np.linalg.norm(error[:, :2], axis=1)) if error.size else None
    vertical = fl.rms(error[:, 2]) if error.size else None
    most = limits.get("hold_horizontal_rms")
    result.limit("hold_horizontal_rms_m", horizontal, most, "while staying, horizontal RMS")
    most = limits.get("hold_vertical_rms")
    result.limit("hold_vertical_rms_m", vertical, most, "while staying, vertical RMS")
    tracking = _tracking(log, flight, mission)
    result.limit("tracking_rms_m", tracking, limits.get("tracking_rms"), "tracking RMS")


# --- parts ---


def _modes(status: dict[str, NDArray[np.generic]]) -> list[dict[str, object]]:
    """Each change of arming or mode: when, which, and after which failsafe event."""
    rows = np.column_stack(
        [status[key].astype(np.int64) for key in ("arming_state", "nav_state", "failsafe_event")]
    )
    changed = np.flatnonzero(np.any(np.diff(rows, axis=0) != 0, axis=1)) + 1
    return [
        {
            "time_s": float(status["timestamp"][i]) * 1e-6,
            "armed": bool(rows[i, 0] == ARMED),
            "mode": fl.NAV_STATES.get(int(rows[i, 1]), "no known mode"),
            "failsafe": fl.FAILSAFE_EVENTS.get(int(rows[i, 2]), ""),
        }
        for i in (0, *changed)
    ]


def _failsafes(modes: object) -> list[str]:
    assert isinstance(modes, list)
    events = {m["failsafe"]: m for m in reversed(modes) if m["failsafe"]}
    return [f"failsafe {event} at {m['time_s']:.2f} s: {m['mode']}" for event, m in events.items()]


def _why_not(log: ULog) -> str:
    health = fl.topic(log, "health_report")
    return "; ".join(text for key, text in CHECKS.items() if not health[key][-1]) or "not asked to"


def _at(times: Floats, values: Floats, at: float) -> Floats:
    row: Floats = values[min(int(np.searchsorted(times, at)), len(values) - 1)]
    return row


def _setpoints(log: ULog, flight: Flight) -> Floats:
    """From home, at the times of the truth."""
    home = fl.topic(log, "home_position")
    place = np.column_stack([home[key] for key in ("x", "y", "z")]).astype(np.float64)
    at_home = fl.newest(fl.seconds(home["timestamp"]), place, flight.truth.time_s)
    return fl.newest(flight.setpoint_time_s, flight.setpoint, flight.truth.time_s) - at_home


def _at_rest(flight: Flight, setpoint: Floats) -> NDArray[np.bool_]:
    """In mission mode with a setpoint that has not moved for a while."""
    time = flight.truth.time_s
    nav_state = fl.newest(flight.status_time_s, flight.nav_state.astype(np.float64), time)
    moves = np.any(np.diff(setpoint, axis=0, prepend=setpoint[:1]) != 0.0, axis=1)
    moves |= ~np.isfinite(setpoint).all(axis=1) | (nav_state != IN_MISSION)
    last = np.maximum.accumulate(np.where(moves, time, -np.inf))
    rests: NDArray[np.bool_] = time - last >= SETTLED_S
    return rests


def _way(mission: Mission) -> Floats:
    """The corners of the straight way, beginning and ending at home."""
    places = [(i.north, i.east) for i in mission.items if i.kind == WAYPOINT]
    land = [(i.north, i.east) for i in mission.items if i.kind == LAND]
    return np.array([(0.0, 0.0), *places, *(land or [(0.0, 0.0)])])


def _distance_from_way(points: Floats, way: Floats) -> Floats:
    """Of each point the distance to the nearest piece."""
    nearest = np.full(len(points), np.inf)
    for start, end in pairwise(way):
        along = end - start
        length2 = float(along @ along)
        part = (
            np.clip((points - start) @ along / length2, 0, 1) if length2 else np.zeros(len(points))
        )
        off = points - start - part[:, None] * along
        nearest = np.minimum(nearest, np.linalg.norm(off, axis=1))
    return nearest


def _most(values: Floats) -> float | None:
    return float(np.max(values)) if values.size else None


def _tracking(log: ULog, flight: Flight, mission: Mission) -> float | None:
    """RMS of estimate against setpoint, horizontally, while the mission moves: in its eights alone,
    if it has any."""
    progress = fl.topic(log, "mission_result")
    position = fl.topic(log, "vehicle_local_position")
    time = fl.seconds(position["timestamp"])
    estimate = np.column_stack([position["x"], position["y"]]).astype(np.float64)
    setpoint = fl.newest(flight.setpoint_time_s, flight.setpoint, time)[:, :2]
    item = fl.newest(
        fl.seconds(progress["timestamp"]), progress["seq_current"].astype(np.float64), time
    )
    nav_state = fl.newest(flight.status_time_s, flight.nav_state.astype(np.float64), time)
    eights = [i for i, m in enumerate(mission.items) if m.kind == EIGHT]
    counted = eights or [i for i, m in enumerate(mission.items) if m.kind != TAKEOFF]
    rows = fl.in_flight(flight, time) & (nav_state == IN_MISSION) & np.isin(item, counted)
    rows &= np.isfinite(setpoint).all(axis=1)
    error = np.linalg.norm(estimate[rows] - setpoint[rows], axis=1)
    return fl.rms(error) if error.size else None
