"""The columns of the results: what a flight is flown with, and what came of it. No time of day, no
host and no path, so that equal campaigns give equal bytes."""

from __future__ import annotations

# Of a result: the type in Parquet.
RESULTS: dict[str, str] = {
    "success": "bool",
    "reason": "string",
    "broken_invariant": "string",
    "crash": "string",
    "duration_s": "double",
    "take_off_s": "double",
    "touchdown_s": "double",
    "touchdown_m_s": "double",
    "hover_s": "double",
    "hover_height_m": "double",
    "max_error_m": "double",
    "rms_error_m": "double",
    "hover_horizontal_rms_m": "double",
    "hover_vertical_rms_m": "double",
    "attitude_error_deg": "double",
    "items_total": "int64",
    "items_reached": "int64",
    "corridor_m": "double",
    "landing_error_m": "double",
    "hold_horizontal_rms_m": "double",
    "hold_vertical_rms_m": "double",
    "tracking_rms_m": "double",
    "truth_off_setpoint_rms_m": "double",
    "truth_off_setpoint_max_m": "double",
    "estimate_off_setpoint_rms_m": "double",
    "estimate_off_setpoint_max_m": "double",
    "estimate_off_truth_rms_m": "double",
    "estimate_off_truth_max_m": "double",
    "lost_samples": "int64",
    "refused_publications": "int64",
    "missed_life_signs": "int64",
    "activations": "int64",
    "log_sha256": "string",
}
LIMITED = [name for name, kind in RESULTS.items() if kind in ("double", "int64")]
UNITS = {"_m_s": "m/s", "_deg": "deg", "_s": "s", "_m": "m"}


def unit_of(column: str) -> str:
    return next((unit for end, unit in UNITS.items() if column.endswith(end)), "1")


INPUT_UNITS = {"wind": "m/s", "wind_from": "deg"}
INPUT_COLUMNS = {"wind": "wind_m_s", "wind_from": "wind_from_deg"}
