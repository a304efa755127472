"""The node that publishes all parameters of a graph."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import beside
from stator.graph.param_ids import NUMBER, former_keys_of, full_name, id_of, key_of
from stator.language.keys import MAX_PARAM_ID, MAX_PARAM_NAME, MAX_PARAM_NODES, MAX_PARAMS

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
    count = sum(len(node.params) for node in owners)
    if count > MAX_PARAMS:
        report.error(
            publishers[0].mark,
            "params-publisher",
            f"expected at most {MAX_PARAMS} parameters, found {count}",
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


def check_param_ids(nodes: dict[str, Node], report: Report) -> None:
    """Ground stations know a parameter by its id, and a memory for records knows it by a key."""
    ids: dict[str, tuple[Node, str]] = {}
    keys: dict[int, tuple[Node, str]] = {}
    for node in nodes.values():
        for name, param in node.interface.params.items():
            param_id = id_of(node.name, param)
            if len(param_id) > MAX_PARAM_ID:
                report.error(
                    node.mark,
                    "out-of-range",
                    f"expected a parameter id of at most {MAX_PARAM_ID} characters, found "
                    f"{len(param_id)}: '{param_id}' of {full_name(node.name, name)}",
                    f"give the node a shorter number, or write a shorter `id` in "
                    f"{node.interface.name}.yaml",
                )
            _check_other("id", param_id, ids.setdefault(param_id, (node, name)), node, name, report)
            for key in (key_of(node.name, name), *former_keys_of(node.name, param)):
                other = keys.setdefault(key, (node, name))
                _check_other("key", f"{key:#010x}", other, node, name, report)


def _check_other(
    what: str, value: str, other: tuple[Node, str], node: Node, name: str, report: Report
) -> None:
    if other == (node, name):
        return
    is_given = what == "id" and node.interface.params[name].id
    hint = f"other one: {beside(node.mark, other[0].mark)}; "
    if what == "key":
        hint += "rename one of them, or remove this name from `was`"
    elif is_given and node.interface is other[0].interface:
        hint += (
            f"write {NUMBER} in the id in {node.interface.name}.yaml, and number the nodes at the "
            "end of their names"
        )
    else:
        hint += "write another `id` in one of the interfaces"
    report.error(
        node.mark,
        "params-id",
        f"expected a parameter {what} of its own for {full_name(node.name, name)}, found '{value}' "
        f"also for {full_name(other[0].name, other[1])}",
        hint,
    )
