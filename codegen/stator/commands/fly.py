"""`./stator fly`: builds a graph for simulation, flies it once, and judges the flight."""

from __future__ import annotations

import argparse
import json
import signal
from pathlib import Path
from typing import TYPE_CHECKING

from stator.build.cmake import PREEMPTION, SANITIZE, build
from stator.diagnostics import ANSWER_IS_NO, SIGNALLED, UserError
from stator.flight.arguments import (
    add_flight_arguments,
    add_times_argument,
    complete,
    cut_of,
    failures_of,
    faults_of,
    flight_options,
    is_judged,
    is_recorded,
    is_windy,
    memory_of,
    params_of,
    place_options,
    rates_of,
    recording_of,
    setting_of,
    speed_of,
    times_of,
    words_of,
)
from stator.flight.facts import NOT_WHOLE, alone, facts_of, keep, mission_facts
from stator.flight.hil import add_hil_argument, check_hil, complete_hil, hil_facts, hil_options
from stator.flight.kept import keeping, kept_facts, log_of
from stator.flight.links import link_facts
from stator.flight.mavlink import (
    add_lockstep_argument,
    add_mavlink_argument,
    add_signing_argument,
    check_mavlink,
    complete_mavlink,
    mavlink_options,
    serial_lines,
    tell_mavlink,
)
from stator.flight.params import add_param_argument, param_facts
from stator.flight.progress import progress
from stator.flight.report import report
from stator.flight.restarts import Endings

if TYPE_CHECKING:
    import subprocess

    from stator.mission.model import Mission


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_flight_arguments(parser, board="sitl", what="a board with a simulated world")
    add_param_argument(parser)
    add_times_argument(parser)
    parser.add_argument(
        "--sanitize",
        action="store_true",
        help="build with the address and undefined-behaviour sanitizers: slower, and names the "
        "line of an access outside an array, of an overflow, and of a use after an end",
    )
    parser.add_argument(
        "--speed",
        type=speed_of,
        metavar="FACTOR",
        help="highest speed, as a multiple of real time (default: no limit; with --mavlink 1)",
    )
    add_mavlink_argument(parser)
    add_signing_argument(parser)
    add_lockstep_argument(parser)
    add_hil_argument(parser)


def main(arguments: argparse.Namespace) -> int:
    """0 if the flight was successful; 1 if it failed or could not be judged."""
    complete_hil(arguments)
    complete_mavlink(arguments)
    mission = complete(arguments)
    check_mavlink(arguments)
    check_hil(arguments)
    faults = faults_of(arguments)
    params = params_of(arguments)
    variant = {} if arguments.times == "zero" else PREEMPTION
    variant = variant | (SANITIZE if arguments.sanitize else {})
    times = times_of(arguments)
    program = build(
        arguments.graph, arguments.board, variant | recording_of(arguments), executor="virtual"
    )
    log = log_of(arguments, params)
    truth = log.with_name(f"{log.name.removesuffix('.ulg')}.truth")
    name = f"flying {arguments.graph.stem}, seed {arguments.seed}"
    tell_mavlink(arguments)
    with (
        serial_lines(arguments),
        keeping(log, arguments) as kept,
        alone(log),
        progress(name, None if arguments.hil else truth, arguments.duration),
    ):
        finished, heard = _run(program, log, truth, arguments, mission, times)
        cut = cut_of(arguments, heard)
        if finished.returncode > NOT_WHOLE:
            raise UserError(finished.stderr.rstrip())
        facts = facts_of(
            finished,
            log,
            truth,
            mission,
            cut=cut,
            program=program,
            judges=arguments.hil is None and is_judged(arguments),
            is_guided=bool(arguments.mavlink),
            is_recorded=is_recorded(arguments),
            in_wind=is_windy(arguments),
            setting=setting_of(arguments, mission),
        )
    if arguments.hil is not None:
        facts["truth"] = None
        if facts["success"]:
            run = json.loads(finished.stdout)
            facts |= hil_facts(run, cut, is_guided=bool(arguments.mavlink))
    if heard and not arguments.mavlink and facts["success"]:  # nothing was judged
        facts |= {"success": False, "reason": cut}
    facts |= kept_facts(kept) | mission_facts(arguments, mission)
    facts |= link_facts(arguments, log)
    facts |= param_facts(params) | failures_of(faults) | rates_of(arguments)
    facts |= {"graph": arguments.graph.stem, "board": arguments.board, "seed": arguments.seed}
    facts["graph_file"] = str(arguments.graph.resolve())
    facts["options"] = words_of(arguments)
    facts["sanitized"] = arguments.sanitize
    facts |= {"wind_m_s": arguments.wind, "wind_from_deg": arguments.wind_from}
    keep(facts)
    if arguments.json:
        print(json.dumps(facts, indent=2))
    else:
        report(facts)
    if heard and not arguments.mavlink:  # that is how a flight with a ground station ends
        return SIGNALLED + heard
    return 0 if facts["success"] else ANSWER_IS_NO


def _run(
    program: Path,
    log: Path,
    truth: Path,
    arguments: argparse.Namespace,
    mission: Mission | None,
    times: list[str],
) -> tuple[subprocess.CompletedProcess[str], signal.Signals | None]:
    """The end of the program, and the signal that asked for it."""
    command = [str(program), "--log", str(log), *hil_options(arguments)]
    command += ["--truth", str(truth)] if arguments.hil is None else []
    command += [*flight_options(arguments), *times, *mavlink_options(arguments)]
    if arguments.speed is not None:
        command += ["--speed", f"{arguments.speed:.6f}"]
    with memory_of(mission, is_guided=bool(arguments.mavlink)) as memory:
        if memory is not None:
            command += ["--mission", str(memory), *place_options(mission)]
        with Endings() as endings:
            finished = endings.run(command)
        return finished, signal.Signals(endings.heard) if endings.heard else None
