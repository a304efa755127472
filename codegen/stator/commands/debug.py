"""`./stator debug`: flies a graph in simulation under a debugger, stopped where a node steps."""

from __future__ import annotations

import argparse
import contextlib
import json
import shlex
import shutil
import signal
import subprocess
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from stator import HOME
from stator.build.cmake import DEBUG, PREEMPTION, build
from stator.diagnostics import UserError, nearest, shown_argument, shown_path
from stator.emit import devices
from stator.flight.arguments import (
    add_flight_arguments,
    add_times_argument,
    complete,
    flight_options,
    memory_of,
    params_of,
    place_options,
    times_of,
)
from stator.flight.kept import flights_of, log_of
from stator.flight.params import add_param_argument
from stator.pipeline import make_plan
from stator.processes import environment

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stator.graph.model import Node
    from stator.mission.model import Mission
    from stator.plan.plan import Plan


class Stop(NamedTuple):
    """Where the debugger stops: `condition` is empty, or an expression of gdb's."""

    function: str
    condition: str

    def in_gdb(self) -> str:
        return f"break {self.function}" + (f" if {self.condition}" if self.condition else "")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_flight_arguments(parser, board="sitl", what="a board with a simulated world")
    add_param_argument(parser)
    add_times_argument(parser)
    parser.add_argument(
        "--node", help="stop where this node steps (default: the node that crashed last time)"
    )
    parser.add_argument(
        "--at",
        type=float,
        metavar="SECONDS",
        help="not before this time of the flight (default: the time of that crash)",
    )
    parser.add_argument(
        "--print",
        action="store_true",
        dest="only_print",
        help="print the program with its arguments, for any debugger, and where to stop",
    )


def main(arguments: argparse.Namespace) -> int:
    mission = complete(arguments)
    plan = make_plan(str(arguments.graph), arguments.board)
    flown = log_of(arguments, params_of(arguments))
    node, at_s = _place(arguments, plan, _crash(flown))
    stop = _stop(plan, node, at_s)
    gdb = shutil.which("gdb")
    if gdb is None and not arguments.only_print:
        raise UserError(
            "error: missing program 'gdb'\n"
            "hint: install it with ./stator setup, or add --print for another debugger"
        )
    variant = DEBUG if arguments.times == "zero" else DEBUG | PREEMPTION
    program = build(arguments.graph, arguments.board, variant, executor="virtual")
    log = flown.with_name(f"{flown.name.removesuffix('.ulg')}.debug.ulg")
    with _command(program, log, arguments, mission) as command:
        if gdb is None or arguments.only_print:
            print(shlex.join(command))
            condition = f", if {stop.condition}" if stop.condition else ""
            print(f"break at: {stop.function}{condition}")
            return 0
        print(
            f"gdb: {stop.in_gdb()}; `next` and `step` go on, `print ports.now`, `quit`", flush=True
        )
        return _run([gdb, *_setup(stop), "--args", *command])


def _setup(stop: Stop) -> list[str]:
    words = ["-q", "-iex", "set debuginfod enabled off", "-iex", "set confirm off"]
    for line in (
        f"source {HOME / 'runtime' / 'host' / 'gdb_printers.py'}",
        "handle SIGVTALRM nostop noprint pass",  # runtime/host: looks for endless steps
        stop.in_gdb(),
        "run",
    ):
        words += ["-ex", line]
    return words


def _run(command: list[str]) -> int:
    """Ctrl-C is for the debugger."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        return subprocess.run(command, env=environment(), check=False).returncode
    finally:
        signal.signal(signal.SIGINT, before)


@contextlib.contextmanager
def _command(
    program: Path, log: Path, arguments: argparse.Namespace, mission: Mission | None
) -> Iterator[list[str]]:
    command = [str(program), "--log", str(log), *flight_options(arguments), *times_of(arguments)]
    with memory_of(mission) as memory:
        if memory is not None:
            if arguments.only_print:  # as the other one is removed
                memory = Path(shutil.copy(memory, log.with_suffix(".mission")))
            command += ["--mission", str(memory), *place_options(mission)]
        yield command


def _report(log: Path) -> dict[str, Any]:
    """The facts beside a log; empty if there are none."""
    try:
        facts = json.loads(log.with_name(f"{log.name.removesuffix('.ulg')}.json").read_text())
    except (OSError, ValueError):
        return {}
    return facts if isinstance(facts, dict) else {}


def _crash(log: Path) -> dict[str, Any]:
    """How the last flight of this log crashed; empty if it did not."""
    crash = _report(log).get("crash")
    return crash if isinstance(crash, dict) else {}


def _last_crash(graph: Path) -> str:
    """What to type for the last flight of this graph that crashed, with other options than these;
    empty if none is known."""
    for log in flights_of(graph):
        crash = _crash(log)
        if crash.get("node"):
            options = shlex.join(_report(log).get("options", []))
            command = f"./stator debug {shown_argument(graph)} {options}".rstrip()
            return f"'{crash['node']}' crashed in another flight: {command}"
    return ""


def _place(
    arguments: argparse.Namespace, plan: Plan, crash: dict[str, Any]
) -> tuple[Node, float | None]:
    name = arguments.node or crash.get("node")
    if name is None:
        raise UserError(
            "error: missing option --node: no crash of such a flight is known\n"
            f"hint: {_last_crash(arguments.graph) or nearest('', plan.graph.nodes)}"
        )
    node = plan.graph.nodes.get(name)
    if node is None:
        raise UserError(
            f"error: unknown node '{name}' in {shown_path(arguments.graph)}\n"
            f"hint: {nearest(name, plan.graph.nodes)}"
        )
    is_crash = arguments.at is None and name == crash.get("node")
    return node, crash.get("at_s") if is_crash else arguments.at


def _stop(plan: Plan, node: Node, at_s: float | None) -> Stop:
    same = [other for other in plan.graph.nodes.values() if other.interface is node.interface]
    name = f"apps::{node.interface.name}::{node.interface.class_name}"
    if node.device is not None:
        name = devices.class_name(plan.board.devices[node.device].driver)
    parts = [] if at_s is None else [f"stator::executor.now_us >= {round(at_s * 1e6)}"]
    if len(same) > 1:
        parts.append(f'$_streq(stator::running_node, "{node.name}")')
    return Stop(f"stator::{name}::step", " && ".join(parts))
