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
            f"'{first.name}' publishes all parameters already ({beside(node.mark, first.mark)})",
            "keep one of them",
        )
    if not publishers:
        return
    owners = [node for node in nodes.values() if node.params]
    if len(owners) > MAX_PARAM_NODES:
        report.error(
            publishers[0].mark,
            "params-publisher",
            f"{len(owners)} nodes have parameters, and one node publishes those of at most "
            f"{MAX_PARAM_NODES}",
            "leave this one out: then parameters are fixed",
        )
    for node in owners:
        longest = max(node.params, key=len)
        name = f"{node.name}.{longest}"
        if len(name) > MAX_PARAM_NAME:
            report.error(
                node.mark,
                "params-name",
                f"'{name}' is longer than the {MAX_PARAM_NAME} characters by which "
                f"'{publishers[0].name}' is asked for it",
                "give the node a shorter name",
            )
