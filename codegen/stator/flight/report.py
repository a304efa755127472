"""Prints the facts of a flight as a table."""

from __future__ import annotations

import shlex
from pathlib import Path

from stator.diagnostics import UserError, in_place, shown_argument, shown_path
from stator.flight.kept import kept_rows
from stator.flight.links import link_rows
from stator.flight.params import param_rows


def report(facts: dict[str, object]) -> None:
    show(facts, [*flight_rows(facts), *_run_rows(facts)])


def show(facts: dict[str, object], more: list[tuple[str, str]]) -> None:
    """The result, and rows of labels and texts."""
    from rich.console import Console

    console = Console(highlight=False, soft_wrap=True, markup=False)
    good = bool(facts["success"])
    title = f"{facts['graph']} on {facts['board']}, seed {facts['seed']}: "
    console.print(title, end="")
    console.print("success" if good else "FAILED", style="bold green" if good else "bold red")
    reasons = str(facts["reason"]).split("; ")
    rows = [("result" if good else "reason", reason) for reason in reasons]
    rows += more
    previous = ""
    for label, text in rows:
        console.print(f"  {'' if label == previous else label:<10}{in_place(text)}")
        previous = label


def flight_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    rows = [*param_rows(facts), *_failure_rows(facts)]
    rows += _mission_rows(facts) if facts.get("mission") and "modes" in facts else []
    limits = facts.get("limits", {})
    assert isinstance(limits, dict)
    if facts["take_off_s"] is not None:
        rows.append(("take-off", f"at {facts['take_off_s']:.2f} s"))
    if facts["max_error_m"] is not None:
        where = f"{facts['hover_s']:.1f} s at {facts['hover_height_m']:.2f} m"
        limit = limit_of(limits.get("hover_m"), "m")
        error = (
            f"error at most {facts['max_error_m']:.3f} m{limit}, RMS {facts['rms_error_m']:.3f} m"
        )
        rows.append(("hover", f"{where}: {error}"))
        for way in ("horizontal", "vertical"):
            key = f"hover_{way}_rms_m"
            if limits.get(key) is not None:
                error = f"{way} RMS error {facts[key]:.3f} m"
                rows.append(("hover", f"{error}{limit_of(limits[key], 'm')}"))
    if facts["attitude_error_deg"] is not None:
        error = f"RMS error of the estimate in flight {facts['attitude_error_deg']:.2f} deg"
        rows.append(("tilt", f"{error}{limit_of(limits.get('tilt_error_deg'), 'deg')}"))
    if facts["touchdown_m_s"] is not None:
        when = f"at {facts['touchdown_s']:.2f} s, {facts['touchdown_m_s']:.2f} m/s"
        most = limits.get("touchdown_speed" if facts.get("mission") else "touchdown_m_s")
        rows.append(("touchdown", f"{when}{limit_of(most, 'm/s')}"))
    return rows


def _failure_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    failures, unseen = facts.get("failures", []), facts.get("unseen_failures", [])
    assert isinstance(failures, list)
    assert isinstance(unseen, list)
    shown = "; no sensor of this graph can show it"
    return [("failures", f"{text}{shown if text in unseen else ''}") for text in failures]


def limit_of(most: float | None, unit: str) -> str:
    return "" if most is None else f" (limit {most:g} {unit})"


MAX_ITEM_ROWS = 40
# Measured facts of a mission: the limit in its file, and the text.
MEASURED = {
    "corridor_m": ("corridor", "greatest distance from the straight path"),
    "landing_error_m": ("landing_error", "distance from the planned place at the landing"),
    "hold_horizontal_rms_m": ("hold_horizontal_rms", "horizontal RMS error while staying"),
    "hold_vertical_rms_m": ("hold_vertical_rms", "vertical RMS error while staying"),
    "tracking_rms_m": (
        "tracking_rms",
        "horizontal RMS distance of estimate and setpoint while moving",
    ),
}
ERRORS = {
    "truth_off_setpoint": "distance of truth and setpoint",
    "estimate_off_setpoint": "distance of estimate and setpoint",
    "estimate_off_truth": "distance of estimate and truth",
}


def _mission_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    items, modes, limits = facts.get("items", []), facts["modes"], facts["limits"]
    assert isinstance(items, list)
    assert isinstance(modes, list)
    assert isinstance(limits, dict)
    text = f"{facts['items_reached']} of {facts['items_total']} items reached"
    others = facts.get("items_uncounted", [])
    assert isinstance(others, list)
    if others:
        names = ", ".join(dict.fromkeys(map(str, others)))
        text += f"; {len(others)} more without a place to reach: {names}"
    rows = [("mission", text)]
    notes = facts.get("mission_notes", [])
    assert isinstance(notes, list)
    rows += [("note", str(note)) for note in notes]
    for number, item in enumerate(items, 1):
        when = item["reached_s"]
        reached = "not reached" if when is None else f"{when:6.2f} s"
        rows.append(("items", f"{item.get('number', number):2} {item['kind']:<16}{reached}"))
    if len(rows) > MAX_ITEM_ROWS:
        left = len(rows) - MAX_ITEM_ROWS
        rows[MAX_ITEM_ROWS:] = [("items", f"and {left} more; --json has them all")]
    for mode in modes:
        why = f"  failsafe {mode['failsafe']}" if mode["failsafe"] else ""
        state = mode["mode"] if mode["armed"] else "disarmed"
        rows.append(("modes", f"   {state:<16}{mode['time_s']:6.2f} s{why}"))
    for key, (limit, text) in MEASURED.items():
        if facts.get(key) is not None:
            most = f" (limit {limits[limit]:g} m)" if limit in limits else ""
            rows.append(("measured", f"{facts[key]:6.2f} m  {text}{most}"))
    for key, text in ERRORS.items():
        if facts.get(f"{key}_rms_m") is not None:
            worst = f"at most {facts[f'{key}_max_m']:.2f} m"
            rows.append(("in flight", f"{facts[f'{key}_rms_m']:6.2f} m  RMS {text}; {worst}"))
    return rows


def log_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    log = Path(str(facts["log"]))
    size = f"{shown_path(log)} ({log.stat().st_size / 1e6:.1f} MB)"
    most, stored = facts.get("recording_bytes_per_s"), facts.get("storage_bytes_per_s")
    if most is None:
        return [("log", size), *kept_rows(facts)]
    rows = [("log", f"{size}; highest rate {_kilobytes(most)}, recording included")]
    if stored is not None:
        takes = f"{facts['storage_board']} stores {_kilobytes(stored)}"
        if int(str(most)) > int(str(stored)):
            takes += ": LESS than the highest rate; hint: --no-record writes no recording"
        rows.append(("storage", takes))
    return [*rows, *kept_rows(facts)]


def _kilobytes(rate: object) -> str:
    return f"{int(str(rate)) / 1000:.0f} kB/s"


def _run_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    rows = []
    if facts["duration_s"] is not None:
        speed = f"{facts['duration_s']:.1f} s at {facts['speed_vs_real_time']:.0f} times real time"
        counts = f"{facts['activations']:,} activations, {facts['lost_samples']} samples lost"
        if facts.get("missed_samples"):
            counts += f", {facts['missed_samples']} missed by devices"
        rows.append(("run", f"{speed}; {counts}"))
    if facts.get("image"):
        flash = "./stator flash --record" if facts["recording"] else "./stator flash"
        image = f"{shown_path(Path(str(facts['image'])))}, as {flash} writes it"
        rows += [("image", image), ("image", f"SHA-256 {facts['image_sha256']}")]
    rows += [*link_rows(facts), *log_rows(facts), *watch_rows(facts)]
    crash = facts.get("crash")
    if isinstance(crash, dict):
        return [*rows, *_crash_rows(crash, facts)]
    if not facts["success"]:
        rows += picture_row(facts)
        rows.append(("next", "repeat the command: it flies the same flight"))
        return rows
    file = Path(str(facts["log"]))
    log = shown_argument(file)
    if file.stat().st_size:  # a graph without a logger leaves it empty
        rows.append(("next", f"draw it: ./stator plot {log}"))
    if facts["recording"] is not None and not facts["unrecorded_activations"]:
        rows.append(("next", f"repeat it bit for bit: ./stator replay {log}"))
    return rows


def _crash_rows(crash: dict[str, object], facts: dict[str, object]) -> list[tuple[str, str]]:
    options = facts.get("options", [])  # of a simulated flight
    assert isinstance(options, list)
    graph = shown_argument(Path(str(facts["graph_file"])))
    flight = f"{graph} {shlex.join(options)}".rstrip()
    rows = []
    if crash["input"]:
        rows.append(("hint", f"test it before it is read: if (!ports.{crash['input']}) return;"))
    if crash["node"]:
        where = f"--node {crash['node']} --at {crash['at_s']:.6f}"
        rows.append(("next", f"stop there in a debugger: ./stator debug {flight} {where}"))
    if not crash["input"] and crash["signal"] != "ENDLESS" and not facts.get("sanitized"):
        again = f"./stator fly {flight} --sanitize"
        rows.append(("next", f"let sanitizers find the cause: {again}"))
    return rows


def watch_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    """Bad facts that every kind of flight can have."""
    rows = []
    if facts["missed_life_signs"]:
        missed = f"{facts['missed_life_signs']} missed life signs; the log names the tasks"
        rows.append(("life signs", missed))
    if facts["refused_publications"]:
        refused = f"{facts['refused_publications']} publications, the last of"
        rows.append(
            ("refused", f"{refused} {facts['refused_output']}: more than its `burst` allows")
        )
    if facts["unrecorded_activations"]:
        lost = f"{facts['unrecorded_activations']:,} activations are not recorded (buffer full)"
        rows.append(("recording", f"it has a gap: {lost}; a replay ends there"))
    return rows


def picture_row(facts: dict[str, object]) -> list[tuple[str, str]]:
    """Draws the flight. No row if the log has no path."""
    from stator.flight.plot import draw

    log = Path(str(facts["log"]))
    picture = log.with_suffix(".png")
    try:
        draw(log, picture)
    except UserError:
        return []
    return [("picture", shown_path(picture))]
