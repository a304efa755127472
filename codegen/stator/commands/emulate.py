"""`./stator emulate`: flies the firmware in QEMU, in lockstep with the plant."""

from __future__ import annotations

import contextlib
import hashlib
import json
import signal
from typing import TYPE_CHECKING

from stator.arguments import path
from stator.build.cmake import SLEEP, build_pixhawk, build_plant
from stator.build.image import add_record_argument, build_image, flashed_file
from stator.build.px4_file import padded
from stator.diagnostics import ANSWER_IS_NO, SIGNALLED, UserError
from stator.emulator import chip
from stator.emulator.figures import FIGURES, figures_of, figures_text, printed_rows
from stator.emulator.machine import chip_emulator
from stator.emulator.qemu import TICK_HZ, find_emulator, fly
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
    place_options,
    rates_of,
    recording_of,
    setting_of,
    speed_of,
    vehicle_options,
)
from stator.flight.facts import alone, facts_of, keep, mission_facts
from stator.flight.kept import keeping, kept_facts, log_of
from stator.flight.mavlink import (
    add_mavlink_argument,
    check_mavlink,
    complete_mavlink,
    mavlink_options,
    serial_lines,
    tell_mavlink,
)
from stator.flight.nonvolatile import add_nonvolatile_argument, nonvolatile_of, opened
from stator.flight.progress import progress
from stator.flight.report import report
from stator.flight.restarts import Endings
from stator.live.fault_record import in_words
from stator.live.place import DEFAULT as LINK
from stator.live.place import socket_place, with_graph
from stator.pipeline import make_plan

if TYPE_CHECKING:
    import argparse

    from stator.plan.plan import Plan


def add_arguments(parser: argparse.ArgumentParser) -> None:
    what = "a board that the emulator supports: qemu_f405 or fmu_v2, the Pixhawk"
    add_flight_arguments(parser, board="qemu_f405", what=what)
    add_record_argument(parser)
    parser.add_argument(
        "--sleep",
        action="store_true",
        help="sleep when idle, as on hardware; two flights can then differ (docs/emulation.md)",
    )
    parser.add_argument(
        "--link",
        nargs="?",
        type=path,
        const=LINK,
        metavar="PATH",
        help="serve the firmware's serial port as a socket for ./stator top, listener and perf; "
        "two flights can then differ",
    )
    parser.add_argument(
        "--speed",
        type=speed_of,
        metavar="FACTOR",
        help="highest speed, as a multiple of real time (default: no limit; with --mavlink 1)",
    )
    parser.add_argument(
        "--figures",
        action="store_true",
        help="report the longest execution and response of each task",
    )
    add_nonvolatile_argument(parser, "none: they are gone at the end")
    add_mavlink_argument(parser)


def main(arguments: argparse.Namespace) -> int:
    """0 if the flight was successful; 1 if it failed or could not be judged."""
    complete_mavlink(arguments)
    mission = complete(arguments)
    check_mavlink(arguments)
    log = log_of(arguments, [], ".emulated")
    truth = log.with_name(f"{log.name.removesuffix('.ulg')}.truth")
    faults = faults_of(arguments)
    is_pixhawk = arguments.board == chip.BOARD
    if is_pixhawk:
        chip.refuse_unsupported(arguments, made_plan(arguments))
        arguments.no_record = arguments.no_record or not arguments.record
    emulator = chip_emulator() if is_pixhawk else find_emulator()
    variant = (SLEEP if arguments.sleep else {}) | recording_of(arguments)
    image = build_image(arguments.graph, arguments.board, variant)
    plant = build_pixhawk() if is_pixhawk else build_plant()
    link = None if arguments.link is None else socket_place(arguments.link)
    options = ["--truth", str(truth.resolve()), *flight_options(arguments), *place_options(mission)]
    options += mavlink_options(arguments)
    if arguments.speed is not None:
        options += ["--speed", f"{arguments.speed:.6f}"]
    name = f"emulating {arguments.graph.stem}, seed {arguments.seed}"
    tell_mavlink(arguments)
    is_guided = bool(arguments.mavlink)
    kept_records = nonvolatile_of(arguments, log) if arguments.nonvolatile else None
    with (
        serial_lines(arguments),
        with_graph(link, arguments.graph),
        keeping(log, arguments) as kept,
        alone(log),
        progress(name, truth, arguments.duration),
        memory_of(mission, is_guided=is_guided) as memory,
        vehicle_options(made_plan(arguments).graph.vehicle) as vehicle,
        opened(kept_records) if kept_records else contextlib.nullcontext() as records,
        Endings() as endings,
    ):
        around = [str(plant), *options, *vehicle]
        if is_pixhawk:
            around += ["--log", str(log), *chip.counter_options(made_plan(arguments), image)]
            code = padded(flashed_file(image).read_bytes())
            finished = chip.fly_image(emulator, around, code, endings)
        else:
            finished = fly(
                emulator,
                image,
                around,
                log,
                argument=FIGURES if arguments.figures else "",
                link=link,
                mission=memory,
                records=records,
                lines=len(arguments.mavlink),
                endings=endings,
            )
        heard = signal.Signals(endings.heard) if endings.heard else None
        if heard and finished.returncode != 0:  # it was asked twice
            raise KeyboardInterrupt
        if finished.returncode != 0:
            raise UserError(in_words(finished.stderr, made_plan(arguments), image).rstrip())
        facts = facts_of(
            finished,
            log,
            truth,
            mission,
            cut=cut_of(arguments, heard),
            judges=is_judged(arguments),
            is_guided=is_guided,
            is_recorded=is_recorded(arguments),
            in_wind=is_windy(arguments),
            setting=setting_of(arguments, mission),
        )
    if heard and not is_guided and facts["success"]:  # nothing was judged
        facts |= {"success": False, "reason": cut_of(arguments, heard)}
    facts |= kept_facts(kept) | mission_facts(arguments, mission)
    facts |= failures_of(faults) | rates_of(arguments)
    facts |= {"graph": arguments.graph.stem, "board": arguments.board, "seed": arguments.seed}
    facts["graph_file"] = str(arguments.graph.resolve())
    facts["emulator"] = emulator.version
    run = json.loads(finished.stdout)
    facts["missed_samples"] = run["missed_samples"]
    if is_pixhawk:
        flashed = flashed_file(image)
        facts["image"] = str(flashed)
        facts["image_sha256"] = hashlib.sha256(flashed.read_bytes()).hexdigest()
    figures = []
    if arguments.figures:
        rows = run["tasks"] if is_pixhawk else printed_rows(finished.stderr)
        tick_hz = chip.CLOCK_HZ if is_pixhawk else TICK_HZ
        figures = facts["figures"] = figures_of(rows, made_plan(arguments), tick_hz)
    keep(facts)
    if arguments.json:
        print(json.dumps(facts, indent=2))
    else:
        report(facts)
        if figures:
            print(figures_text(figures), end="")
    if heard and not is_guided:  # that is how a flight with a ground station ends
        return SIGNALLED + heard
    return 0 if facts["success"] else ANSWER_IS_NO


def made_plan(arguments: argparse.Namespace) -> Plan:
    return make_plan(str(arguments.graph), arguments.board)
