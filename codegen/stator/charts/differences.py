"""What differs between flights: figures of the report, settings, parameters and the graph."""

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
LETTERS = "ABCDEFGH"  # of the flights, as many as can be compared at once
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
    """One of the flights."""

    path: Path
    log: ULog
    facts: dict[str, Any]  # of the report beside the log; empty without one
    definitions: dict[str, str]  # of the recording: what -> how it is; empty without one


def side(path: Path) -> Side:
    """Raises `UserError` for an unreadable log."""
    return Side(path, open_log(path), report_beside(path), _definitions(path))


def compare(sides: list[Side]) -> dict[str, Any]:
    """The facts that `--json` prints. Each list of values has one for each flight."""
    facts = [side.facts for side in sides]
    params = [side.log.initial_parameters for side in sides]
    names = {name: name for values in params for name in values}
    first, *others = (side.path.read_bytes() for side in sides)
    return {
        "logs": [str(side.path.resolve()) for side in sides],
        "identical": all(other == first for other in others),
        "success": [values.get("success") for values in facts],
        "reason": [values.get("reason") for values in facts],
        "figures": _figures(facts),
        "settings": _different(SETTINGS, facts),
        "params": _different(names, params),
        "graph": [_info(side, "graph") for side in sides],
        "graph_hash": [_info(side, "ver_sw") for side in sides],
        "graph_differences": _graph([side.definitions for side in sides]),
    }


def _info(side: Side, key: str) -> str:
    return str(side.log.msg_info_dict.get(key, ""))


def _figures(facts: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """All that one of them has, equal or not."""
    rows = []
    for key in FIGURES:
        values = [one.get(key) for one in facts]
        if any(value is not None for value in values):
            known = [value for value in values if value is not None]
            change = known[1] - known[0] if len(known) == len(values) == 2 else None
            rows.append({"key": key, "values": values, "difference": change})
    return rows


def _different(names: dict[str, str], facts: list[dict[str, Any]]) -> list[dict[str, Any]]:
    """What differs, under its name."""
    rows = []
    for key, name in names.items():
        values = [_value(one.get(key)) for one in facts]
        if any(value != values[0] for value in values):
            rows.append({"name": name, "values": values})
    return rows


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


def _graph(definitions: list[dict[str, str]]) -> list[dict[str, str]]:
    """Nodes and topics that one of them lacks or has otherwise."""
    if not all(definitions):
        return []
    rows = []
    for what in dict.fromkeys(name for one in definitions for name in one):
        values = [one.get(what) for one in definitions]
        if all(value == values[0] for value in values):
            continue
        having = [letter for letter, value in zip(LETTERS, values, strict=False) if value]
        is_everywhere = len(having) == len(values)
        how = "other" if is_everywhere else f"only in {', '.join(having)}"
        rows.append({"what": what, "how": how})
    return rows
