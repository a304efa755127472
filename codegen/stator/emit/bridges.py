"""Rows of the nodes between machines, and of the links for the board's code."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.machines.links import body_bytes
from stator.plan.hash import graph_hash

if TYPE_CHECKING:
    from stator.graph.model import Interface, Node
    from stator.plan.plan import Plan

HASH_DIGITS = 16
LEAST_BYTES = 8  # of a message: its timestamp
STATUS_TICKS = 10  # periods of the link between two statuses


@dataclass(frozen=True)
class BridgeTopicRow:
    port: str
    message: str
    bytes: int  # without the padding at the end
    max_age_us: int


@dataclass(frozen=True)
class BridgeRow:
    kind: str
    file: str
    name: str
    class_name: str
    doc: str
    ports_header: str
    ports: str
    topics: list[BridgeTopicRow]
    most_bytes: int
    graph_hash: str
    cut_hash: str
    status_ticks: int
    has_status: bool  # a selector: the graph says whether the vehicle is armed


@dataclass(frozen=True)
class LinkRow:
    name: str
    near: str
    far: str
    baud: int
    wake_up_us: int


@dataclass(frozen=True)
class MachineRow:
    name: str
    tasks: list[str]
    ends: list[str]


@dataclass(frozen=True)
class LinksRow:
    links: list[LinkRow]
    machines: list[MachineRow]  # that can be started again


def header(interface: Interface) -> str:
    return f"bridges/{interface.name}"


def class_name(interface: Interface) -> str:
    return f"bridges::{interface.class_name}"


def is_restarted(plan: Plan, node: Node) -> bool:
    """In virtual time every machine but the first can be killed and started again."""
    first = next(iter(plan.graph.machines), "")
    return bool(plan.graph.wires) and node.machine != first and plan.board.executor == "virtual"


def bridge(plan: Plan, node: Node) -> BridgeRow:
    interface = node.interface
    made = interface.bridge
    assert made is not None
    topics = [
        BridgeTopicRow(topic.port, topic.message.name, body_bytes(topic.message), topic.max_age_us)
        for topic in made.topics
    ]
    return BridgeRow(
        kind=made.kind,
        file=f"{header(interface)}.hpp",
        name=node.name,
        class_name=interface.class_name,
        doc=interface.doc,
        ports_header=f"ports/{interface.name}/{interface.name}_ports.hpp",
        ports=f"{interface.namespace}::{interface.class_name}Ports",
        topics=topics,
        most_bytes=max([topic.bytes for topic in topics], default=LEAST_BYTES),
        graph_hash=f"0x{graph_hash(plan)[:HASH_DIGITS]}",
        cut_hash=f"0x{hashlib.sha256(made.cut.encode()).hexdigest()[:HASH_DIGITS]}",
        status_ticks=STATUS_TICKS,
        has_status="status" in node.inputs,
    )


def links(plan: Plan) -> LinksRow:
    graph = plan.graph
    first = next(iter(graph.machines))
    return LinksRow(
        links=[
            LinkRow(w.near_machine, w.near, w.far, w.link.baud, w.link.wake_up_us)
            for w in graph.wires
        ],
        machines=[
            MachineRow(
                name,
                [task.node.name for task in plan.tasks if task.node.machine == name],
                [
                    end
                    for wire in graph.wires
                    for end, machine in (
                        (wire.near, wire.near_machine),
                        (wire.far, wire.link.to),
                    )
                    if machine == name
                ],
            )
            for name in graph.machines
            if name != first
        ],
    )
