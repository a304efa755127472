"""A flight whose world is another simulator's, by HIL messages: docs/hil.md."""

from __future__ import annotations

import argparse
import re
import sys
from typing import TYPE_CHECKING, Any

from stator import HOME
from stator.diagnostics import UserError, shown_path
from stator.flight.facts import RESTART
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from collections.abc import Mapping

FORMS = "tcp:PORT or tcp:HOST:PORT"
USUAL_PLACE = "tcp:4560"
_PLACE = re.compile(r"tcp:(?:(?:\d+\.\d+\.\d+\.\d+|localhost):)?(\d+)")
_MAX_PORT = 65535
# What the world of `fly` decides, and a simulator beside it decides for itself.
_OWN_WORLD = {
    **{"seed": 1, "vary": False, "wind": 0.0, "wind_from": 0.0, "gusts": "none"},
    **{"launch": "ground", "fail": []},
}
_UNFED = ("mocap", "can")  # classes of devices that no message feeds


def add_hil_argument(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--hil",
        type=place_of,
        metavar="PLACE",
        help="fly in another simulator, such as jMAVSim or Gazebo: connect to it at tcp:PORT or "
        "tcp:HOST:PORT (usually tcp:4560), get sensors by HIL_SENSOR and HIL_GPS, and answer in "
        "lockstep with HIL_ACTUATOR_CONTROLS (docs/hil.md)",
    )


def place_of(text: str) -> str:
    found = _PLACE.fullmatch(text)
    if found and 0 < int(found[1]) <= _MAX_PORT:
        return text
    raise argparse.ArgumentTypeError(f"expected {FORMS}, found '{text}'")


def listening_place_of(text: str) -> str:
    if re.fullmatch(r"tcp:\d+", text) and place_of(text):
        return text
    raise argparse.ArgumentTypeError(f"expected tcp:PORT, found '{text}'")


def complete_hil(arguments: argparse.Namespace) -> None:
    """Raises `UserError` for options of a world that is not there."""
    if arguments.hil is None:
        return
    arguments.graph = arguments.graph or HOME / "graph" / "quad_outdoor.yaml"
    given = [name for name, usual in _OWN_WORLD.items() if getattr(arguments, name) != usual]
    given += ["speed"] if arguments.speed is not None else []
    if given:
        option = "--" + given[0].replace("_", "-")
        raise UserError(
            f"error: {option}: not with --hil, as the other simulator decides it\n"
            f"hint: omit {option}, and set it there"
        )


def check_hil(arguments: argparse.Namespace) -> None:
    """Before the flight. Raises `UserError` if no simulator can feed the graph."""
    if arguments.hil is None:
        return
    arguments.speed = None  # the simulator's
    plan = make_plan(str(arguments.graph), arguments.board)
    if plan.graph.wires:
        raise UserError(
            "error: --hil: expected a graph of one machine, found several\n"
            "hint: use graph/quad_outdoor.yaml"
        )
    for device in (node.device for node in plan.graph.nodes.values() if node.device):
        interface = plan.board.devices[device].interface
        if interface is not None and interface.name in _UNFED:
            raise UserError(
                f"error: --hil: no HIL message feeds the device '{device}' of "
                f"{shown_path(arguments.graph)}\nhint: use graph/quad_outdoor.yaml"
            )
    if not arguments.json:
        print(f"note: flies in the simulator at {arguments.hil}", file=sys.stderr)


def hil_options(arguments: argparse.Namespace) -> list[str]:
    """Options of the flight program."""
    return [] if arguments.hil is None else ["--hil", arguments.hil]


def hil_facts(run: Mapping[str, Any], cut: str, *, is_guided: bool) -> dict[str, object]:
    """The verdict. Only the simulator knows how the flight really was, so this is about its end."""
    at_s = f"at {run['simulated_s']:.2f} s"
    if run["problem"]:
        # That is how a flight ends that others fly.
        is_good = is_guided and run["motors_are_stopped"] and "closed" in run["problem"]
        state = "stopped" if run["motors_are_stopped"] else "running"
        return {"success": is_good, "reason": f"{run['problem']}, with the motors {state}"}
    if run["ended"] == "restart":
        return {"success": is_guided, "reason": f"ended by {RESTART} {at_s}"}
    if run["ended"] == "motors_stopped":
        return {"success": True, "reason": f"flown, and the motors stopped {at_s}"}
    if is_guided:
        return {"success": True, "reason": "ran to its end"}
    state = "running" if run["motors_have_run"] else "never started"
    return {"success": False, "reason": f"{cut}; motors {state} {at_s}"}
