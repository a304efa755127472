"""What `./stator fly` does: builds a graph for simulation, flies it once, and reports."""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import signal
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from stator.build import PREEMPTION, RECORDING, build
from stator.cli import make_plan, path
from stator.diagnostics import UserError, shown_path
from stator.library import HOME
from stator.mission import packed, read_mission
from stator.progress import progress

if TYPE_CHECKING:
    from stator.flight import Judgement, Problem
    from stator.mission import Mission

MOST_SEED = 2**64 - 1
MOST_DURATION_S = 1e6
MOST_SPEED = 1e4
USUAL_DURATION_S = 120.0
MOST_WIND_M_S = 50.0
MOST_DEGREES = 360.0


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_flight_arguments(parser, board="sitl", what="a board that simulates")
    parser.add_argument(
        "--times",
        choices=["zero", "budget", "random"],
        default="zero",
        help="let activations take time, so that others preempt them (default: zero)",
    )
    parser.add_argument(
        "--mission",
        type=path,
        metavar="FILE",
        help="what to fly: YAML, or a ground station's .plan (docs/missions.md); "
        "without GRAPH flies graph/quad_outdoor.yaml",
    )
    parser.add_argument(
        "--speed",
        type=speed_of,
        metavar="FACTOR",
        help="at most so many times real time; 1 is real time (default: as fast as it goes)",
    )
    parser.set_defaults(graph=None, duration=None)


def add_flight_arguments(parser: argparse.ArgumentParser, board: str, what: str) -> None:
    """What simulated and emulated flights have in common."""
    graph = HOME / "graph" / "quad.yaml"
    parser.add_argument(
        "graph", nargs="?", type=Path, default=graph, help="a graph file (default: graph/quad.yaml)"
    )
    parser.add_argument("--board", default=board, help=f"{what} (default: {board})")
    parser.add_argument(
        "--seed",
        type=seed_of,
        default=1,
        help="of the start, the sensors and their noise (default: 1)",
    )
    parser.add_argument(
        "--vary",
        action="store_true",
        help="another mass, inertia, thrust, centre of gravity, delay and biases for each seed",
    )
    parser.add_argument(
        "--wind", type=wind_of, default=0.0, metavar="M_S", help="mean wind in m/s (default: 0)"
    )
    parser.add_argument(
        "--wind-from",
        type=degrees_of,
        default=0.0,
        metavar="DEG",
        help="where the wind comes from, from north over east (default: 0)",
    )
    parser.add_argument(
        "--gusts",
        choices=["none", "light", "moderate", "severe"],
        default="none",
        help="of MIL-F-8785C (default: none)",
    )
    parser.add_argument(
        "--fail",
        action="append",
        default=[],
        metavar="WHAT@S[+S]",
        help="what fails, from when on, and for how long: gnss_loss, gnss_glitch[=METRES], "
        "baro_loss, mission_loss, rc_loss, battery_low[=0..1], motor_1 to motor_4[=0..1]; may be "
        "given several times",
    )
    parser.add_argument(
        "--pilot",
        type=path,
        metavar="FILE",
        help="script of sticks and switches (docs/simulation.md)",
    )
    parser.add_argument(
        "--duration",
        type=duration_of,
        default=USUAL_DURATION_S,
        help="most seconds of flight (default: 120, or what a mission may need)",
    )
    parser.add_argument("-o", "--output", type=path, metavar="LOG", help="where to keep the log")
    parser.add_argument(
        "--no-record",
        action="store_true",
        help="leave out of the log what ./stator replay needs: it is smaller, the flight faster",
    )
    parser.add_argument("--json", action="store_true", help="print what programs read")


def flight_options(arguments: argparse.Namespace) -> list[str]:
    """For the program that flies, what decides a flight besides the graph."""
    options = ["--seed", str(arguments.seed), "--duration", f"{arguments.duration:.6f}"]
    options += ["--wind", f"{arguments.wind:.6f}", "--wind-from", f"{arguments.wind_from:.6f}"]
    options += ["--gusts", arguments.gusts, "--vary", "yes" if arguments.vary else "no"]
    options += [word for fault in arguments.fail for word in ("--fail", fault)]
    if arguments.pilot is not None:
        options += ["--pilot", str(arguments.pilot.resolve())]
    return options


def rates_of(arguments: argparse.Namespace) -> dict[str, object]:
    """What a recording takes as a rule at most, and what the graph's own board can store."""
    from stator.emit_recording import bytes_per_second, is_recordable, storage_bytes_per_second

    plan = make_plan(str(arguments.graph), None)
    if arguments.no_record or not is_recordable(plan):
        return {}
    return {
        "recording_bytes_per_s": bytes_per_second(plan),
        "storage_bytes_per_s": storage_bytes_per_second(plan),
        "storage_board": plan.graph.board.name,
    }


def speed_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0.0 < float(text) <= MOST_SPEED:
            return float(text)
    raise argparse.ArgumentTypeError(f"'{text}' is no factor above 0, at most {MOST_SPEED:.0f}")


def times_of(arguments: argparse.Namespace) -> list[str]:
    """For the program that flies, how long activations take. Raises `UserError`."""
    if arguments.times != "budget":
        return ["--times", arguments.times]
    # Of the board that the graph is for: a simulated one has no times of its own.
    plan = make_plan(str(arguments.graph), None)
    budgets = {name: node.budget_us for name, node in plan.graph.nodes.items()}
    missing = [name for name, budget in budgets.items() if budget is None]
    if missing:
        shown = ", ".join(f"'{name}'" for name in missing)
        raise UserError(
            f"error: --times budget: no budget of {shown}\n"
            f"hint: add `budget: 50 us` to the node, or a file budgets/{plan.board.name}.yaml "
            f"beside the graph, with lines such as `{missing[0]}: 50 us`"
        )
    return ["--budgets", ",".join(f"{name}={budget}" for name, budget in budgets.items())]


def recording_of(arguments: argparse.Namespace) -> dict[str, str]:
    """What CMake needs to know of it."""
    return {} if arguments.no_record else RECORDING


def seed_of(text: str) -> int:
    if text.isascii() and text.isdigit() and int(text) <= MOST_SEED:
        return int(text)
    raise argparse.ArgumentTypeError(f"'{text}' is no whole number from 0 to {MOST_SEED}")


def wind_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0.0 <= float(text) <= MOST_WIND_M_S:
            return float(text)
    raise argparse.ArgumentTypeError(f"'{text}' is no number of m/s from 0 to {MOST_WIND_M_S:.0f}")


def degrees_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if abs(float(text)) <= MOST_DEGREES:
            return float(text)
    raise argparse.ArgumentTypeError(f"'{text}' is no number of degrees from -360 to 360")


def duration_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0.0 < float(text) <= MOST_DURATION_S:
            return float(text)
    most = f"{MOST_DURATION_S:.0f}"
    raise argparse.ArgumentTypeError(f"'{text}' is no number of seconds above 0, at most {most}")


def main(arguments: argparse.Namespace) -> int:
    """0: a successful flight. 1: a failed one, or one that could not be judged. 2: no flight."""
    try:
        mission = None if arguments.mission is None else read_mission(arguments.mission)
        complete(arguments, mission)
        variant = {} if arguments.times == "zero" else PREEMPTION
        times = times_of(arguments)
        program = build(
            arguments.graph, arguments.board, variant | recording_of(arguments), executor="virtual"
        )
    except UserError as failed:
        print(failed, file=sys.stderr)
        return 2
    kind = f"-{arguments.mission.stem}" if mission else ""
    log = arguments.output or default_log(arguments.graph, arguments.seed, kind)
    truth = log.with_name(f"{log.name.removesuffix('.ulg')}.truth")
    name = f"flying {arguments.graph.stem}, seed {arguments.seed}"
    with progress(name, truth, arguments.duration):
        finished = _run(program, log, truth, arguments, mission, times)
        if finished.returncode > 0:
            print(finished.stderr.rstrip(), file=sys.stderr)
            return 2
        facts = facts_of(finished, log, truth, mission, is_recorded=not arguments.no_record)
    facts |= {"mission": arguments.mission.stem if arguments.mission else None}
    facts |= rates_of(arguments)
    facts |= {"graph": arguments.graph.stem, "board": arguments.board, "seed": arguments.seed}
    facts |= {"wind_m_s": arguments.wind, "wind_from_deg": arguments.wind_from}
    keep(facts)
    if arguments.json:
        print(json.dumps(facts, indent=2))
    else:
        report(facts)
    return 0 if facts["success"] else 1


def keep(facts: dict[str, object]) -> None:
    """The report, beside the log: `./stator plot` draws with it."""
    log = Path(str(facts["log"]))
    report = json.dumps(facts, indent=2) + "\n"
    log.with_name(f"{log.name.removesuffix('.ulg')}.json").write_text(report, encoding="utf-8")


def complete(arguments: argparse.Namespace, mission: Mission | None) -> None:
    """What the user left out."""
    if arguments.graph is None:
        name = "quad.yaml" if mission is None else "quad_outdoor.yaml"
        arguments.graph = HOME / "graph" / name
    if arguments.duration is None:
        arguments.duration = max(USUAL_DURATION_S, mission.seconds if mission else 0.0)


def default_log(graph: Path, seed: int, kind: str = "") -> Path:
    folder = HOME / "build" / "flights"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{graph.stem}-seed{seed}{kind}.ulg"


def _run(
    program: Path,
    log: Path,
    truth: Path,
    arguments: argparse.Namespace,
    mission: Mission | None,
    times: list[str],
) -> subprocess.CompletedProcess[str]:
    command = [str(program), "--log", str(log), "--truth", str(truth)]
    command += [*flight_options(arguments), *times]
    if arguments.speed is not None:
        command += ["--speed", f"{arguments.speed:.6f}"]
    if mission is None:
        return subprocess.run(command, check=False, capture_output=True, text=True)
    with tempfile.NamedTemporaryFile(suffix=".mission") as file:
        file.write(packed(mission))
        file.flush()
        command += ["--mission", file.name]
        return subprocess.run(command, check=False, capture_output=True, text=True)


def facts_of(
    finished: subprocess.CompletedProcess[str],
    log: Path,
    truth: Path,
    mission: Mission | None = None,
    *,
    judges: bool = True,
    is_recorded: bool = False,
) -> dict[str, object]:
    """What `--json` prints. A fact that there is none of is None."""
    facts: dict[str, object] = {
        "success": False,
        "reason": "",
        "problems": [],
        "log": str(log.resolve()),
        "log_sha256": _sha256(log),
        "truth": str(truth.resolve()),
        "recording": str(log.resolve()) if is_recorded else None,
        "speed_vs_real_time": None,
        "lost_samples": None,
        "activations": None,
        "preemptions": None,
        "unrecorded_activations": None,
        "duration_s": None,
        "max_error_m": None,
        "rms_error_m": None,
        "hover_s": None,
        "hover_height_m": None,
        "attitude_error_deg": None,
        "take_off_s": None,
        "touchdown_s": None,
        "touchdown_m_s": None,
    }
    if finished.returncode < 0:
        name = signal.Signals(-finished.returncode).name
        facts["reason"] = f"the flight program died of {name}: {finished.stderr.strip()}"
        return facts
    run = json.loads(finished.stdout)
    facts["speed_vs_real_time"] = run["simulated_s"] / run["wall_s"]
    facts["duration_s"] = run["simulated_s"]
    facts |= {key: value for key, value in run.items() if key in facts}
    if not is_recorded:
        facts |= {"preemptions": None, "unrecorded_activations": None}
    if not judges:
        return facts | {"success": True, "reason": "ran to its end"}
    return facts | _judged(log, truth, run, mission)


def _judged(
    log: Path, truth: Path, run: dict[str, object], mission: Mission | None
) -> dict[str, object]:
    from pyulog import ULog

    from stator.flight import UnreadableFlight, judge, read_flight, read_truth
    from stator.mission_flight import judge_mission

    if log.stat().st_size == 0:
        return {"reason": "the log is empty, so the flight cannot be judged"}
    try:
        ulog = ULog(str(log))
        flight = read_flight(ulog, read_truth(truth), run)
        if mission is not None:
            flown = judge_mission(ulog, flight, mission)
            return flown.facts | _verdict(flown.problems)
        judgement = judge(flight)
    except UnreadableFlight as unreadable:
        return {"reason": str(unreadable)}
    return _judgement_facts(judgement)


def _verdict(problems: list[Problem]) -> dict[str, object]:
    texts = [problem.text for problem in problems]
    return {
        "success": not problems,
        "reason": "; ".join(texts) or "landed and disarmed, within all limits",
        "problems": [problem.as_json() for problem in problems],
    }


def _judgement_facts(judgement: Judgement) -> dict[str, object]:
    facts = _verdict(judgement.problems)
    if judgement.hover is not None:
        facts |= {
            "max_error_m": judgement.hover.max_error_m,
            "rms_error_m": judgement.hover.rms_error_m,
            "hover_s": judgement.hover.seconds,
            "hover_height_m": judgement.hover.height_m,
        }
    if judgement.tilt is not None:
        facts["attitude_error_deg"] = judgement.tilt.rms_deg
    return facts


def _sha256(log: Path) -> str:
    with log.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


# --- for people ---


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
    rows = [("result" if good else "why", reason) for reason in reasons]
    rows += more
    previous = ""
    for label, text in rows:
        console.print(f"  {'' if label == previous else label:<10}{text}")
        previous = label


def flight_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    from stator.flight import MOST_ERROR_M, MOST_TILT_ERROR_DEG, MOST_TOUCHDOWN_M_S

    rows = _mission_rows(facts) if facts.get("mission") else []
    if facts["take_off_s"] is not None:
        rows.append(("take-off", f"at {facts['take_off_s']:.2f} s"))
    if facts["max_error_m"] is not None:
        where = f"{facts['hover_s']:.1f} s at {facts['hover_height_m']:.2f} m"
        error = f"{facts['max_error_m']:.3f} m off at most, {facts['rms_error_m']:.3f} m RMS"
        rows.append(("hover", f"{where}: {error} (limit {MOST_ERROR_M:g} m)"))
    if facts["attitude_error_deg"] is not None:
        error = f"{facts['attitude_error_deg']:.2f} deg RMS error of the estimate in flight"
        rows.append(("tilt", f"{error} (limit {MOST_TILT_ERROR_DEG:g} deg)"))
    if facts["touchdown_m_s"] is not None:
        when = f"at {facts['touchdown_s']:.2f} s with {facts['touchdown_m_s']:.2f} m/s"
        limits = facts.get("limits")
        most = limits["touchdown_speed"] if isinstance(limits, dict) else MOST_TOUCHDOWN_M_S
        rows.append(("touchdown", f"{when} (limit {most:g} m/s)"))
    return rows


# Facts of a mission, the limit of its file that each is held to, and what they say.
MEASURED = {
    "corridor_m": ("corridor", "off the straight way at most"),
    "landing_error_m": ("landing_error", "from home at the landing"),
    "hold_horizontal_rms_m": ("hold_horizontal_rms", "horizontal RMS while staying"),
    "hold_vertical_rms_m": ("hold_vertical_rms", "vertical RMS while staying"),
    "tracking_rms_m": ("tracking_rms", "horizontal RMS of estimate off setpoint, moving"),
}
ERRORS = {
    "truth_off_setpoint": "truth off setpoint",
    "estimate_off_setpoint": "estimate off setpoint",
    "estimate_off_truth": "estimate off truth",
}


def _mission_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    items, modes, limits = facts.get("items", []), facts["modes"], facts["limits"]
    assert isinstance(items, list)
    assert isinstance(modes, list)
    assert isinstance(limits, dict)
    rows = [("mission", f"{facts['items_reached']} of {facts['items_total']} items reached")]
    for number, item in enumerate(items, 1):
        when = item["reached_s"]
        reached = "not reached" if when is None else f"{when:6.2f} s"
        rows.append(("items", f"{number:2} {item['kind']:<16}{reached}"))
    for mode in modes:
        why = f"  because of {mode['failsafe']}" if mode["failsafe"] else ""
        state = mode["mode"] if mode["armed"] else "disarmed"
        rows.append(("modes", f"   {state:<16}{mode['time_s']:6.2f} s{why}"))
    for key, (limit, text) in MEASURED.items():
        if facts.get(key) is not None:
            most = f" (limit {limits[limit]:g} m)" if limit in limits else ""
            rows.append(("measured", f"{facts[key]:6.2f} m  {text}{most}"))
    for key, text in ERRORS.items():
        if facts.get(f"{key}_rms_m") is not None:
            worst = f"{facts[f'{key}_max_m']:.2f} m at most"
            rows.append(("in flight", f"{facts[f'{key}_rms_m']:6.2f} m  RMS {text}, {worst}"))
    return rows


def log_row(facts: dict[str, object]) -> tuple[str, str]:
    log = Path(str(facts["log"]))
    size = f"{shown_path(log)} ({log.stat().st_size / 1e6:.1f} MB)"
    if "recording_bytes_per_s" not in facts:
        return "log", size
    rate = f"at most {_kilobytes(facts['recording_bytes_per_s'])} with the recording"
    if facts["storage_bytes_per_s"] is None:
        return "log", f"{size}: {rate}"
    takes = f"{facts['storage_board']} stores {_kilobytes(facts['storage_bytes_per_s'])}"
    return "log", f"{size}: {rate}; {takes}"


def _kilobytes(rate: object) -> str:
    return f"{int(str(rate)) / 1000:.0f} kB/s"


def _run_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    rows = []
    if facts["duration_s"] is not None:
        speed = f"{facts['duration_s']:.1f} s at {facts['speed_vs_real_time']:.0f} times real time"
        counts = f"{facts['activations']:,} activations, {facts['lost_samples']} samples lost"
        rows.append(("run", f"{speed}; {counts}"))
    rows.append(log_row(facts))
    if facts["unrecorded_activations"]:
        lost = f"{facts['unrecorded_activations']:,} activations found no room"
        rows.append(("recording", f"it has a gap: {lost}"))
    if not facts["success"]:
        rows += picture_row(facts)
        rows.append(("next", "the same command flies the same flight again"))
        return rows
    log = shown_path(Path(str(facts["log"])))
    rows.append(("next", f"./stator plot {log} draws it"))
    if facts["recording"] is not None:
        rows.append(("next", f"./stator replay {log} repeats it bit for bit"))
    return rows


def picture_row(facts: dict[str, object]) -> list[tuple[str, str]]:
    """Draws the flight; nothing if its log holds no path."""
    from stator.plot import draw

    log = Path(str(facts["log"]))
    picture = log.with_suffix(".png")
    try:
        draw(log, picture)
    except UserError:
        return []
    return [("picture", f"{shown_path(picture)} shows where")]
