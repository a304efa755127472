"""`./stator fly`: builds a graph for simulation, flies it once, and judges the flight."""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.arguments import path
from stator.build.cmake import PREEMPTION, build, short_name
from stator.diagnostics import ANSWER_IS_NO, UserError, shown_path
from stator.flight.arguments import (
    USUAL_DURATION_S,
    add_flight_arguments,
    failures_of,
    faults_of,
    flight_options,
    is_judged,
    is_recorded,
    is_windy,
    rates_of,
    recording_of,
    setting_of,
    speed_of,
    times_of,
)
from stator.flight.facts import NOT_WHOLE, alone, default_log, facts_of, keep
from stator.flight.progress import progress
from stator.flight.report import report
from stator.mission.model import packed
from stator.mission.read import read_mission
from stator.pipeline import make_plan
from stator.processes import run

if TYPE_CHECKING:
    import subprocess

    from stator.mission.model import Mission


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_flight_arguments(parser, board="sitl", what="a board with a simulated world")
    parser.add_argument(
        "--times",
        choices=["zero", "budget", "random"],
        default="zero",
        help="execution times of activations; with budget or random, tasks preempt others "
        "(default: zero)",
    )
    parser.add_argument(
        "--mission",
        type=path,
        metavar="FILE",
        help="mission to fly: YAML, or a ground station's .plan (docs/missions.md); the default "
        "graph is then graph/quad_outdoor.yaml",
    )
    parser.add_argument(
        "--speed",
        type=speed_of,
        metavar="FACTOR",
        help="highest speed, as a multiple of real time (default: no limit)",
    )
    parser.set_defaults(graph=None, duration=None)


def main(arguments: argparse.Namespace) -> int:
    """0 if the flight was successful; 1 if it failed or could not be judged."""
    mission = None if arguments.mission is None else read_mission(arguments.mission)
    complete(arguments, mission)
    if mission is not None:
        _check_takes_missions(arguments.graph, arguments.board)
    faults = faults_of(arguments)
    variant = {} if arguments.times == "zero" else PREEMPTION
    times = times_of(arguments)
    program = build(
        arguments.graph, arguments.board, variant | recording_of(arguments), executor="virtual"
    )
    kind = f"-{short_name(arguments.mission.resolve())}" if mission else ""
    log = arguments.output or default_log(arguments.graph, arguments.seed, kind)
    truth = log.with_name(f"{log.name.removesuffix('.ulg')}.truth")
    name = f"flying {arguments.graph.stem}, seed {arguments.seed}"
    with alone(log), progress(name, truth, arguments.duration):
        finished = _run(program, log, truth, arguments, mission, times)
        if finished.returncode not in (0, NOT_WHOLE):
            raise UserError(finished.stderr.rstrip())
        facts = facts_of(
            finished,
            log,
            truth,
            mission,
            most_s=arguments.duration,
            judges=is_judged(arguments),
            is_recorded=is_recorded(arguments),
            in_wind=is_windy(arguments),
            setting=setting_of(arguments, mission),
        )
    facts |= {"mission": arguments.mission.stem if arguments.mission else None}
    facts |= failures_of(faults) | rates_of(arguments)
    facts |= {"graph": arguments.graph.stem, "board": arguments.board, "seed": arguments.seed}
    facts["graph_file"] = str(arguments.graph.resolve())
    facts |= {"wind_m_s": arguments.wind, "wind_from_deg": arguments.wind_from}
    keep(facts)
    if arguments.json:
        print(json.dumps(facts, indent=2))
    else:
        report(facts)
    return 0 if facts["success"] else ANSWER_IS_NO


def complete(arguments: argparse.Namespace, mission: Mission | None) -> None:
    """Fills in the defaults of the graph and the duration."""
    if arguments.graph is None:
        name = "quad.yaml" if mission is None else "quad_outdoor.yaml"
        arguments.graph = HOME / "graph" / name
    if arguments.duration is None:
        arguments.duration = max(USUAL_DURATION_S, mission.seconds if mission else 0.0)


def _check_takes_missions(graph: Path, board: str) -> None:
    plan = make_plan(str(graph), board)
    if not any(node.interface.name == "mission" for node in plan.graph.nodes.values()):
        raise UserError(
            f"error: missing node of app 'mission' in {shown_path(graph)}\n"
            "hint: omit GRAPH, or include quad_outdoor.yaml in your graph"
        )


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
        return run(command, check=False, capture_output=True)
    with tempfile.NamedTemporaryFile(suffix=".mission") as file:
        file.write(packed(mission))
        file.flush()
        command += ["--mission", file.name]
        return run(command, check=False, capture_output=True)
