"""`./stator check`: checks a graph or a vehicle, and shows its size or its errors."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

from stator.arguments import add_graph_arguments, add_verbose_argument
from stator.build.cmake import RECORDING, build
from stator.diagnostics import ANSWER_IS_NO, Failed, show_errors, shown_path
from stator.graph.vehicle import check_vehicle
from stator.machines.links import link_lines
from stator.pipeline import make_plan
from stator.plan.text import show_notes

if TYPE_CHECKING:
    import argparse


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument(
        "--code",
        action="store_true",
        help="compile the nodes for simulation as well, and check what they call and keep",
    )
    add_verbose_argument(parser)
    parser.add_argument("--plan", action="store_true", help="show the whole plan")
    parser.add_argument("--json", action="store_true", help="print the result as JSON")


def main(arguments: argparse.Namespace) -> int:
    try:
        if Path(arguments.graph).absolute().parent.name == "vehicles":
            return _check_vehicle(Path(arguments.graph), as_json=arguments.json)
        plan = make_plan(arguments.graph, arguments.board)
    except Failed as failed:
        if arguments.json:
            print(json.dumps({"errors": [error.as_json() for error in failed.errors]}, indent=2))
        else:
            show_errors(failed)
        return ANSWER_IS_NO
    if arguments.code:
        from stator.emit.recording import is_recordable

        # What `fly` builds, so that neither of them builds it twice.
        build(Path(arguments.graph), "sitl", RECORDING if is_recordable(plan) else {})
    if arguments.json:
        from stator.plan.hash import graph_hash

        print(
            json.dumps(
                {
                    "errors": [],
                    "graph": plan.graph.name,
                    "board": plan.board.name,
                    "vehicle": plan.graph.vehicle.name,
                    "nodes": len(plan.tasks),
                    "topics": len(plan.topics),
                    "hash": graph_hash(plan),
                },
                indent=2,
            )
        )
        return 0
    if arguments.plan:
        from stator.plan.text import plan_text

        print(plan_text(plan), end="")
        return 0
    levels = len({task.level for task in plan.tasks})
    slot_bytes = sum(t.message.bytes * t.slots for t in plan.topics.values())
    print(
        f"{shown_path(plan.graph.file)}: no errors: {_count(len(plan.tasks), 'node')} on "
        f"{_count(levels, 'level')}, {_count(len(plan.topics), 'topic')} in {slot_bytes} bytes of "
        f"slots, board {plan.board.name}"
    )
    for line in link_lines(plan.graph):
        print(line)
    show_notes(plan)
    return 0


def _check_vehicle(path: Path, *, as_json: bool) -> int:
    """Raises `Failed`."""
    vehicle = check_vehicle(path)
    count, ratio = len(vehicle.places), vehicle.thrust_over_weight
    if as_json:
        facts: dict[str, float] = {
            "mass_kg": vehicle.mass,
            "rotors": count,
            "thrust_over_weight": round(ratio, 4),
        }
        if vehicle.wing is not None:
            facts |= {
                "propellers": len(vehicle.propellers),
                "surfaces": len(vehicle.surfaces),
                "stall_airspeed_m_s": round(vehicle.stall_airspeed, 3),
            }
        print(json.dumps({"errors": [], "vehicle": vehicle.name} | facts, indent=2))
        return 0
    parts = [f"{vehicle.mass:g} kg"]
    if vehicle.rotors is not None:
        parts.append(_count(count, "rotor"))
    if vehicle.wing is not None:
        parts.append(_count(len(vehicle.propellers), "propeller"))
        parts.append(f"stall at {vehicle.stall_airspeed:.1f} m/s")
    parts.append(f"thrust {ratio:.2f} times the weight")
    print(f"{shown_path(path)}: no errors: {', '.join(parts)}")
    return 0


def _count(number: int, what: str) -> str:
    return f"{number} {what}" + ("" if number == 1 else "s")
