"""Changes of a graph for a proof: `NODE.KEY=VALUE`, without a file."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stator.diagnostics import Failed, Report, UserError, nearest
from stator.graph.model import Budget
from stator.language.keys import MAX_LEVELS, PROVENANCES
from stator.language.period import Period
from stator.language.yaml_tree import parse
from stator.plan.plan import Plan
from stator.plan.plan import plan as make_plan
from stator.prove.proof import prove

if TYPE_CHECKING:
    from pathlib import Path

    from stator.graph.model import Graph, Node, Trigger

KEYS = ("priority", "budget", "deadline", "every", "min_interarrival", "min_interval")
HINT = "write --set NODE.KEY=VALUE, such as rate_control.budget=30us or logger.every=10ms"


def changed(plan: Plan, texts: list[str]) -> Plan:
    """The plan of the changed graph. Raises `Failed` or `UserError`."""
    graph = plan.graph
    for text in texts:
        graph = _change(graph, text)
    return make_plan(graph, plan.board)


def with_period(plan: Plan, name: str, us: int) -> Plan:
    """With another period, or another least time between two events, of a node's first source."""
    node = plan.graph.nodes[name]
    key = "every" if _place(node, "every") is not None else "min_interarrival"
    return make_plan(_with_node(plan.graph, _with_trigger(node, key, us)), plan.board)


def shortest_period_us(plan: Plan, name: str) -> int | None:
    """With which the whole graph is still proven; None: not even with its own."""
    node = plan.graph.nodes.get(name)
    if node is None:
        raise UserError(
            f"error: unknown node '{name}' of {plan.graph.name}\n"
            f"hint: {nearest(name, plan.graph.nodes)}"
        )
    trigger = next((t for t in node.triggers if t.kind in ("every", "irq")), None)
    if trigger is None:
        raise UserError(
            f"error: cannot change the rate of '{name}': its samples come from other nodes\n"
            "hint: name the node with the line or the period that they come from"
        )
    high = trigger.period_us if trigger.kind == "every" else trigger.min_interarrival_us or 0
    if not prove(plan).holds:
        return None
    low = 0
    while high - low > 1:
        middle = (low + high) // 2
        if _holds_at(plan, name, middle):
            high = middle
        else:
            low = middle
    return high


def _holds_at(plan: Plan, name: str, us: int) -> bool:
    """A period that needs more slots than a topic may have does not."""
    try:
        return prove(with_period(plan, name, us)).holds
    except Failed:
        return False


def _change(graph: Graph, text: str) -> Graph:
    left, _, value = text.partition("=")
    name, _, key = left.partition(".")
    if not value or not key:
        raise UserError(f"error: expected a change, found '{text}'\nhint: {HINT}")
    if name not in graph.nodes:
        raise UserError(
            f"error: unknown node '{name}' of {graph.name}\nhint: {nearest(name, graph.nodes)}"
        )
    if key not in KEYS:
        raise UserError(f"error: cannot change '{key}' of a node\nhint: {nearest(key, KEYS)}")
    node = graph.nodes[name]
    if key == "priority":
        return _with_node(graph, replace(node, priority=_priority(graph, text, value)))
    us = _period_us(graph.file, text, value)
    if key == "budget":
        return _with_node(graph, replace(node, budget=Budget(us, PROVENANCES[0])))
    if key == "deadline":
        return _with_node(graph, replace(node, deadline_us=us))
    if _place(node, key) is None:
        raise UserError(f"error: node '{name}' has no trigger with `{key}`\nhint: {HINT}")
    return _with_node(graph, _with_trigger(node, key, us))


def _priority(graph: Graph, text: str, value: str) -> int:
    if any(node.priority is None for node in graph.nodes.values()):
        raise UserError(
            f"error: cannot change '{text}': the priorities of {graph.name} follow from deadlines\n"
            "hint: change a deadline"
        )
    if not value.isdigit() or not 1 <= int(value) <= MAX_LEVELS:
        raise UserError(
            f"error: expected a priority from 1 to {MAX_LEVELS}, found '{value}'\nhint: {HINT}"
        )
    return int(value)


def _period_us(file: Path, text: str, value: str) -> int:
    report = Report()
    tree = parse(value, file, report)
    leaf = None if tree is None else Period().read(tree, report)
    if leaf is None:
        raise UserError(f"error: expected a time with its unit in '{text}'\nhint: {HINT}")
    us: int = leaf.value
    return us


def _place(node: Node, key: str) -> int | None:
    """The first trigger that has such a time."""
    for place, trigger in enumerate(node.triggers):
        if _has(trigger, key):
            return place
    return None


def _has(trigger: Trigger, key: str) -> bool:
    if key == "every":
        return trigger.kind == "every"
    if key == "min_interarrival":
        return trigger.kind == "irq"
    return trigger.kind == "topic" and trigger.min_interval_us is not None


def _with_trigger(node: Node, key: str, us: int) -> Node:
    place = _place(node, key)
    assert place is not None
    old = node.triggers[place]
    if key == "every":
        new = replace(old, period_us=us, offset_us=min(old.offset_us, us - 1))
    elif key == "min_interarrival":
        new = replace(old, min_interarrival_us=us)
    else:
        new = replace(old, min_interval_us=us)
    return replace(node, triggers=(*node.triggers[:place], new, *node.triggers[place + 1 :]))


def _with_node(graph: Graph, node: Node) -> Graph:
    return replace(graph, nodes={**graph.nodes, node.name: node})
