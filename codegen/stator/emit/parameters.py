"""Rows of parameters: their values at the start, and the table by which one node changes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.emit.rows import literal

if TYPE_CHECKING:
    from fractions import Fraction

    from stator.graph.model import Message, Node, Param
    from stator.plan.plan import Plan

KINDS = {"float": "real", "int32": "whole", "bool": "flag"}
# The range of a parameter without `range`: the values that the checker accepts for its type.
WITHOUT_RANGE = {"float": "1e+37F", "int32": "2147483647"}


@dataclass(frozen=True)
class NamedValue:
    name: str
    value: str


@dataclass(frozen=True)
class StartValues:
    """The parameters of a node, before anything runs."""

    topic: str
    message: str
    values: list[NamedValue]


@dataclass(frozen=True)
class PublishedRow:
    topic: str
    keep: str


@dataclass(frozen=True)
class ParameterTable:
    headers: list[str]
    rows: list[str]
    topics: list[PublishedRow]


def start_values(plan: Plan) -> list[StartValues]:
    return [
        StartValues(
            topic=f"{node.name}_params",
            message=node.interface.params_message.name,
            values=[NamedValue(key, literal(value)) for key, value in node.params.items()],
        )
        for node in plan.graph.nodes.values()
        if node.interface.params_message is not None
    ]


def published(plan: Plan, node: Node) -> list[PublishedRow]:
    """The topics of parameters that this node publishes, in the order of their nodes."""
    return [
        PublishedRow(topic.name, "true" if topic.kept_by else "false")
        for topic in plan.topics.values()
        if topic.owner and node.name in topic.publishers
    ]


def table(plan: Plan) -> ParameterTable | None:
    """None: no node of the graph publishes parameters."""
    publisher = next((n for n in plan.graph.nodes.values() if n.interface.publishes_params), None)
    if publisher is None:
        return None
    nodes = [node for node in plan.graph.nodes.values() if node.params]
    return ParameterTable(
        headers=sorted({_message(node).header for node in nodes}),
        rows=[_row(i, node, key) for i, node in enumerate(nodes) for key in node.params],
        topics=published(plan, publisher),
    )


def _message(node: Node) -> Message:
    assert node.interface.params_message is not None
    return node.interface.params_message


def _row(index: int, node: Node, key: str) -> str:
    param = node.interface.params[key]
    values = [literal(node.params[key])]
    if param.type != "bool":
        values = [_bound(param, param.least, "-"), _bound(param, param.most), *values]
    place = f"{index}, offsetof({_message(node).name}, {key})"
    row = f'parameter::{KINDS[param.type]}("{node.name}.{key}", {place}, {", ".join(values)})'
    return f"parameter::fixed({row})" if param.is_fixed else row


def _bound(param: Param, bound: Fraction | None, sign: str = "") -> str:
    if bound is None:
        return sign + WITHOUT_RANGE[param.type]
    return literal(bound if param.type == "float" else int(bound))
