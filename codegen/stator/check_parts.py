"""Modes and chains of a graph."""

from __future__ import annotations

from stator.diagnostics import Mark, Report, nearest
from stator.model import Chain, Modes, Node
from stator.shapes import Record

MODE_TOPIC = "mode"


def read_modes(record: Record, nodes: dict[str, Node], report: Report) -> Modes | None:
    modes = record.get("modes")
    if modes is None or modes.get("sets") is None or modes.get("initial") is None:
        return None
    sets: dict[str, tuple[str, ...]] = {}
    for mode, leaf in modes.get("sets").values.items():
        names: list[str] = []
        for name in leaf.value:
            if name.value not in nodes:
                report.error(name.mark, "mode-node", f"there is no node '{name.value}'",
                             nearest(name.value, nodes))
            elif nodes[name.value].device is not None:
                report.error(name.mark, "mode-driver", f"'{name.value}' owns a device; drivers "
                             "always run", "remove it from the mode")
            elif name.value in names:
                report.error(name.mark, "mode-repeat", f"'{name.value}' is in this mode already",
                             "remove one of the two")
            else:
                names.append(name.value)
        sets[mode] = tuple(names)
    initial = modes.get("initial")
    if initial.value not in sets:
        report.error(initial.mark, "mode-initial", f"there is no mode '{initial.value}'",
                     nearest(initial.value, sets))
    publishers = [node.name for node in nodes.values()
                  if any(o.topic == MODE_TOPIC for o in node.outputs.values())]
    if len(publishers) != 1:
        found = ", ".join(publishers) or "none"
        report.error(record.keys["modes"], "mode-topic", "modes need exactly one node that publishes "
                     f"the topic '{MODE_TOPIC}'; there is {found}")
        return None
    output = next(o for o in nodes[publishers[0]].outputs.values() if o.topic == MODE_TOPIC)
    if output.port.message.name != "Mode":
        report.error(output.mark, "message-mismatch", f"the topic '{MODE_TOPIC}' carries Mode, not "
                     f"{output.port.message.name}")
    return Modes(initial.value, sets, publishers[0])


def read_chains(record: Record, nodes: dict[str, Node], report: Report) -> tuple[Chain, ...]:
    table = record.get("chains")
    chains = []
    for name, value in (table.values if table is not None else {}).items():
        path, deadline = value.get("path"), value.get("deadline")
        if path is None or deadline is None:
            continue
        known = True
        for leaf in path.value:
            if leaf.value not in nodes:
                known = False
                report.error(leaf.mark, "chain-node", f"there is no node '{leaf.value}'",
                             nearest(leaf.value, nodes))
        if known:
            for before, after in zip(path.value, path.value[1:]):
                _check_link(nodes[before.value], nodes[after.value], after.mark, report)
        chains.append(Chain(name, tuple(leaf.value for leaf in path.value), deadline.value,
                            table.keys[name]))
    return tuple(chains)


def _check_link(before: Node, after: Node, mark: Mark, report: Report) -> None:
    published = {output.topic for output in before.outputs.values()}
    if not published & {source.topic for source in after.inputs.values()}:
        report.error(mark, "chain-link", f"'{after.name}' reads nothing that '{before.name}' "
                     "publishes", "name the nodes in the order in which the samples go")
