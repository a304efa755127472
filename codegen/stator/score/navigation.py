"""`stator score navigation DIR`: the navigation node on recorded flights, beside the results of
other software on the same data."""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING

import numpy as np

from stator import HOME
from stator.score.navigation_metrics import (
    FlightScore,
    HoldOut,
    ReferenceScore,
    flight_score,
    reference_score,
)
from stator.score.navigation_peer import peer_score
from stator.score.recordings import flights_in

if TYPE_CHECKING:
    from pathlib import Path

GRAPH = HOME / "graph" / "navigation_recording.yaml"
BOARD = "playback"
EPILOG = """\
navigation: a recorded flight is NAME.zip, text tables in the format of the InertialNav project
(IMU, GPS, MAG, NTUN, ATT, timing), with an optional NAME_peer_*.csv.gz beside it; or
NAME_replay.csv.gz, an input of PX4's estimator tests, with NAME_reference*.csv beside it."""


def show_flight(name: str, ours: FlightScore, peer: FlightScore | None) -> None:
    def line(what: str, unit: str, mine: float, other: float | None) -> str:
        beside = "" if other is None else f"{other:.2f}"
        return f"  {what:<28} {mine:9.2f} {beside:>9}  {unit}"

    print(f"{name:<30} {'here':>9} {'' if peer is None else 'peer':>9}".rstrip())
    for key, value in asdict(ours.attitude).items():
        other = None if peer is None else getattr(peer.attitude, key)
        print(line(f"{key.removesuffix('_deg')} against onboard", "deg RMS", value, other))
    for key, value in ours.innovations.items():
        what, unit = (key[:-4], "m/s RMS") if key.endswith("_m_s") else (key[:-2], "m RMS")
        other = None if peer is None else peer.innovations[key]
        print(line(f"innovation {what.replace('_', ' ')}", unit, value, other))
    for key, what in (("p50_m", "half"), ("p95_m", "95 %")):
        other = None if peer is None else getattr(peer.hold_out, key)
        unit = f"m at most, in {what} of the windows"
        print(line("10 s without satellites", unit, getattr(ours.hold_out, key), other))
    beside = "" if peer is None else missed_of(peer.hold_out)
    print(f"  {'windows missed':<28} {missed_of(ours.hold_out):>9} {beside:>9}".rstrip())


def missed_of(score: HoldOut) -> str:
    return f"{score.missed} of {score.windows}"


def show_reference(name: str, score: ReferenceScore) -> None:
    print(f"{name + ', against the reference':<30} {'here':>9}")
    rows = {
        "tilt": (score.tilt_deg, "deg RMS"),
        "yaw": (score.yaw_deg, "deg RMS"),
        "velocity": (score.velocity_m_s, "m/s RMS"),
        "height change": (score.height_change_m, "m RMS"),
    }
    for what, (value, unit) in rows.items():
        print(f"  {what:<28} {value:9.2f}  {unit}")


def known(value: object) -> object:
    """JSON has neither NaN nor infinity: null means not measured."""
    if isinstance(value, dict):
        return {key: known(item) for key, item in value.items()}
    return None if isinstance(value, float) and not np.isfinite(value) else value


def main(folder: Path, *, as_json: bool) -> None:
    from stator.build.cmake import build

    flights = flights_in(folder)
    program = build(GRAPH, BOARD)
    result: list[dict[str, object]] = []
    for flight in flights:
        if len(flight.reference):
            reference = reference_score(flight, program)
            result.append({"name": flight.name, "reference": asdict(reference)})
            if not as_json:
                show_reference(flight.name, reference)
            continue
        ours, peer = flight_score(flight, program), peer_score(flight)
        beside = None if peer is None else asdict(peer)
        result.append({"name": flight.name, **asdict(ours), "peer": beside})
        if not as_json:
            show_flight(flight.name, ours, peer)
    if as_json:
        print(json.dumps({"recordings": [known(row) for row in result]}, indent=2))
