"""`./stator simulate`: the simulated world as the simulator of another autopilot."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from stator import HOME
from stator.arguments import add_verbose_argument, path
from stator.build.cmake import build_hil_simulator
from stator.diagnostics import ANSWER_IS_NO, SIGNALLED, UserError, in_place, shown_path
from stator.flight.arguments import (
    add_world_arguments,
    duration_of,
    flight_options,
    is_windy,
    speed_of,
    vehicle_options,
)
from stator.flight.facts import NOT_WHOLE
from stator.flight.hil import USUAL_PLACE, listening_place_of
from stator.flight.judge import CALM, IN_WIND, lying
from stator.flight.log import read_truth
from stator.flight.progress import progress
from stator.flight.restarts import Endings
from stator.graph.vehicle import check_vehicle


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--hil",
        type=listening_place_of,
        default=USUAL_PLACE,
        metavar="tcp:PORT",
        help=f"where the autopilot connects to, on 127.0.0.1 (default: {USUAL_PLACE})",
    )
    parser.add_argument(
        "--duration",
        type=duration_of,
        default=600.0,
        help="longest flight in seconds (default: 600)",
    )
    parser.add_argument(
        "--speed",
        type=speed_of,
        metavar="FACTOR",
        help="highest speed, as a multiple of real time (default: no limit; without lockstep 1)",
    )
    parser.add_argument(
        "--truth",
        type=path,
        metavar="FILE",
        help="file for the true flight (default: in build/flights)",
    )
    parser.add_argument(
        "--vehicle", type=path, metavar="FILE", help="vehicle to simulate (default: the Iris)"
    )
    parser.add_argument("--json", action="store_true", help="print the result as JSON")
    add_verbose_argument(parser)
    add_world_arguments(parser)


def main(arguments: argparse.Namespace) -> int:
    """0 if the vehicle took off and landed within the limits of a flight; 1 if not."""
    # Its failures are those of the devices that the world feeds here.
    arguments.graph, arguments.board = HOME / "graph" / "quad_outdoor.yaml", "sitl"
    arguments.pilot = None
    vehicle = check_vehicle(arguments.vehicle or HOME / "graph" / "vehicles" / "iris.yaml")
    program = build_hil_simulator()
    truth = arguments.truth or _usual_truth(arguments.seed)
    command = [str(program), "--hil", arguments.hil, "--truth", str(truth)]
    command += flight_options(arguments)
    if arguments.speed is not None:
        command += ["--speed", f"{arguments.speed:.6f}"]
    name = f"simulating at {arguments.hil}, seed {arguments.seed}"
    with (
        vehicle_options(vehicle) as options,
        progress(name, truth, arguments.duration),
        Endings() as endings,
    ):
        finished = endings.run([*command, *options])
    if finished.returncode > NOT_WHOLE or finished.returncode < 0:
        raise UserError(finished.stderr.rstrip())
    facts = _facts(json.loads(finished.stdout), truth, arguments)
    if finished.returncode == NOT_WHOLE:
        facts |= {"success": False, "reason": finished.stderr.strip().removeprefix("error: ")}
    if arguments.json:
        print(json.dumps(facts, indent=2))
    else:
        _report(facts)
    if endings.heard and not facts["success"]:
        return SIGNALLED + endings.heard
    return 0 if facts["success"] else ANSWER_IS_NO


def _usual_truth(seed: int) -> Path:
    folder = HOME / "build" / "flights"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"simulate-seed{seed}.truth"


def _facts(run: dict[str, Any], truth: Path, arguments: argparse.Namespace) -> dict[str, Any]:
    limits = IN_WIND if is_windy(arguments) else CALM
    problems = _problems(run, truth, limits.touchdown_m_s)
    return {
        "success": not problems,
        "reason": "; ".join(problems) or "took off and landed, within all limits",
        "truth": str(truth.resolve()),
        "seed": arguments.seed,
        "duration_s": run["simulated_s"],
        "speed_vs_real_time": run["simulated_s"] / run["wall_s"],
        "take_off_s": run.get("take_off_s"),
        "touchdown_s": run.get("touchdown_s"),
        "touchdown_m_s": run.get("touchdown_m_s"),
    }


def _problems(run: dict[str, Any], truth: Path, touchdown_m_s: float) -> list[str]:
    at = f"at {run['simulated_s']:.2f} s"
    if run["problem"]:
        return [f"{run['problem']}, {at}"]
    if run.get("take_off_s") is None:
        return [f"no take-off until the end {at}"]
    if run["ended"] != "motors_stopped":
        return [f"the flight ended {at} with the motors running"]
    end = read_truth(truth)
    problems = [] if end.on_ground[-1] else [f"the motors stopped in the air {at}"]
    problems += [lies] if (lies := lying(end)) else []
    if run.get("touchdown_m_s", 0.0) >= touchdown_m_s:
        problems.append(f"touchdown: {run['touchdown_m_s']:.2f} m/s (limit {touchdown_m_s:g} m/s)")
    return problems


def _report(facts: dict[str, Any]) -> None:
    print(f"simulate, seed {facts['seed']}: {'success' if facts['success'] else 'FAILED'}")
    rows = [("result" if facts["success"] else "reason", str(facts["reason"]))]
    if facts["take_off_s"] is not None:
        rows.append(("take-off", f"at {facts['take_off_s']:.2f} s"))
    if facts["touchdown_s"] is not None:
        rows.append(
            ("touchdown", f"at {facts['touchdown_s']:.2f} s, {facts['touchdown_m_s']:.2f} m/s")
        )
    speed = f"{facts['duration_s']:.1f} s at {facts['speed_vs_real_time']:.1f} times real time"
    rows += [("run", speed), ("truth", shown_path(Path(facts["truth"])))]
    for label, text in rows:
        print(f"  {label:<10}{in_place(text)}")
