"""Judges a simulated mission: compares log and truth with the mission and its limits.

Positions count from home, the place where the vehicle was armed; for the truth, the true place.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from stator.flight import log as flight_log
from stator.flight.judge import (
    Problem,
    at_end,
    attitude_problems,
    ending,
    landing_problems,
    place,
    rms,
)
from stator.flight.log import ARMED, FAILSAFE_EVENTS, MODES, NAV_STATES, in_flight, newest
from stator.graph.messages import own_field
from stator.mission.commands import EIGHT, FLOWN, LANDINGS, RETURN, TAKEOFFS
from stator.mission.route import walk
from stator.mission.vehicle import Vehicle

if TYPE_CHECKING:
    from numpy.typing import NDArray
    from pyulog import ULog

    from stator.flight.log import Flight, Floats
    from stator.mission.model import Mission

    Rows = NDArray[np.bool_]

USUAL_LIMITS = {"touchdown_speed": 1.0}
# From the place where a return or a landing of the mission leads, unless the file has a limit.
USUAL_LANDING_ERROR_M = 5.0
# A vehicle counts as staying after its setpoint has not moved for this time.
SETTLED_S = 3.0
FAULTS = {number: name for name, number in own_field("MissionResult", "fault").values}
CHECKS = {
    "sensors_ok": "a sensor sends nothing",
    "estimator_ok": "the position is unknown",
    "battery_ok": "the battery is low",
    "rc_ok": "no signal from the pilot",
    "logging_ok": "no log is written",
    "motors_ok": "a motor controller is silent",
    "parameters_ok": "kept parameters could not be used",
    "mission_ok": "the mission cannot be flown",
}


@dataclass
class MissionFlight:
    """The measurements, under their names in --json. None: not measured."""

    facts: dict[str, object] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)

    def limit(self, key: str, value: float | None, most: float | None, what: str) -> None:
        """Checks one figure of the whole flight."""
        self.facts[key] = value
        if most is None:
            return
        if value is None:
            self.problems.append(Problem(f"cannot measure: {what}"))
        elif value > most:
            self.problems.append(Problem(f"{what} {value:.2f} m (limit {most:g} m)"))

    def limit_each(
        self, key: str, values: Floats, most: float | None, what: str, flight: Flight, rows: Rows
    ) -> None:
        """Checks a distance at each of these rows of the truth."""
        worst = int(np.argmax(values)) if values.size else 0
        value = float(values[worst]) if values.size else None
        if value is None or most is None or value <= most:
            self.limit(key, value, most, what)
            return
        self.facts[key] = value
        row = np.flatnonzero(rows)[worst]
        time_s, position = float(flight.truth.time_s[row]), flight.truth.position[row]
        text = f"{what} {value:.2f} m at {time_s:.2f} s, {place(position)} (limit {most:g} m)"
        self.problems.append(Problem(text, time_s, position))


def judge_mission(log: ULog, flight: Flight, mission: Mission) -> MissionFlight:
    result = MissionFlight()
    result.problems += attitude_problems(flight)
    limits = USUAL_LIMITS | mission.limits
    status = flight_log.topic(log, "vehicle_status")
    result.facts |= {"modes": modes_of(status), "limits": limits}
    progress = flight_log.topic(log, "mission_result")
    items = _items(progress, mission)
    total, reached = len(items), sum(item["reached_s"] is not None for item in items)
    result.facts |= {"items_total": total, "items_reached": reached, "items": items}
    result.facts["items_uncounted"] = _uncounted(mission, items)
    armed = np.flatnonzero(flight.arming_state == ARMED)
    if armed.size == 0:
        result.problems.append(Problem(f"not armed: {_why_not(log)}"))
        return result
    if flight.take_off_s is None:
        result.problems.append(at_end(flight, f"no take-off: {ending(flight)}"))
        return result
    home = _at(flight.truth.time_s, flight.truth.position, flight.status_time_s[armed[0]])
    if reached < total:
        text = f"reached {reached} of {total} mission items: {ending(flight)}"
        result.problems.append(at_end(flight, text))
    result.problems += _failsafes(result.facts["modes"])
    result.problems += landing_problems(flight, limits["touchdown_speed"])
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
    flown = in_flight(flight, flight.truth.time_s)
    followed = flown & _follows_way(flight)
    away = _distance_from_way(truth[followed, :2], _way(mission, _landing_place(log)))
    most = limits.get("corridor")
    result.limit_each("corridor_m", away, most, "distance from the straight path", flight, followed)
    place = _landing_place(log)
    last = (np.arange(len(truth)) == _landing_row(flight)) & flight.landed
    landing = np.linalg.norm(truth[last, :2] - (0.0 if place is None else place), axis=1)
    usual = USUAL_LANDING_ERROR_M if place is not None and flight.landed else None
    most = limits.get("landing_error", usual)
    result.limit_each("landing_error_m", landing, most, "landing error", flight, last)
    result.facts |= _errors(log, flight, setpoint + home)

    staying = _at_rest(flight, setpoint) & flown
    error = truth[staying] - setpoint[staying]
    horizontal = rms(np.linalg.norm(error[:, :2], axis=1)) if error.size else None
    vertical = rms(error[:, 2]) if error.size else None
    most = limits.get("hold_horizontal_rms")
    result.limit("hold_horizontal_rms_m", horizontal, most, "horizontal RMS error while staying")
    most = limits.get("hold_vertical_rms")
    result.limit("hold_vertical_rms_m", vertical, most, "vertical RMS error while staying")
    tracking = _tracking(log, flight, mission)
    result.limit("tracking_rms_m", tracking, limits.get("tracking_rms"), "tracking RMS error")


# --- parts ---


def modes_of(status: dict[str, NDArray[np.generic]]) -> list[dict[str, object]]:
    """Each change of arming or mode: its time, the mode, and the failsafe event."""
    rows = np.column_stack(
        [status[key].astype(np.int64) for key in ("arming_state", "nav_state", "failsafe_event")]
    )
    changed = np.flatnonzero(np.any(np.diff(rows, axis=0) != 0, axis=1)) + 1
    return [
        {
            "time_s": float(status["timestamp"][i]) * 1e-6,
            "armed": bool(rows[i, 0] == ARMED),
            "mode": NAV_STATES.get(int(rows[i, 1]), "unknown"),
            "failsafe": FAILSAFE_EVENTS.get(int(rows[i, 2]), ""),
        }
        for i in (0, *changed)
    ]


def _failsafes(modes: object) -> list[Problem]:
    assert isinstance(modes, list)
    events = {m["failsafe"]: m for m in reversed(modes) if m["failsafe"]}
    return [
        Problem(f"failsafe {event} at {m['time_s']:.2f} s: {m['mode']}", m["time_s"])
        for event, m in events.items()
    ]


def _items(progress: dict[str, NDArray[np.generic]], mission: Mission) -> list[dict[str, object]]:
    """Each item that can be reached, and when the vehicle reached it."""
    reached = progress["seq_reached"].astype(np.int64)
    time_s = flight_log.seconds(progress["timestamp"])
    first, rows_of = np.unique(reached, return_index=True)
    when = dict(zip(first.tolist(), time_s[rows_of].tolist(), strict=True))
    flown = walk(mission, Vehicle()).flown
    return [
        {"number": item.number, "kind": item.name, "reached_s": when.get(index)}
        for index, item in enumerate(mission.items)
        if index in flown and item.is_reached and item.command not in LANDINGS
    ]


def _uncounted(mission: Mission, items: list[dict[str, object]]) -> list[str]:
    """The names of the other items of the file, in its order: they have no place to reach, or lie
    where the vehicle does not come."""
    counted = {item["number"] for item in items}
    names = {i.number: i.name for i in mission.items if not i.is_extra and i.number not in counted}
    return list(names.values())


def _errors(log: ULog, flight: Flight, setpoint: Floats) -> dict[str, object]:
    """Distances in the air, RMS and maximum: truth to setpoint, estimate to setpoint, estimate to
    truth."""
    local = flight_log.topic(log, "vehicle_local_position")
    estimate = newest(
        flight_log.seconds(local["timestamp"]),
        flight_log.columns(local, ["x", "y", "z"]),
        flight.truth.time_s,
    )
    flown = in_flight(flight, flight.truth.time_s)
    pairs = {
        "truth_off_setpoint": flight.truth.position - setpoint,
        "estimate_off_setpoint": estimate - setpoint,
        "estimate_off_truth": estimate - flight.truth.position,
    }
    facts: dict[str, object] = {}
    for name, difference in pairs.items():
        known = flown & np.isfinite(difference).all(axis=1)
        length = np.linalg.norm(difference[known], axis=1)
        facts[f"{name}_rms_m"] = rms(length) if length.size else None
        facts[f"{name}_max_m"] = float(length.max()) if length.size else None
    return facts


def _why_not(log: ULog) -> str:
    health = flight_log.topic(log, "health_report")
    failed = [text for key, text in CHECKS.items() if not health.get(key, [True])[-1]]
    if not health["mission_ok"][-1]:
        failed[-1] += f" ({_fault(flight_log.topic(log, 'mission_result'))})"
    return "; ".join(failed) or "no request to arm"


def _fault(progress: dict[str, NDArray[np.generic]]) -> str:
    """Why the vehicle says that it cannot fly the mission."""
    name = FAULTS.get(int(progress["fault"][-1]), "unknown").replace("_", " ")
    if name in ("missing", "unread", "no position", "bad fence"):
        return name
    return f"{name}, item {int(progress['fault_seq'][-1]) + 1} of {int(progress['seq_total'][-1])}"


def _landing_place(log: ULog) -> Floats | None:
    """Where a return or a landing of the mission leads, from home; None: nowhere."""
    progress = flight_log.topic(log, "mission_result")
    home = flight_log.topic(log, "home_position")
    place = np.array([progress["land_x"][-1], progress["land_y"][-1]], dtype=np.float64)
    place -= np.array([home["x"][-1], home["y"][-1]], dtype=np.float64)
    return place if np.isfinite(place).all() else None


def _at(times: Floats, values: Floats, at: float) -> Floats:
    row: Floats = values[min(int(np.searchsorted(times, at)), len(values) - 1)]
    return row


def _setpoints(log: ULog, flight: Flight) -> Floats:
    """From home, at the times of the truth."""
    home = flight_log.topic(log, "home_position")
    position = np.column_stack([home[key] for key in ("x", "y", "z")]).astype(np.float64)
    at_home = newest(flight_log.seconds(home["timestamp"]), position, flight.truth.time_s)
    return newest(flight.setpoint_time_s, flight.setpoint, flight.truth.time_s) - at_home


def _follows_way(flight: Flight) -> Rows:
    """An aeroplane leaves it for its approach."""
    time = flight.truth.time_s
    nav_state = newest(flight.status_time_s, flight.nav_state.astype(np.float64), time)
    rows: Rows = nav_state == MODES["mission"] if flight.truth.has_wing else time >= 0.0
    return rows


def _landing_row(flight: Flight) -> int:
    """Where it came to rest; of an aeroplane, which rolls on, where it touched down."""
    last = len(flight.truth.time_s) - 1
    if not flight.truth.has_wing or flight.touchdown_s is None:
        return last
    return min(int(np.searchsorted(flight.truth.time_s, flight.touchdown_s)), last)


def _at_rest(flight: Flight, setpoint: Floats) -> NDArray[np.bool_]:
    """In mission mode with a setpoint that has not moved for a while."""
    time = flight.truth.time_s
    nav_state = newest(flight.status_time_s, flight.nav_state.astype(np.float64), time)
    moves = np.any(np.diff(setpoint, axis=0, prepend=setpoint[:1]) != 0.0, axis=1)
    moves |= ~np.isfinite(setpoint).all(axis=1) | (nav_state != MODES["mission"])
    last = np.maximum.accumulate(np.where(moves, time, -np.inf))
    rests: NDArray[np.bool_] = time - last >= SETTLED_S
    return rests


def _way(mission: Mission, landing: Floats | None) -> Floats:
    """The corners of the straight path, from home to the landing."""
    visits = walk(mission, Vehicle()).visits
    places = [v.place.point for v in visits if v.item.command != RETURN]
    last = (0.0, 0.0) if landing is None else (float(landing[0]), float(landing[1]))
    return np.array([(0.0, 0.0), *places, last])


def _distance_from_way(points: Floats, way: Floats) -> Floats:
    """The distance of each point to the nearest piece of the path."""
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


def _tracking(log: ULog, flight: Flight, mission: Mission) -> float | None:
    """Horizontal RMS distance of estimate and setpoint while the mission moves; if it has figures
    of eight, in these only."""
    progress = flight_log.topic(log, "mission_result")
    position = flight_log.topic(log, "vehicle_local_position")
    time = flight_log.seconds(position["timestamp"])
    estimate = np.column_stack([position["x"], position["y"]]).astype(np.float64)
    setpoint = newest(flight.setpoint_time_s, flight.setpoint, time)[:, :2]
    item = newest(
        flight_log.seconds(progress["timestamp"]), progress["seq_current"].astype(np.float64), time
    )
    nav_state = newest(flight.status_time_s, flight.nav_state.astype(np.float64), time)
    eights = [i for i, m in enumerate(mission.items) if m.command == EIGHT]
    counted = eights or [i for i, m in enumerate(mission.items) if m.command in FLOWN - TAKEOFFS]
    rows = in_flight(flight, time) & (nav_state == MODES["mission"]) & np.isin(item, counted)
    rows &= np.isfinite(setpoint).all(axis=1)
    error = np.linalg.norm(estimate[rows] - setpoint[rows], axis=1)
    return rms(error) if error.size else None
