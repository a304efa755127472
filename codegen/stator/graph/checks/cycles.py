"""Topic triggers must not form a cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stator.diagnostics import Report
    from stator.graph.model import Node, Topic


def check_cycles(nodes: dict[str, Node], topics: dict[str, Topic], report: Report) -> None:
    """Follows topic triggers, depth first. Topics are places on the path, so that many publishers
    with many readers cost their sum and not their product."""
    wakes = _wakes(nodes, topics)
    done: set[str] = set()
    for start in nodes:
        if start in done:
            continue
        path: dict[str, Iterator[str]] = {start: iter(wakes[start])}  # in order of insertion
        while path:
            name = next(reversed(path))
            following = next(path[name], None)
            if following is None:
                del path[name]
                done.add(name)
            elif following in path:
                _refuse(list(path), following, nodes, report)
            elif following not in done:
                path[following] = iter(wakes[following])


def _wakes(nodes: dict[str, Node], topics: dict[str, Topic]) -> dict[str, list[str]]:
    """Node -> topics it publishes; topic -> nodes it triggers. Topics are spelled `> topic`."""
    wakes = {
        f"> {name}": [node for node, _ in topic.readers if nodes[node].trigger_of(name) is not None]
        for name, topic in topics.items()
    }
    for node in nodes.values():
        wakes[node.name] = [f"> {output.topic}" for output in node.outputs.values()]
    return wakes


def _refuse(path: list[str], following: str, nodes: dict[str, Node], report: Report) -> None:
    cycle = [name for name in path[path.index(following) :] if name in nodes]
    # Begin with the node that comes first in the graph: the text is then independent of the search.
    order = {name: i for i, name in enumerate(nodes)}
    first = cycle.index(min(cycle, key=order.__getitem__))
    cycle = [*cycle[first:], *cycle[:first], cycle[first]]
    shown = " -> ".join(cycle) if len(cycle) <= 8 else " -> ".join([*cycle[:7], "...", cycle[-1]])
    last = nodes[cycle[-2]]
    topic = next(
        t
        for t in nodes[cycle[0]].triggers
        if t.kind == "topic" and any(o.topic == t.name for o in last.outputs.values())
    )
    report.error(
        topic.mark,
        "trigger-cycle",
        f"topic triggers form a cycle: {shown}",
        f"trigger '{cycle[0]}' by a period (`every`) instead, and read '{topic.name}' as latest",
    )
