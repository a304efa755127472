"""Modes and chains of a graph."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from stator.graph.model import Chain, Modes, Node
from stator.language.keys import MAX_MODES
from stator.language.shapes import Leaf, Record, items

if TYPE_CHECKING:
    from stator.diagnostics import Mark, Report
    from stator.graph.checks.nodes import Nodes

MODE_TOPIC = "mode"
MODE_MESSAGE = "Mode"


def read_modes(record: Record, nodes: Nodes, report: Report) -> Modes | None:
    modes = record.get("modes")
    if modes is None or modes.get("sets") is None:
        return None
    table = modes.get("sets")
    sets = {mode: _set(leaf, record, nodes, report) for mode, leaf in table.values.items()}
    initial = modes.get("initial")
    if initial is not None and initial.value not in table.keys:
        report.error(
            initial.mark,
            "mode-initial",
            f"unknown mode '{initial.value}'",
            report.nearest(initial.value, table.keys) or "add the modes and their nodes to `sets`",
        )
    if len(sets) > MAX_MODES:
        report.error(
            table.owner,
            "out-of-range",
            f"expected at most {MAX_MODES} modes, found {len(sets)}",
            "use modes to exchange nodes only; flight modes are a field of a message",
        )
    publisher = _mode_publisher(record.keys["modes"], nodes, report)
    if publisher is None or initial is None:
        return None
    _check_publisher_runs(publisher, sets, report)
    return Modes(initial.value, sets, publisher.name)


def _set(leaf: Leaf, record: Record, nodes: Nodes, report: Report) -> tuple[str, ...]:
    names: list[str] = []
    for name in leaf.value:
        node = record.get("nodes").values.get(name.value)
        if name.value not in nodes.declared:
            report.error(
                name.mark,
                "mode-node",
                f"unknown node '{name.value}'",
                report.nearest(name.value, nodes.declared),
            )
        elif node is not None and "device" in node.keys:
            report.error(
                name.mark,
                "mode-driver",
                f"'{name.value}' owns a device: such a node always runs",
                "remove it from the mode",
            )
        elif name.value in names:
            report.error(
                name.mark,
                "mode-repeat",
                f"duplicate node '{name.value}' in this mode",
                "keep one of them",
            )
        else:
            names.append(name.value)
    return tuple(names)


def _mode_publisher(mark: Mark, nodes: Nodes, report: Report) -> Node | None:
    publishers = [
        node
        for node in nodes.good.values()
        if any(o.topic == MODE_TOPIC for o in node.outputs.values())
    ]
    if not publishers and nodes.may_publish(MODE_TOPIC):
        return None
    if len(publishers) != 1:
        found = " and ".join(f"'{node.name}'" for node in publishers) or "none"
        report.error(
            mark,
            "mode-topic",
            f"expected one node that publishes the topic '{MODE_TOPIC}', found {found}",
            "keep one of them: it selects the mode"
            if publishers
            else "add one: it selects the mode",
        )
        return None
    output = next(o for o in publishers[0].outputs.values() if o.topic == MODE_TOPIC)
    message = output.port.message
    field = next((f for f in message.fields if f.name == MODE_TOPIC), None)
    if (
        message.name != MODE_MESSAGE
        or field is None
        or (field.type, field.count) != ("uint8", None)
    ):
        report.error(
            output.mark,
            "message-mismatch",
            f"expected the message {MODE_MESSAGE} with the field `{MODE_TOPIC}: uint8` on topic "
            f"'{MODE_TOPIC}', found {message.name}",
            "rename this topic",
        )
        return None
    return publishers[0]


def _check_publisher_runs(node: Node, sets: dict[str, tuple[str, ...]], report: Report) -> None:
    missing = [mode for mode, names in sets.items() if node.name not in names]
    if 0 < len(missing) < len(sets):
        report.error(
            node.mark,
            "mode-topic",
            f"'{node.name}' selects the mode, and does not run in '{missing[0]}': that mode could "
            "not end",
            "remove it from all modes: then it always runs",
        )


def read_chains(record: Record, nodes: Nodes, report: Report) -> tuple[Chain, ...]:
    chains = []
    for name, value in items(record, "chains"):
        path, deadline = value.get("path"), value.get("deadline")
        for leaf in path.value if path is not None else ():
            if leaf.value not in nodes.declared:
                report.error(
                    leaf.mark,
                    "chain-node",
                    f"unknown node '{leaf.value}'",
                    report.nearest(leaf.value, nodes.declared),
                )
        if path is None or deadline is None:
            continue
        for before, after in pairwise(path.value):
            _check_link(before.value, after.value, after.mark, nodes, report)
        chains.append(
            Chain(
                name,
                tuple(leaf.value for leaf in path.value),
                deadline.value,
                record.get("chains").keys[name],
            )
        )
    return tuple(chains)


def _check_link(before: str, after: str, mark: Mark, nodes: Nodes, report: Report) -> None:
    for name in (before, after):
        if name not in nodes.good or name in nodes.damaged:
            return
    published = {output.topic for output in nodes.good[before].outputs.values()}
    if not published & {source.topic for source in nodes.good[after].inputs.values()}:
        report.error(
            mark,
            "chain-link",
            f"'{after}' reads no topic that '{before}' publishes",
            "name every node of the chain, from first to last",
        )
