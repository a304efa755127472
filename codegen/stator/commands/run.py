"""`./stator run`: builds a graph for threads, runs it in real time, and judges the flight."""

from __future__ import annotations

import argparse
import contextlib
import json
import signal
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator.arguments import path
from stator.build.cmake import build
from stator.diagnostics import (
    ANSWER_IS_NO,
    NOT_DONE,
    SIGNALLED,
    UserError,
    in_place,
    shown_argument,
    shown_path,
)
from stator.flight.arguments import (
    add_flight_arguments,
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
)
from stator.flight.facts import complaint_of, facts_of, keep, mission_facts
from stator.flight.kept import default_log, keeping, kept_facts, log_of
from stator.flight.mavlink import (
    add_mavlink_argument,
    add_signing_argument,
    check_mavlink,
    complete_mavlink,
    mavlink_options,
    serial_lines,
    tell_mavlink,
)
from stator.flight.nonvolatile import (
    add_nonvolatile_argument,
    nonvolatile_facts,
    nonvolatile_of,
    nonvolatile_rows,
)
from stator.flight.params import add_param_argument, param_facts
from stator.flight.progress import progress
from stator.flight.report import flight_rows, log_rows, show, watch_rows
from stator.flight.restarts import run_lives
from stator.live.place import DEFAULT as LINK
from stator.live.place import free_place, socket_place, with_graph
from stator.pipeline import make_plan

if TYPE_CHECKING:
    import subprocess
    from collections.abc import Iterator

    from stator.flight.invariants import Setting
    from stator.mission.model import Mission

MIN_SPEED = 0.001
MAX_CPUS = 64
OWN_FACTS = (
    "missed_samples",
    "missed_releases",
    "real_time",
    "not_allowed",
    "levels",
    "nonvolatile",
)


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_flight_arguments(parser, board="linux", what="a board that runs on threads")
    add_param_argument(parser)
    _add_device_arguments(parser)
    machine = parser.add_argument_group("this machine")
    machine.add_argument(
        "--speed",
        type=slow_speed_of,
        default=1.0,
        metavar="FACTOR",
        help="speed of the graph's clock, at most 1 (real time). Use less under a debugger, "
        "valgrind or a sanitizer, or on a slow machine (default: 1)",
    )
    machine.add_argument(
        "--cpus",
        type=cpus_of,
        metavar="LIST",
        help="processors to use, for example 1 or 0,2-3 (default: all)",
    )
    machine.add_argument(
        "--link",
        type=path,
        metavar="PATH",
        help="socket for ./stator top, listener and perf (default: build/link; build/link2 and so "
        "on while another run uses it)",
    )


def _add_device_arguments(parser: argparse.ArgumentParser) -> None:
    devices = parser.add_argument_group("devices")
    devices.add_argument(
        "--can", metavar="INTERFACE", help="CAN interface of the device can1, for example can0"
    )
    parts = devices.add_mutually_exclusive_group()
    parts.add_argument(
        "--no-can-parts",
        action="store_true",
        help="do not simulate the motor controllers and the receiver on the CAN bus: they are real",
    )
    parts.add_argument(
        "--can-parts",
        metavar="INTERFACE",
        help="simulate them on this interface; your own program or bridge connects it to the "
        "vehicle's interface",
    )
    add_nonvolatile_argument(devices, "a .records file beside the log")
    add_mavlink_argument(devices)
    add_signing_argument(devices)


def slow_speed_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if MIN_SPEED <= float(text) <= 1.0:
            return float(text)
    raise argparse.ArgumentTypeError(
        f"expected a factor from {MIN_SPEED} to 1, found '{text}'; to simulate faster than real "
        "time, use ./stator fly"
    )


def cpus_of(text: str) -> int:
    """The mask of a list of processors such as 0,2-3."""
    mask = 0
    for part in text.split(","):
        first, dash, last = part.partition("-")
        ends = [first, last if dash else first]
        if not all(end.isascii() and end.isdigit() and int(end) < MAX_CPUS for end in ends):
            raise argparse.ArgumentTypeError(
                f"expected processors from 0 to {MAX_CPUS - 1}, for example 0,2-3, found '{text}'"
            )
        mask |= sum(1 << cpu for cpu in range(int(ends[0]), int(ends[1]) + 1))
    if mask == 0:
        raise argparse.ArgumentTypeError(f"expected at least one processor, found none in '{text}'")
    return mask


def main(arguments: argparse.Namespace) -> int:
    """0 if it ran to its end, and a vehicle flew within all limits; 1 if not, or if the flight
    could not be judged; 128 plus the number of the signal that ended it."""
    complete_mavlink(arguments)
    mission = complete(arguments)
    check_mavlink(arguments)
    tell_mavlink(arguments)
    faults = faults_of(arguments)
    params = params_of(arguments)
    log = log_of(arguments, params, ".run")
    truth = log.with_name(f"{log.name.removesuffix('.ulg')}.truth")
    program = build(arguments.graph, arguments.board, recording_of(arguments), executor="pthread")
    flies = _flies(arguments)
    plain = arguments.output or default_log(arguments.graph, arguments.seed, ".run")
    memory = nonvolatile_of(arguments, plain)
    name = f"running {arguments.graph.stem} for at most {arguments.duration:g} s (Ctrl-C to end)"
    lines = serial_lines(arguments)
    plans = memory_of(mission, is_guided=bool(arguments.mavlink))
    with lines, _link_of(arguments) as link, plans as plan_memory:

        def command_of(duration_s: float) -> list[str]:
            life = argparse.Namespace(**(vars(arguments) | {"duration": duration_s}))
            command = _command(program, log, truth, memory, link, life)
            if plan_memory is not None:
                command += ["--mission", str(plan_memory), *place_options(mission)]
            return command

        noted = with_graph(link, arguments.graph)
        with noted, keeping(log, arguments) as kept, progress(name, truth, arguments.duration):
            finished, earlier = run_lives(command_of, log, arguments.duration)
    if finished.returncode == NOT_DONE:
        raise UserError(finished.stderr.rstrip())
    facts = _facts(
        finished,
        program,
        log,
        truth,
        cut=cut_of(arguments),
        mission=mission,
        flies=flies,
        is_guided=bool(arguments.mavlink),
        is_recorded=is_recorded(arguments),
        in_wind=is_windy(arguments),
        setting=setting_of(arguments, mission),
    )
    facts |= param_facts(params) | failures_of(faults)
    facts |= kept_facts(kept) | mission_facts(arguments, mission)
    facts["logs_before_restart"] = [str(path.resolve()) for path in earlier]
    facts["nonvolatile"] = nonvolatile_facts(memory, facts.get("nonvolatile"))
    facts |= rates_of(arguments)
    facts["link"] = None if link is None else str(link)
    facts |= {"graph": arguments.graph.stem, "board": arguments.board, "seed": arguments.seed}
    facts["graph_file"] = str(arguments.graph.resolve())
    facts["speed"] = arguments.speed
    keep(facts)  # first, as a terminal that was closed shows no report
    _report(facts, earlier, as_json=arguments.json)
    if finished.returncode > SIGNALLED:
        return finished.returncode
    return 0 if facts["success"] else ANSWER_IS_NO


@contextlib.contextmanager
def _link_of(arguments: argparse.Namespace) -> Iterator[Path | None]:
    if arguments.link is not None:
        yield socket_place(arguments.link)
        return
    with free_place() as link:
        if not arguments.json:
            _tell_link(link)
        yield link


def _tell_link(link: Path | None) -> None:
    """Prints how to find this run, if it is not at the default place."""
    if link is None:
        note = "note: this run has no link for ./stator top; to get one, add --link /tmp/link"
        print(in_place(note), file=sys.stderr)
    elif link != LINK:
        print(
            f"note: another run uses {shown_path(LINK)}; the link of this run is "
            f"--link {shown_argument(link)}",
            file=sys.stderr,
        )


def _flies(arguments: argparse.Namespace) -> bool:
    """Whether there is a flight to judge. Raises `UserError` if graph and options do not fit."""
    tasks = make_plan(str(arguments.graph), arguments.board).tasks
    has_can = any(task.node.device == "can1" for task in tasks)
    if has_can and arguments.can is None:
        raise UserError(
            f"error: missing option --can: {arguments.graph.stem} has a CAN bus\n"
            "hint: add --can vcan0; to create this interface: ip link add vcan0 type vcan && "
            "ip link set vcan0 up"
        )
    if arguments.can is not None and not has_can:
        raise UserError(f"error: unknown device can1 of {arguments.graph.stem}\nhint: remove --can")
    if arguments.can_parts is not None and arguments.can is None:
        raise UserError("error: missing option --can: --can-parts needs it\nhint: add --can vcan0")
    has_motors = any(task.node.device == "motors" for task in tasks)
    return is_judged(arguments) and (has_motors or not arguments.no_can_parts)


def _command(
    program: Path,
    log: Path,
    truth: Path,
    memory: Path | None,
    link: Path | None,
    arguments: argparse.Namespace,
) -> list[str]:
    command = [str(program), "--log", str(log), "--truth", str(truth)]
    command += [] if link is None else ["--link", str(link)]
    command += [*flight_options(arguments), "--speed", f"{arguments.speed:.6f}"]
    command += mavlink_options(arguments)
    if arguments.can is not None:
        command += ["--can", arguments.can]
        if not arguments.no_can_parts:
            command += ["--can-parts", arguments.can_parts or arguments.can]
    if memory is not None:
        command += ["--nonvolatile", str(memory)]
    if arguments.cpus is not None:
        command += ["--cpus", f"{arguments.cpus:x}"]
    return command


def _facts(
    finished: subprocess.CompletedProcess[str],
    program: Path,
    log: Path,
    truth: Path,
    *,
    cut: str,
    mission: Mission | None,
    flies: bool,
    is_guided: bool,
    is_recorded: bool,
    in_wind: bool,
    setting: Setting,
) -> dict[str, Any]:
    facts: dict[str, Any] = facts_of(
        finished,
        log,
        truth,
        mission,
        cut=cut,
        program=program,
        judges=flies,
        is_guided=is_guided,
        is_recorded=is_recorded,
        in_wind=in_wind,
        setting=setting,
    )
    if finished.returncode < 0:
        return facts
    run = json.loads(finished.stdout)
    facts |= {key: run[key] for key in OWN_FACTS}
    if finished.returncode > SIGNALLED:
        name = signal.Signals(finished.returncode - SIGNALLED).name
        reasons = [f"{name} after {run['wall_s']:.1f} s", complaint_of(finished)]
        facts |= {"success": False, "reason": "; ".join(filter(None, reasons))}
    return facts


# --- for people ---


def _report(facts: dict[str, Any], earlier: list[Path], *, as_json: bool) -> None:
    if as_json:
        print(json.dumps(facts, indent=2))
        return
    rows = [*flight_rows(facts), *_run_rows(facts), *nonvolatile_rows(facts)]
    show(facts, [*rows, *_restart_rows(earlier), *log_rows(facts), *watch_rows(facts)])


def _restart_rows(earlier: list[Path]) -> list[tuple[str, str]]:
    text = "on an authorised request; earlier log:"
    return [("restarted", f"{text} {shown_path(log)}") for log in earlier]


def _run_rows(facts: dict[str, Any]) -> list[tuple[str, str]]:
    if "levels" not in facts:
        return []
    missed = f"{facts['missed_samples']} device samples, {facts['missed_releases']} releases"
    load = sum(level["load"] for level in facts["levels"])
    worst = max(facts["levels"], key=lambda level: level["worst_release_us"])
    pace = "in real time" if facts["speed"] == 1.0 else f"at {facts['speed']:g} times real time"
    rows = [
        ("run", f"{facts['duration_s']:.1f} s {pace}; {facts['activations']:,} activations"),
        ("lost", f"{facts['lost_samples']} samples; missed because the machine was busy: {missed}"),
        ("load", f"{100 * load:.1f} % of one processor, {len(facts['levels'])} levels"),
    ]
    if worst["worst_release_us"] > 0:
        late = f"{worst['worst_release_us']:.0f} us, on level {worst['level']}"
        rows.append(("release", f"greatest delay {late}"))
    rows += [
        (
            "note",
            f"no permission for {row['what']} ({row['why']}): {row['cost']}; hint: {row['remedy']}",
        )
        for row in facts["not_allowed"]
    ]
    return rows
