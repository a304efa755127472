"""The node that publishes all parameters of a graph."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import beside
from stator.language.keys import MAX_PARAM_NAME, MAX_PARAM_NODES

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.graph.model import Node


def check_params_publisher(nodes: dict[str, Node], report: Report) -> None:
    publishers = [node for node in nodes.values() if node.interface.publishes_params]
    for node in publishers[1:]:
        first = publishers[0]
        report.error(
            node.mark,
            "params-publisher",
            f"expected one node that publishes parameters, found '{first.name}' and '{node.name}'",
            f"first one: {beside(node.mark, first.mark)}; keep one of them",
        )
    if not publishers:
        return
    owners = [node for node in nodes.values() if node.params]
    if len(owners) > MAX_PARAM_NODES:
        report.error(
            publishers[0].mark,
            "params-publisher",
            f"expected at most {MAX_PARAM_NODES} nodes with parameters, found {len(owners)}",
            "remove this node: then parameters cannot change in flight",
        )
    for node in owners:
        longest = max(node.params, key=len)
        name = f"{node.name}.{longest}"
        if len(name) > MAX_PARAM_NAME:
            report.error(
                node.mark,
                "params-name",
                f"expected a parameter name of at most {MAX_PARAM_NAME} characters, found "
                f"{len(name)}: '{name}'",
                "give the node a shorter name",
            )
