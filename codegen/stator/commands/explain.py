"""`./stator explain`: when and where a node runs, and why; what a topic needs; a chain's way; what
the vehicle can do."""

from __future__ import annotations

import math
import re
import textwrap
from itertools import pairwise
from typing import TYPE_CHECKING

from stator.arguments import add_graph_arguments
from stator.diagnostics import Failed, UserError, in_place, nearest, shown_path
from stator.graph.vehicle import param_values
from stator.language.period import spelled_us
from stator.language.shapes import quoted
from stator.pipeline import make_plan
from stator.plan.rates import Rates
from stator.plan.text import triggers_text
from stator.prove.needs import require_provable
from stator.prove.problems import shown_ns
from stator.prove.proof import prove

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterable
    from fractions import Fraction

    from stator.graph.model import Chain, Message, Node
    from stator.graph.vehicle import Vehicle
    from stator.plan.plan import Plan, Task
    from stator.plan.topics import TopicPlan

Row = tuple[str, str]  # label and text

COLUMNS = 100
WAYS = {
    "trigger": "each activation reads one sample, in order",
    "thinned": "latest",
    "queue": "every sample, in order",
    "latest": "latest",
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_graph_arguments(parser)
    parser.add_argument("node", help="node, topic, message, chain or vehicle of the graph")


def main(arguments: argparse.Namespace) -> int:
    plan = make_plan(arguments.graph, arguments.board)
    lines = explain(plan, arguments.node)
    if lines is None:
        known = [*plan.graph.nodes, *plan.topics, *(chain.name for chain in plan.graph.chains)]
        known += sorted({topic.message.name for topic in plan.topics.values()})
        known.append(plan.graph.vehicle.name)
        raise UserError(
            f"error: unknown node, topic, message, chain or vehicle '{arguments.node}' of "
            f"{plan.graph.name}\n"
            f"hint: {nearest(arguments.node, known)}"
        )
    print(in_place("\n".join(lines)))
    return 0


def explain(plan: Plan, name: str) -> list[str] | None:
    """Lines about a node, a topic, a message, a chain or the vehicle; None if the graph has none of
    this name."""
    if name in plan.graph.nodes:
        task = plan.task(name)
        rows = [*_runs(plan, task), *_ports(plan, task.node), *_params(task.node)]
        return _text(f"{name}: {task.node.interface.doc}", rows)
    if name in plan.topics:
        topic = plan.topics[name]
        rows = [*_topic(plan, topic), *_fields(topic.message)]
        return _text(f"{name}: {topic.message.doc}", rows)
    carrying = [topic for topic in plan.topics.values() if topic.message.name == name]
    if carrying:
        message = carrying[0].message
        topics = ", ".join(topic.name for topic in carrying)
        rows = [("topics", topics), ("size", f"{message.bytes} bytes"), *_fields(message)]
        return _text(f"{name}: {message.doc}", rows)
    for chain in plan.graph.chains:
        if chain.name == name:
            return _text(f"{name}: a chain of {len(chain.path)} nodes", _chain(plan, chain))
    if name == plan.graph.vehicle.name:
        return _text(f"{name}: {plan.graph.vehicle.doc}", _vehicle(plan.graph.vehicle))
    return None


def _vehicle(vehicle: Vehicle) -> list[Row]:
    """What it can do, and what nodes take from it."""
    battery = vehicle.battery
    motors = f"{len(vehicle.places)} rotors"
    if vehicle.rotors is None:
        motors = f"{len(vehicle.propellers)} propellers"
    xx, yy, zz, xz = vehicle.inertia
    rows = [
        ("in", shown_path(vehicle.file)),
        ("mass", f"{vehicle.mass:g} kg"),
        ("inertia", f"xx {xx:g}, yy {yy:g}, zz {zz:g}, xz {xz:g} kg m^2"),
        (
            "thrust",
            f"{vehicle.most_thrust:.1f} N of {motors}, "
            f"{vehicle.thrust_over_weight:.2f} times the weight",
        ),
        ("battery", f"{battery.cells} cells, {battery.capacity / 3600.0:g} Ah"),
    ]
    for i, rotor in enumerate(vehicle.places):
        wake = "" if rotor.in_wake == 1.0 else f", {rotor.in_wake:g} of its thrust in a wake"
        turns = "counter-clockwise" if rotor.is_ccw else "clockwise"
        place = f"{rotor.x:g} m forward, {rotor.y:g} m right, {rotor.z:g} m down"
        rows.append((f"rotor {i + 1}", f"{place}, turns {turns}{wake}"))
    for i, surface in enumerate(vehicle.surfaces):
        least, most = math.degrees(surface.least), math.degrees(surface.most)
        rows.append((f"surface {i + 1}", f"{surface.name}, {least:.4g} to {most:.4g} deg"))
    given = [
        (key, value)
        for key, value in param_values(vehicle).items()
        if "rotor" not in key and not re.match(r"surface\d", key)
    ]
    rows += [(f"value {key}", f"{float(value):g}") for key, value in given]
    return rows


def _chain(plan: Plan, chain: Chain) -> list[Row]:
    """Its way from node to node, and what can make it late."""
    first = plan.task(chain.path[0])
    rows = [
        ("in", f"{shown_path(chain.mark.file)}:{chain.mark.line}"),
        ("deadline", f"{spelled_us(chain.deadline_us)}, from the release of {first.node.name}"),
        ("begins", f"{first.node.name} (level {first.level}): {triggers_text(first.node)}"),
    ]
    for before, name in pairwise(chain.path):
        task = plan.task(name)
        topics = {output.topic for output in plan.graph.nodes[before].outputs.values()}
        ways = [
            f"{source.topic} ({WAYS[task.node.way_of(source)]})"
            for source in task.node.inputs.values()
            if source.topic in topics
        ]
        rows.append(("then", f"{name} (level {task.level}) by {' and '.join(ways)}"))
    tasks = [plan.task(name) for name in chain.path]
    lowest = min(task.level for task in tasks)
    others = [t for t in plan.tasks if t.level >= lowest and t not in tasks]
    rows.append(("waits for", _names(others) if others else "no other node"))
    return rows


def _runs(plan: Plan, task: Task) -> list[Row]:
    """When and where a node runs."""
    node = task.node
    rows = [
        ("in", f"{shown_path(node.mark.file)}:{node.mark.line}"),
        ("app" if node.device is None else "device", _what(plan, node)),
        ("triggers", triggers_text(node)),
        ("shortest period", _period(Rates(plan.graph).node(node.name))),
        ("level", _level(plan, task)),
    ]
    if task.vector is not None and plan.board.chip is not None:
        chip = plan.board.chip.name.split("/")[-1]
        rows.append(("vector", f"{task.vector} of {chip}, {_vector_reason(plan, node)}"))
    peers = [t.node.name for t in plan.tasks if t.level == task.level]
    if len(peers) > 1:
        rows.append(("order", f"within its level: {', '.join(peers)}"))
    rows.append(("preempted by", _names(t for t in plan.tasks if t.level > task.level)))
    rows.append(("preempts", _names(t for t in plan.tasks if t.level < task.level)))
    rows += _response(plan, node.name)
    owned = sum(_bytes(t) for t in plan.topics.values() if node.name in (t.owner, *t.publishers))
    rows.append(
        ("memory", f"{owned} bytes of slots; ./stator build shows the sizes of code and state")
    )
    return rows


def _response(plan: Plan, name: str) -> list[Row]:
    """The worst one, and who takes how much of it; only where it can be proven."""
    if plan.board.costs is None:
        return []
    try:
        require_provable(plan)
    except (Failed, UserError):
        return [("response", "unknown; ./stator prove says what is missing")]
    task = prove(plan).task(name)
    if task.response_ns is None or task.slack_ns is None:
        return [("response", "no bound: the levels above have too much to do")]
    text = f"at most {shown_ns(task.response_ns)}, deadline {shown_ns(task.deadline_ns)}"
    text += "" if task.holds else ": LATE"
    shares = [f"{share.name} {shown_ns(share.cost)}" for share in task.shares]
    return [("response", text), ("worst window", ", ".join(shares))]


def _ports(plan: Plan, node: Node) -> list[Row]:
    rows = []
    for key, source in node.inputs.items():
        topic = plan.topics[source.topic]
        kind = WAYS[node.way_of(source)]
        publishers = ", ".join(topic.publishers)
        text = f"{topic.name} ({topic.message.name}) from {publishers}; {kind}"
        if source.max_age_us:
            text += f", absent when older than {spelled_us(source.max_age_us)}"
        rows.append((f"reads {key}", text))
    for key, output in node.outputs.items():
        readers = ", ".join(name for name, _ in plan.topics[output.topic].readers) or "no node"
        rows.append((f"writes {key}", f"{output.topic}, read by {readers}"))
    return rows


def _params(node: Node) -> list[Row]:
    rows = []
    for key, param in node.interface.params.items():
        value = node.params[key]
        unit = "" if param.unit == "1" else f" {param.unit}"
        shown = str(value).lower() if isinstance(value, bool) else f"{float(value):g}{unit}"
        note = "" if value != param.default else " (default)"
        rows.append((f"param {key}", f"{shown}{note}: {param.doc}"))
    return rows


def _level(plan: Plan, task: Task) -> str:
    levels = sorted({t.level for t in plan.tasks}, reverse=True)
    place = levels.index(task.level) + 1
    reason = "derived from its deadline" if plan.derived else "given in the graph"
    return f"{task.level} (rank {place} of {len(levels)} in urgency); {reason}"


def _topic(plan: Plan, topic: TopicPlan) -> list[Row]:
    levels = {task.node.name: task.level for task in plan.tasks}

    def with_level(name: str) -> str:
        return f"{name} (level {levels[name]})"

    log = "not logged"
    if topic.log_us is not None:
        log = f"every {spelled_us(topic.log_us)}" if topic.log_us else "every sample"
    elif topic.owner and any(n.interface.reads_log for n in plan.graph.nodes.values()):
        log = "as parameters" + (", at each change" if topic.publishers else "")
    guard = "no critical section: only one level publishes"
    if topic.ceiling:
        guard = (
            f"loan and commit mask levels up to {topic.ceiling}, because several levels publish; "
            "./stator build shows for how many instructions"
        )
    publishers = ", ".join(map(with_level, topic.publishers))
    return [
        ("message", f"{topic.message.name}, {topic.message.bytes} bytes"),
        ("publishers", publishers or "none: these parameters are fixed"),
        ("readers", ", ".join(with_level(name) for name, _ in topic.readers) or "none"),
        ("shortest period", _period(topic.period_us)),
        ("depth", str(topic.depth)),
        ("slots", f"{topic.slots} ({_bytes(topic)} bytes)"),
        ("publishing", guard),
        ("log", log),
    ]


def _fields(message: Message) -> list[Row]:
    rows = []
    for field in message.fields:
        if field.name.startswith("_padding"):
            continue
        count = f"[{field.count}]" if field.count is not None else ""
        unit = f", {field.unit}" if field.unit not in ("", "1") else ""
        frame = f", frame {field.frame}" if field.frame else ""
        values = ", ".join(f"{name} {value}" for name, value in field.values)
        doc = f"{field.doc} {values}" if values else field.doc
        rows.append((f"field {field.name}", f"{field.type}{count}{unit}{frame}: {doc}"))
    return rows


def _text(title: str, rows: list[Row]) -> list[str]:
    """A long text continues on the next line, indented."""
    width = max(len(label) for label, _ in rows)
    lines = textwrap.wrap(title, COLUMNS)
    for label, text in rows:
        lines += textwrap.wrap(
            text,
            COLUMNS,
            initial_indent=f"  {label:<{width}}  ",
            subsequent_indent=" " * (width + 4),
            break_long_words=False,
            break_on_hyphens=False,
        )
    return lines


def _bytes(topic: TopicPlan) -> int:
    return topic.slots * topic.message.bytes


def _names(tasks: Iterable[Task]) -> str:
    return ", ".join(task.node.name for task in tasks) or "none"


def _period(period: Fraction | None) -> str:
    if period is None:
        return "unknown"
    return f"{float(period):g} us ({1e6 / float(period):g} Hz)"


def _what(plan: Plan, node: Node) -> str:
    if node.device is None:
        return shown_path(node.interface.file.parent)
    driver = plan.board.devices[node.device].driver
    bound = "no driver" if driver == "none" else f"driver {driver}"
    return f"{quoted(node.device)} of class {node.interface.name}; {bound} on {plan.board.name}"


def _vector_reason(plan: Plan, node: Node) -> str:
    from stator.plan.plan import vector_of

    only = node.triggers[0]
    if len(node.triggers) == 1 and only.kind == "irq" and node.device is not None:
        for wire in plan.board.devices[node.device].lines[only.name]:
            number = plan.board.chip.vectors.get(vector_of(wire)) if plan.board.chip else None
            if number == plan.task(node.name).vector:
                return f"the vector of its line {only.name} ({wire})"
    return "a spare vector, pended by software"
