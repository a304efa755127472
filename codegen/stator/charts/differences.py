"""What differs between two flights: figures of the report, settings, parameters and the graph."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stator.flight.pictures import open_log, report_beside

if TYPE_CHECKING:
    from pathlib import Path

    from pyulog import ULog

# Key of the report -> what it is called, unit.
FIGURES = {
    "take_off_s": ("take-off at", "s"),
    "touchdown_s": ("touchdown at", "s"),
    "touchdown_m_s": ("touchdown speed", "m/s"),
    "max_error_m": ("hover, error at most", "m"),
    "rms_error_m": ("hover, RMS error", "m"),
    "hover_horizontal_rms_m": ("hover, horizontal RMS", "m"),
    "hover_vertical_rms_m": ("hover, vertical RMS", "m"),
    "attitude_error_deg": ("tilt, RMS error", "deg"),
    "items_reached": ("items reached", ""),
    "corridor_m": ("off the straight path", "m"),
    "landing_error_m": ("landing, off its place", "m"),
    "hold_horizontal_rms_m": ("staying, horizontal RMS", "m"),
    "hold_vertical_rms_m": ("staying, vertical RMS", "m"),
    "tracking_rms_m": ("tracking, RMS", "m"),
    "truth_off_setpoint_rms_m": ("truth off setpoint, RMS", "m"),
    "estimate_off_truth_rms_m": ("estimate off truth, RMS", "m"),
    "duration_s": ("duration", "s"),
    "activations": ("activations", ""),
    "lost_samples": ("lost samples", ""),
    "refused_publications": ("refused publications", ""),
    "missed_life_signs": ("missed life signs", ""),
}
# What a flight was flown with.
SETTINGS = {
    "board": "board",
    "seed": "seed",
    "mission": "mission",
    "wind_m_s": "wind (m/s)",
    "wind_from_deg": "wind from (deg)",
    "failures": "failures",
    "speed": "speed",
}


@dataclass(frozen=True)
class Side:
    """One of the two flights."""

    path: Path
    log: ULog
    facts: dict[str, Any]  # of the report beside the log; empty without one
    definitions: dict[str, str]  # of the recording: what -> how it is; empty without one


def side(path: Path) -> Side:
    """Raises `UserError` for an unreadable log."""
    return Side(path, open_log(path), report_beside(path), _definitions(path))


def compare(first: Side, second: Side) -> dict[str, Any]:
    """The facts that `--json` prints."""
    params = [side.log.initial_parameters for side in (first, second)]
    graphs = [_info(side, "graph") for side in (first, second)]
    hashes = [_info(side, "ver_sw") for side in (first, second)]
    return {
        "logs": [str(side.path.resolve()) for side in (first, second)],
        "identical": first.path.read_bytes() == second.path.read_bytes(),
        "success": [side.facts.get("success") for side in (first, second)],
        "reason": [side.facts.get("reason") for side in (first, second)],
        "figures": _figures(first.facts, second.facts),
        "settings": _pairs(SETTINGS, first.facts, second.facts),
        "params": _pairs({name: name for name in {**params[0], **params[1]}}, *params),
        "graph": graphs,
        "graph_hash": hashes,
        "graph_differences": _graph(first.definitions, second.definitions),
    }


def _info(side: Side, key: str) -> str:
    return str(side.log.msg_info_dict.get(key, ""))


def _figures(first: dict[str, Any], second: dict[str, Any]) -> list[dict[str, Any]]:
    """All that one of them has, equal or not."""
    rows = []
    for key in FIGURES:
        one, other = first.get(key), second.get(key)
        if one is None and other is None:
            continue
        change = None if one is None or other is None else other - one
        rows.append({"key": key, "values": [one, other], "difference": change})
    return rows


def _pairs(
    names: dict[str, str], first: dict[str, Any], second: dict[str, Any]
) -> list[dict[str, Any]]:
    """What differs, under its name."""
    return [
        {"name": name, "values": [_value(first.get(key)), _value(second.get(key))]}
        for key, name in names.items()
        if (key in first or key in second) and first.get(key) != second.get(key)
    ]


def _value(value: Any) -> Any:
    """As JSON has it."""
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return value


def _definitions(path: Path) -> dict[str, str]:
    from stator.diagnostics import UserError
    from stator.flight.recording import read_recording

    try:
        lines = read_recording(path).lines
    except UserError:
        return {}  # it is not recorded
    found = {}
    for line in lines:
        words = line.split(" ")
        if words[0] == "topic":
            found[f"topic {words[1]}"] = " ".join(words[2:])
        elif words[0] == "task" and words[3] != "parameters":
            found[f"node {words[1]}"] = " ".join(words[2:])
    return found


def _graph(first: dict[str, str], second: dict[str, str]) -> list[dict[str, str]]:
    """Nodes and topics that one of them lacks or has otherwise."""
    if not first or not second:
        return []
    rows = []
    for what in {**first, **second}:
        if first.get(what) == second.get(what):
            continue
        how = "other" if what in first and what in second else "only in A"
        rows.append({"what": what, "how": how if what in first else "only in B"})
    return rows
