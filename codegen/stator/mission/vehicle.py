"""What a graph's vehicle allows and how fast it is, for a check of a mission before the flight."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stator.graph.model import Graph


@dataclass(frozen=True)
class Vehicle:
    """Parameters of the graph's navigator and trajectory. No limit: 0."""

    fence_radius: float = 0.0
    fence_height: float = 0.0
    farthest: float = 0.0
    return_height: float = 8.0
    landing_height: float = 3.0
    wait_limit: float = 30.0
    spool_up_time: float = 1.5
    speed: float = 5.0
    climb_rate: float = 2.0
    descent_rate: float = 1.5
    landing_rate: float = 0.5
    acceleration: float = 3.0
    eight_acceleration: float = 1.0


def vehicle_of(graph: Graph) -> Vehicle:
    known = {field.name for field in fields(Vehicle)}
    values = {}
    for node in graph.nodes.values():
        if node.interface.name in ("navigator", "trajectory"):
            for name in known & node.interface.params.keys():
                usual = node.interface.params[name].default
                values[name] = float(node.params.get(name, usual))
    return Vehicle(**values)
