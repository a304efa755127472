"""What flights are asked with: arguments that simulated, emulated and real-time ones share."""

from __future__ import annotations

import argparse
import contextlib
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.arguments import path
from stator.build.cmake import RECORDING
from stator.diagnostics import UserError
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from stator.plan.plan import Plan

MAX_SEED = 2**64 - 1
MAX_DURATION_S = 1e6
MAX_SPEED = 1e4
USUAL_DURATION_S = 120.0
MAX_WIND_M_S = 50.0
MAX_DEGREES = 360.0


def add_flight_arguments(parser: argparse.ArgumentParser, board: str, what: str) -> None:
    """What simulated and emulated flights have in common."""
    graph = HOME / "graph" / "quad.yaml"
    parser.add_argument(
        "graph", nargs="?", type=Path, default=graph, help="a graph file (default: graph/quad.yaml)"
    )
    parser.add_argument("--board", default=board, help=f"{what} (default: {board})")
    parser.add_argument(
        "--duration",
        type=duration_of,
        default=USUAL_DURATION_S,
        help="most seconds of flight (default: 120, or what a mission may need)",
    )
    parser.add_argument(
        "-o", "--output", type=path, metavar="LOG", help="the log (default: in build/flights)"
    )
    parser.add_argument(
        "--no-record",
        action="store_true",
        help="leave out of the log what ./stator replay needs: it is smaller, the flight faster",
    )
    parser.add_argument("--json", action="store_true", help="print what programs read")
    _add_world_arguments(parser)


def _add_world_arguments(parser: argparse.ArgumentParser) -> None:
    world = parser.add_argument_group("the simulated world")
    world.add_argument(
        "--seed",
        type=seed_of,
        default=1,
        help="of the start, the sensors and their noise (default: 1)",
    )
    world.add_argument(
        "--vary",
        action="store_true",
        help="another mass, inertia, thrust, centre of gravity, delay and biases for each seed",
    )
    world.add_argument(
        "--wind", type=wind_of, default=0.0, metavar="M_S", help="mean wind in m/s (default: 0)"
    )
    world.add_argument(
        "--wind-from",
        type=degrees_of,
        default=0.0,
        metavar="DEG",
        help="where the wind comes from, from north over east (default: 0)",
    )
    world.add_argument(
        "--gusts",
        choices=["none", "light", "moderate", "severe"],
        default="none",
        help="of MIL-F-8785C (default: none)",
    )
    world.add_argument(
        "--fail",
        action="append",
        default=[],
        metavar="WHAT@S[+S]",
        help="what fails, from when on, and for how long: gnss_loss, gnss_glitch[=METRES], "
        "baro_loss, mission_loss, rc_loss, battery_low[=0..1], motor_1 to motor_4[=0..1]; may be "
        "given several times",
    )
    world.add_argument(
        "--pilot",
        type=path,
        metavar="FILE",
        help="script of sticks and switches (docs/simulation.md)",
    )


def flight_options(arguments: argparse.Namespace) -> list[str]:
    """For the program that flies, what decides a flight besides the graph."""
    options = ["--seed", str(arguments.seed), "--duration", f"{arguments.duration:.6f}"]
    options += ["--wind", f"{arguments.wind:.6f}", "--wind-from", f"{arguments.wind_from:.6f}"]
    options += ["--gusts", arguments.gusts, "--vary", "yes" if arguments.vary else "no"]
    options += [word for fault in arguments.fail for word in ("--fail", fault)]
    if arguments.pilot is not None:
        options += ["--pilot", str(arguments.pilot.resolve())]
    return options


def is_windy(arguments: argparse.Namespace) -> bool:
    return bool(arguments.wind > 0.0 or arguments.gusts != "none")


def rates_of(arguments: argparse.Namespace) -> dict[str, object]:
    """What a recording takes as a rule at most, and what the graph's own board can store."""
    from stator.emit.recording import bytes_per_second, storage_bytes_per_second

    plan = make_plan(str(arguments.graph), None)
    if arguments.no_record or not has_logger(plan):
        return {}
    return {
        "recording_bytes_per_s": bytes_per_second(plan),
        "storage_bytes_per_s": storage_bytes_per_second(plan),
        "storage_board": plan.graph.board.name,
    }


def speed_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0.0 < float(text) <= MAX_SPEED:
            return float(text)
    raise argparse.ArgumentTypeError(f"'{text}' is no factor above 0, at most {MAX_SPEED:.0f}")


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
    return RECORDING if is_recorded(arguments) else {}


def is_recorded(arguments: argparse.Namespace) -> bool:
    return not arguments.no_record and has_logger(make_plan(str(arguments.graph), arguments.board))


def has_logger(plan: Plan) -> bool:
    from stator.emit.recording import is_recordable

    return is_recordable(plan)


def is_judged(arguments: argparse.Namespace) -> bool:
    """Whether something flies that the log tells of."""
    plan = make_plan(str(arguments.graph), arguments.board)
    nodes = plan.graph.nodes.values()
    has_motors = any(node.device == "motors" or node.interface.name == "can_esc" for node in nodes)
    return has_motors and has_logger(plan)


def seed_of(text: str) -> int:
    if text.isascii() and text.isdigit() and int(text) <= MAX_SEED:
        return int(text)
    raise argparse.ArgumentTypeError(f"'{text}' is no whole number from 0 to {MAX_SEED}")


def wind_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0.0 <= float(text) <= MAX_WIND_M_S:
            return float(text)
    raise argparse.ArgumentTypeError(f"'{text}' is no number of m/s from 0 to {MAX_WIND_M_S:.0f}")


def degrees_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if abs(float(text)) <= MAX_DEGREES:
            return float(text)
    raise argparse.ArgumentTypeError(f"'{text}' is no number of degrees from -360 to 360")


def duration_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0.0 < float(text) <= MAX_DURATION_S:
            return float(text)
    most = f"{MAX_DURATION_S:.0f}"
    raise argparse.ArgumentTypeError(f"'{text}' is no number of seconds above 0, at most {most}")
