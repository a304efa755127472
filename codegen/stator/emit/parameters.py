"""Rows of parameters: their values at the start, and the table by which one node changes them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.emit.rows import literal
from stator.graph.param_ids import definition_of, former_keys_of, id_of, key_of

if TYPE_CHECKING:
    from fractions import Fraction

    from stator.graph.model import Message, Node, Param
    from stator.plan.plan import Plan

TYPES = {"float": "kFloat", "int32": "kInt32", "bool": "kBool"}
KINDS = {"float": "real", "int32": "whole", "bool": "flag"}
# The range of a parameter without `range`: the values that the checker accepts for its type.
WITHOUT_RANGE = {"float": "1e+37F", "int32": "2147483647"}


@dataclass(frozen=True)
class NamedValue:
    name: str
    value: str
    type: str


@dataclass(frozen=True)
class StartValues:
    """The parameters of a node, before anything runs."""

    name: str
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
    rows: list[str]  # in the order of their ids
    former: list[str]  # keys of records that they had under other names
    topics: list[PublishedRow]


def start_values(plan: Plan) -> list[StartValues]:
    return [
        StartValues(
            name=node.name,
            topic=f"{node.name}_params",
            message=node.interface.params_message.name,
            values=[
                NamedValue(key, literal(value), TYPES[node.interface.params[key].type])
                for key, value in node.params.items()
            ],
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
    publisher = plan.graph.params_publisher
    if publisher is None:
        return None
    nodes = list(plan.graph.changeable.values())
    places = sorted(
        (id_of(node.name, param), i, node, param)
        for i, node in enumerate(nodes)
        for param in node.interface.params.values()
    )
    return ParameterTable(
        headers=sorted({_message(node).header for node in nodes}),
        rows=[_row(param_id, i, node, param) for param_id, i, node, param in places],
        former=[
            f"{{{key:#010x}U, {row}}}"
            for row, (_, _, node, param) in enumerate(places)
            for key in former_keys_of(node.name, param)
        ],
        topics=published(plan, publisher),
    )


def _message(node: Node) -> Message:
    assert node.interface.params_message is not None
    return node.interface.params_message


def _row(param_id: str, index: int, node: Node, param: Param) -> str:
    values = [literal(node.params[param.name])]
    if param.type != "bool":
        values = [_bound(param, param.least, "-"), _bound(param, param.most), *values]
    key, definition = key_of(node.name, param.name), definition_of(param)
    name = f'{{"{node.name}.{param.name}", "{param_id}", {key:#010x}U, {definition:#010x}U}}'
    place = f"{index}, offsetof({_message(node).name}, {param.name})"
    row = f"parameter::{KINDS[param.type]}({name}, {place}, {', '.join(values)})"
    row = row if param.in_flight else f"parameter::on_ground({row})"
    return f"parameter::fixed({row})" if param.is_fixed else row


def _bound(param: Param, bound: Fraction | None, sign: str = "") -> str:
    if bound is None:
        return sign + WITHOUT_RANGE[param.type]
    return literal(bound if param.type == "float" else int(bound))
