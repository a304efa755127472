"""Arguments that simulated, emulated and real-time flights share."""

from __future__ import annotations

import argparse
import contextlib
import math
import signal
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.arguments import add_verbose_argument, path
from stator.diagnostics import UserError, shown_path
from stator.flight.faults import Fault, read_faults, unseen
from stator.flight.invariants import Setting
from stator.flight.log import MODES
from stator.flight.params import param_options, read_params, with_params
from stator.mission.fence import Fence
from stator.mission.read import read_mission
from stator.mission.route import origin_of, seconds_of, walk
from stator.mission.store import write
from stator.mission.vehicle import vehicle_of
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stator.flight.params import Replaced
    from stator.graph.model import Graph
    from stator.graph.vehicle import Vehicle
    from stator.mission.model import Mission
    from stator.plan.plan import Plan

MAX_SEED = 2**64 - 1
MAX_DURATION_S = 1e6
MAX_SPEED = 1e4
USUAL_DURATION_S = 120.0
USUAL_SEED = 1
ENDLESS_S = 600.0  # of a mission that has no end
MAX_WIND_M_S = 50.0
MAX_DEGREES = 360.0
BESIDE = (".truth", ".json", ".png", ".records")  # of files that lie beside a log


def add_flight_arguments(parser: argparse.ArgumentParser, board: str, what: str) -> None:
    """Adds the arguments that all flights share."""
    parser.add_argument(
        "graph",
        nargs="?",
        type=Path,
        help="graph file (default: graph/quad.yaml, for a mission graph/quad_outdoor.yaml)",
    )
    parser.add_argument("--board", default=board, help=f"{what} (default: {board})")
    parser.add_argument(
        "--duration",
        type=duration_of,
        help="longest flight in seconds (default: 120, or more for a mission)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=log_path,
        metavar="LOG",
        help="log file; overwritten if it exists (default: in build/flights, where "
        "earlier logs are kept with a number)",
    )
    parser.add_argument(
        "--no-record",
        action="store_true",
        help="write no recording for ./stator replay: the log is smaller, and the flight faster; "
        "built apart",
    )
    add_verbose_argument(parser)
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    parser.add_argument(
        "--mission",
        type=path,
        metavar="FILE",
        help="mission to fly: YAML, or a ground station's .plan or waypoints (docs/missions.md)",
    )
    world = add_world_arguments(parser)
    world.add_argument(
        "--pilot",
        type=path,
        metavar="FILE",
        help="script of the pilot's sticks and switches (docs/simulation.md)",
    )


def add_times_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--times",
        choices=["zero", "budget", "random"],
        default="zero",
        help="execution times of activations; with budget or random, tasks preempt others "
        "(default: zero)",
    )


def add_world_arguments(parser: argparse.ArgumentParser) -> argparse._ArgumentGroup:
    world = parser.add_argument_group("the simulated world")
    world.add_argument(
        "--seed",
        type=seed_of,
        default=USUAL_SEED,
        help="seed of the start position, the sensors and their noise (default: 1)",
    )
    world.add_argument(
        "--vary",
        action="store_true",
        help="vary mass, inertia, thrust, centre of gravity, delay and biases with the seed",
    )
    world.add_argument(
        "--wind", type=wind_of, default=0.0, metavar="M_S", help="mean wind in m/s (default: 0)"
    )
    world.add_argument(
        "--wind-from",
        type=degrees_of,
        default=0.0,
        metavar="DEG",
        help="direction that the wind comes from: 0 is north, 90 is east (default: 0)",
    )
    world.add_argument(
        "--gusts",
        choices=["none", "light", "moderate", "severe"],
        default="none",
        help="gusts as in MIL-F-8785C (default: none)",
    )
    world.add_argument(
        "--launch",
        choices=["ground", "catapult", "hand"],
        default="ground",
        help="how a vehicle with a wing starts: on a runway into the wind, from a catapult or from "
        "a hand, 1 s after it is armed (default: ground)",
    )
    world.add_argument(
        "--fail",
        action="append",
        default=[],
        metavar="PART.FAULT[=VALUE]@S[+S]",
        help="a failure of a part of the graph, its start in seconds and its duration, such as "
        "baro0.stuck@20+5; or random=N: N failures from the seed. Use it once for each failure; "
        "an unknown one lists what the graph has (docs/simulation.md)",
    )
    return world


def complete(arguments: argparse.Namespace) -> Mission | None:
    """Fills in the defaults of the graph and the duration, and reads the mission. Raises
    `UserError` or `Failed`."""
    wanted = arguments.mission
    arguments.is_limited = arguments.duration is not None
    if arguments.graph is None:
        name = "quad.yaml" if wanted is None else "quad_outdoor.yaml"
        arguments.graph = HOME / "graph" / name
    if wanted is None:
        arguments.duration = arguments.duration or USUAL_DURATION_S
        return None
    plan = plan_of(arguments)
    if not any(node.interface.name == "mission" for node in plan.graph.nodes.values()):
        raise UserError(
            f"error: missing node of app 'mission' in {shown_path(arguments.graph)}\n"
            "hint: omit GRAPH, or include quad_outdoor.yaml in your graph"
        )
    vehicle = vehicle_of(flown_graph(arguments, plan))
    mission = read_mission(wanted, vehicle)
    if arguments.duration is None:
        seconds = seconds_of(mission, vehicle)
        more = ENDLESS_S if walk(mission, vehicle).is_endless else 0.0
        arguments.duration = max(USUAL_DURATION_S, 60.0 + 2.0 * seconds + more)
    return mission


def cut_of(arguments: argparse.Namespace, heard: signal.Signals | None = None) -> str:
    """Why a flight ends early: at its time limit, or by the signal that was heard."""
    if heard is not None:
        return f"{heard.name} ended the flight early"
    limit = f"--duration {arguments.duration:g} s"
    if not arguments.is_limited:
        limit = f"the limit of {arguments.duration:g} s, as --duration was not given,"
    return f"{limit} ended the flight early"


@contextlib.contextmanager
def memory_of(mission: Mission | None, *, is_guided: bool = False) -> Iterator[Path | None]:
    """The file that is the memory of the mission device during a flight. `is_guided`: others may
    put a mission there."""
    if mission is None and not is_guided:
        yield None
        return
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "mission"
        write(mission, file)
        yield file


@contextlib.contextmanager
def vehicle_options(vehicle: Vehicle) -> Iterator[list[str]]:
    """Options of a program of the simulated world that is built without the graph."""
    from stator.emit.vehicles import world_lines

    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "vehicle"
        file.write_text("\n".join([*world_lines(vehicle), ""]), encoding="utf-8")
        yield ["--vehicle", str(file)]


def plan_of(arguments: argparse.Namespace) -> Plan:
    """The plan for the chosen board, made once. Raises `Failed`."""
    if getattr(arguments, "plan", None) is None:
        arguments.plan = make_plan(str(arguments.graph), arguments.board)
    plan: Plan = arguments.plan
    return plan


def place_options(mission: Mission | None) -> list[str]:
    """Options of the flight program: where on Earth the simulated world lies."""
    origin = None if mission is None else origin_of(mission)
    if mission is None or origin is None:
        return []
    places = [f"{origin[0]:.9f}", f"{origin[1]:.9f}"]
    if mission.home is not None and mission.home.altitude is not None:
        places.append(f"{mission.home.altitude:.3f}")
    return ["--origin", ",".join(places)]


def log_path(text: str) -> Path:
    """Beside the log lie files of its name with other ends."""
    log = path(text)
    if log.suffix in BESIDE:
        raise argparse.ArgumentTypeError(
            f"a log cannot end in {log.suffix}: that file lies beside it; for example flight.ulg"
        )
    return log


def flight_options(arguments: argparse.Namespace) -> list[str]:
    """Options of the flight program: everything that determines a flight, except the graph."""
    options = ["--seed", str(arguments.seed), "--duration", f"{arguments.duration:.6f}"]
    options += ["--wind", f"{arguments.wind:.6f}", "--wind-from", f"{arguments.wind_from:.6f}"]
    options += ["--gusts", arguments.gusts, "--vary", "yes" if arguments.vary else "no"]
    options += ["--launch", arguments.launch] if arguments.launch != "ground" else []
    options += [
        word
        for fault in faults_of(arguments)
        for text in fault.options()
        for word in ("--fail", text)
    ]
    options += param_options(params_of(arguments))
    if arguments.pilot is not None:
        options += ["--pilot", str(arguments.pilot.resolve())]
    return options


def words_of(arguments: argparse.Namespace) -> list[str]:
    """The words of the command line that make this flight what it is, behind the graph."""
    words = [] if arguments.board == "sitl" else ["--board", arguments.board]
    words += ["--mission", shown_path(arguments.mission)] if arguments.mission else []
    words += ["--duration", f"{arguments.duration:g}"] if arguments.is_limited else []
    words += ["--seed", str(arguments.seed)] if arguments.seed != USUAL_SEED else []
    words += ["--vary"] if arguments.vary else []
    words += ["--wind", f"{arguments.wind:g}"] if arguments.wind else []
    words += ["--wind-from", f"{arguments.wind_from:g}"] if arguments.wind_from else []
    words += ["--gusts", arguments.gusts] if arguments.gusts != "none" else []
    words += ["--launch", arguments.launch] if arguments.launch != "ground" else []
    words += [word for text in arguments.fail for word in ("--fail", text)]
    words += ["--hil", arguments.hil] if getattr(arguments, "hil", None) else []
    words += ["--pilot", shown_path(arguments.pilot)] if arguments.pilot else []
    words += [word for text in arguments.param for word in ("--param", text)]
    words += ["--times", arguments.times] if arguments.times != "zero" else []
    return words


def params_of(arguments: argparse.Namespace) -> list[Replaced]:
    """Raises `UserError` for one that the graph does not have, or a value that it cannot have."""
    texts = getattr(arguments, "param", [])  # an image has its parameters built in
    if not texts:
        return []
    return read_params(plan_of(arguments).graph, texts)


def flown_graph(arguments: argparse.Namespace, plan: Plan) -> Graph:
    """The graph with the parameters of this flight."""
    return with_params(plan.graph, params_of(arguments))


def faults_of(arguments: argparse.Namespace) -> list[Fault]:
    """Raises `UserError` for one that the graph does not have."""
    if not arguments.fail:
        return []
    plan = plan_of(arguments)
    faults = read_faults(plan, arguments.fail, arguments.seed, 0.4 * arguments.duration)
    stuck = next((fault for fault in faults if fault.is_of_node), None)
    if stuck is not None and plan.board.executor != "virtual":
        raise UserError(
            f"error: --fail {stuck}: expected a device, found a node: nodes get stuck in virtual "
            f"time only\nhint: ./stator fly --fail {stuck}"
        )
    return faults


def failures_of(faults: list[Fault]) -> dict[str, object]:
    """Their facts."""
    return {"failures": [str(fault) for fault in faults], "unseen_failures": unseen(faults)}


def is_windy(arguments: argparse.Namespace) -> bool:
    return bool(arguments.wind > 0.0 or arguments.gusts != "none")


def rates_of(arguments: argparse.Namespace) -> dict[str, object]:
    """The data rate of the recording, and the rate that the graph's own board can store."""
    from stator.emit.recording import bytes_per_second, storage_bytes_per_second

    plan = make_plan(str(arguments.graph), None)
    if arguments.no_record or not has_logger(plan):
        return {}
    return {
        "recording_bytes_per_s": bytes_per_second(plan, usual=True),
        "storage_bytes_per_s": storage_bytes_per_second(plan),
        "storage_board": plan.graph.board.name,
    }


def speed_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0.0 < float(text) <= MAX_SPEED:
            return float(text)
    raise argparse.ArgumentTypeError(
        f"expected a factor above 0 and up to {MAX_SPEED:.0f}, found '{text}'"
    )


def times_of(arguments: argparse.Namespace) -> list[str]:
    """Options of the flight program: how long activations take. Raises `UserError`."""
    if arguments.times != "zero" and plan_of(arguments).graph.wires:
        raise UserError(
            f"error: --times {arguments.times}: expected a graph of one machine, found several: "
            "they would share one processor\nhint: remove --times"
        )
    if arguments.times != "budget":
        return ["--times", arguments.times]
    # Budgets of the graph's own board: a simulated board has no times.
    plan = make_plan(str(arguments.graph), None)
    budgets = {name: node.budget_us for name, node in plan.graph.nodes.items()}
    missing = [name for name, budget in budgets.items() if budget is None]
    if missing:
        shown = ", ".join(f"'{name}'" for name in missing)
        raise UserError(
            f"error: missing budget of {shown}: --times budget needs one for each node\n"
            f"hint: add `budget: 50 us` to the node, or `{missing[0]}: 50 us` to "
            f"budgets/{plan.board.name}.yaml beside the graph"
        )
    return ["--budgets", ",".join(f"{name}={budget}" for name, budget in budgets.items())]


def recording_of(arguments: argparse.Namespace) -> dict[str, str]:
    """The CMake variables of a recorded flight. Raises `UserError` if its logger is too slow."""
    from stator.build.image import recording_of as variant_of

    return variant_of(plan_of(arguments)) if is_recorded(arguments) else {}


def is_recorded(arguments: argparse.Namespace) -> bool:
    return not arguments.no_record and has_logger(plan_of(arguments))


def has_logger(plan: Plan) -> bool:
    from stator.emit.recording import is_recordable

    return is_recordable(plan)


def is_judged(arguments: argparse.Namespace) -> bool:
    """Whether there is a flight to judge: a vehicle with motors, and a log."""
    plan = plan_of(arguments)
    nodes = plan.graph.nodes.values()
    has_motors = any(node.device == "motors" or node.interface.name == "can_esc" for node in nodes)
    return has_motors and has_logger(plan)


def setting_of(arguments: argparse.Namespace, mission: Mission | None = None) -> Setting:
    """What the flight is flown with, for its invariants."""
    plan = plan_of(arguments)
    faults = faults_of(arguments)
    unseen_s = min((f.from_s for f in faults if f.is_unseen), default=math.inf)
    adrift_s = min((f.from_s for f in faults if f.takes_steering_away), default=math.inf)
    commander = next((n for n in plan.graph.nodes.values() if n.interface.failsafe), None)
    if commander is None:
        return Setting(unseen_s=unseen_s, cannot_steer_s=adrift_s)
    table = commander.interface.failsafe
    assert table is not None
    vehicle = vehicle_of(flown_graph(arguments, plan))
    radius, height, origin = vehicle.fence_radius, vehicle.fence_height, None
    if mission is not None:
        origin = origin_of(mission)
        fence = Fence(mission.areas, origin)
        radius = fence.home_radius if fence.includes else radius
        height = mission.ceiling or height
    return Setting(
        needs={MODES[mode]: needs for mode, needs in table.needs.items()},
        fence_radius=radius,
        fence_height=height,
        origin=origin,
        unseen_s=unseen_s,
        cannot_steer_s=adrift_s,
    )


def seed_of(text: str) -> int:
    if text.isascii() and text.isdigit() and int(text) <= MAX_SEED:
        return int(text)
    raise argparse.ArgumentTypeError(
        f"expected a whole number from 0 to {MAX_SEED}, found '{text}'"
    )


def wind_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0.0 <= float(text) <= MAX_WIND_M_S:
            return float(text)
    raise argparse.ArgumentTypeError(f"expected m/s from 0 to {MAX_WIND_M_S:.0f}, found '{text}'")


def degrees_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if abs(float(text)) <= MAX_DEGREES:
            return float(text)
    raise argparse.ArgumentTypeError(f"expected degrees from -360 to 360, found '{text}'")


def duration_of(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0.0 < float(text) <= MAX_DURATION_S:
            return float(text)
    most = f"{MAX_DURATION_S:.0f}"
    raise argparse.ArgumentTypeError(f"expected seconds above 0 and up to {most}, found '{text}'")
