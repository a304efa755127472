"""The machines of a graph: their boards and links, and what may cross them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from stator.diagnostics import Mark, Report, beside
from stator.graph.boards import find_board
from stator.graph.model import Board, Chain, Link, Machine, Modes, Node, Standby, Topic
from stator.language.shapes import Record

if TYPE_CHECKING:
    from collections.abc import Iterable

    from stator.graph.sources import Sources

SERIAL = "serial"  # the class of the devices that a link can use
# A frame holds the memory of a message, and COBS adds one byte up to this.
MAX_BODY = 247


@dataclass
class Machines:
    """The machines that later checks can use; none: all nodes run on the graph's own board."""

    own: Board | None
    board: Board | None  # to build for; its devices stand for those of all machines
    declared: dict[str, Mark] = field(default_factory=dict)
    good: dict[str, Machine] = field(default_factory=dict)

    def boards(self, machine: str) -> tuple[Board | None, Board | None]:
        """Of a node: that of its machine, and the one to build for."""
        if machine not in self.good:
            return self.own, self.board
        own = self.good[machine].board
        return own, own if self.board is self.own else self.board

    def is_first(self, machine: str) -> bool:
        return machine in ("", next(iter(self.declared), ""))

    def of_node(self, record: Record, report: Report) -> str:
        leaf = record.get("machine")
        if leaf is not None and leaf.value in self.declared:
            return str(leaf.value)
        if leaf is not None:
            _refuse_unknown(leaf.value, leaf.mark, self.declared, report)
        return next(iter(self.declared), "")

    def standby(self, record: Record, machine: str, report: Report) -> Standby | None:
        value = record.get("standby")
        leaf = None if value is None else value.get("machine")
        if leaf is None:
            return None
        mark = leaf.mark
        if leaf.value not in self.declared:
            _refuse_unknown(leaf.value, mark, self.declared, report)
        elif leaf.value == machine:
            report.error(
                mark,
                "standby",
                f"expected the standby on another machine than the node, found both on '{machine}'",
                "name another machine, or move the node with `machine`",
            )
        elif record.get("device") is not None:
            report.error(
                mark,
                "standby",
                "expected the standby of an app, found that of a driver",
                "remove `standby`: a device is on one machine",
            )
        else:
            return Standby(leaf.value, value.value("max_age"), mark)
        return None


def read_machines(
    record: Record, own: Board | None, board: Board | None, sources: Sources
) -> Machines:
    machines = Machines(own, board)
    table = record.get("machines")
    if table is None:
        return machines
    report = sources.report
    machines.declared = dict(table.keys)
    for name, value in table.values.items():
        leaf = value.get("board")
        found = None if leaf is None else find_board(sources, leaf.value, leaf.mark)
        if leaf is None or found is None:
            continue
        link = _link(name, value, found, machines, report)
        machines.good[name] = Machine(name, found, link, table.keys[name])
        if machines.is_first(name) and own is not None and found.name != own.name:
            report.error(
                leaf.mark,
                "machine-first",
                f"expected the graph's board '{own.name}' for the first machine, found "
                f"'{found.name}'",
                f"write `board: {found.name}` in the graph, or {own.name} here",
            )
    _check_lines(machines, report)
    return machines


def _link(
    name: str, record: Record, board: Board, machines: Machines, report: Report
) -> Link | None:
    link, mark = record.get("link"), record.owner
    if machines.is_first(name):
        if "link" in record.keys:
            report.error(
                record.keys["link"],
                "machine-first",
                f"expected no link of '{name}', the first machine",
                "write the link at the machine that stands later",
            )
        return None
    if "link" not in record.keys:
        first = next(iter(machines.declared))
        report.error(
            mark,
            "machine-first",
            f"missing link of machine '{name}'",
            f"add `link: {{to: {first}, here: DEVICE, there: DEVICE, baud: 921600}}`",
        )
    to = None if link is None else link.get("to")
    if to is None or any(link.get(key) is None for key in ("here", "there", "baud")):
        return None
    before = list(machines.declared)[: list(machines.declared).index(name)]
    if to.value not in before:
        if to.value in machines.declared:
            report.error(
                to.mark,
                "machine-first",
                f"expected a machine that stands before '{name}', found '{to.value}'",
                f"name one of: {', '.join(before)}",
            )
        else:
            _refuse_unknown(to.value, to.mark, before, report)
        return None
    wake_up = link.value("wake_up")
    if wake_up is None and board.executor == "pthread":
        report.error(
            to.mark,
            "link-wake-up",
            f"missing key 'wake_up' of the link of '{name}': on {board.name} nothing bounds the "
            "time in which a frame is served",
            "add the longest time that you accept, for example `wake_up: 5 ms`",
        )
    return Link(
        to.value,
        link.value("here"),
        link.value("there"),
        link.value("baud"),
        wake_up or 0,
        link.get("here").mark,
    )


def _check_lines(machines: Machines, report: Report) -> None:
    """Each link has a serial line of its own at both ends."""
    used: dict[tuple[str, str], str] = {}
    for machine in machines.good.values():
        link = machine.link
        if link is None or link.to not in machines.good:
            continue
        for place, device in ((machine, link.here), (machines.good[link.to], link.there)):
            known = {d.name for d in place.board.devices.values() if d.device_class == SERIAL}
            other = used.setdefault((place.name, device), machine.name)
            if device not in known:
                report.error(
                    link.mark,
                    "link-device",
                    f"unknown serial line '{device}' of board '{place.board.name}'",
                    report.nearest(device, sorted(known))
                    or f"{place.board.name} has no serial line",
                )
            elif other != machine.name:
                report.error(
                    link.mark,
                    "link-device",
                    f"serial line '{device}' of '{place.name}' has the link of '{other}' already",
                    "use another line",
                )


def _refuse_unknown(name: str, mark: Mark, known: Iterable[str], report: Report) -> None:
    names = list(known)
    report.error(
        mark,
        "machine-unknown",
        f"unknown machine '{name}'",
        report.nearest(name, names)
        or (
            f"name one of: {', '.join(names)}"
            if names
            else "add `machines` to the graph, for example `machines: {fmu: {board: fmu_v2}}`"
        ),
    )


# --- what may cross ---


def check_machines(
    machines: Machines,
    nodes: dict[str, Node],
    topics: dict[str, Topic],
    modes: Modes | None,
    chains: tuple[Chain, ...],
    report: Report,
) -> None:
    if len(machines.good) < len(machines.declared) or not machines.declared:
        return
    check = _Crossings(machines, nodes, report)
    for topic in topics.values():
        check.topic(topic)
    for node in nodes.values():
        check.line(node)
        check.standby(node)
    for chain in chains:
        check.together(chain.path, f"chain '{chain.name}'", chain.mark)
    for mode, names in ({} if modes is None else modes.sets).items():
        assert modes is not None
        marks = [nodes[name].mark for name in names if name in nodes]
        if marks:
            check.together((modes.publisher, *names), f"mode '{mode}' and its publisher", marks[0])


class _Crossings:
    def __init__(self, machines: Machines, nodes: dict[str, Node], report: Report) -> None:
        self._machines = machines.good
        self._nodes = nodes
        self._report = report

    def topic(self, topic: Topic) -> None:
        places = dict.fromkeys(self._nodes[name].machine for name in topic.publishers)
        if len(places) > 1:
            first, other = topic.publishers[0], topic.publishers[-1]
            self._report.error(
                next(o.mark for o in self._nodes[other].outputs.values() if o.topic == topic.name),
                "topic-machines",
                f"expected all publishers of '{topic.name}' on one machine, found '{first}' on "
                f"'{self._nodes[first].machine}' and '{other}' on '{self._nodes[other].machine}'",
                "give the topics different names",
            )
            return
        home = self._home(topic)
        for name, key in topic.readers:
            if self._nodes[name].machine != home:
                self._crossing(topic, home, self._nodes[name], key)

    def _crossing(self, topic: Topic, home: str, node: Node, key: str) -> None:
        source = node.inputs[key]
        if not self._are_linked(home, node.machine):
            self._report.error(
                source.mark,
                "link-missing",
                f"no link between '{home}', which publishes '{topic.name}', and '{node.machine}', "
                f"where '{node.name}' reads it",
                "add a link between the two, or move one of the nodes",
            )
        if source.max_age_us is None:
            self._report.error(
                source.mark,
                "link-age",
                f"missing `max_age` of input '{key}' of '{node.name}': '{topic.name}' comes from "
                f"'{home}', whose link may fail",
                f"write `{key}: {{topic: {topic.name}, max_age: 200 ms}}`",
            )
        if source.queue:
            self._report.error(
                source.mark,
                "link-queue",
                f"expected input '{key}' of '{node.name}' to read the latest sample of "
                f"'{topic.name}', found `read: queue`: a link carries the newest samples only",
                "remove `read: queue`, or move the node",
            )
        if topic.message.bytes > MAX_BODY:
            self._report.error(
                source.mark,
                "link-body",
                f"expected a message of at most {MAX_BODY} bytes on a link, found "
                f"{topic.message.bytes} bytes in {topic.message.name}",
                "split the message, or move one of the nodes",
            )

    def _home(self, topic: Topic) -> str:
        """The machine that publishes it; of a node with a standby that of the selector."""
        publisher = self._nodes[topic.publishers[0]]
        return publisher.machine if publisher.standby is None else publisher.standby.machine

    def _are_linked(self, one: str, other: str) -> bool:
        ends = ((one, other), (other, one))
        return any((link := self._machines[a].link) is not None and link.to == b for a, b in ends)

    def line(self, node: Node) -> None:
        """A serial line of a link belongs to the link."""
        for machine in self._machines.values():
            link = machine.link
            if link is None or node.device is None:
                continue
            if (node.machine, node.device) in ((machine.name, link.here), (link.to, link.there)):
                self._report.error(
                    node.mark,
                    "link-device",
                    f"device '{node.device}' of '{node.machine}' is the line of the link of "
                    f"'{machine.name}'",
                    f"remove this node, or use another line: {beside(node.mark, link.mark)}",
                )

    def standby(self, node: Node) -> None:
        standby = node.standby
        if standby is None:
            return
        if not self._are_linked(node.machine, standby.machine):
            self._report.error(
                standby.mark,
                "link-missing",
                f"no link between '{node.machine}', where '{node.name}' runs, and its standby on "
                f"'{standby.machine}'",
                "add a link between the two, or name another machine",
            )
        for output in node.outputs.values():
            ages = self.ages(output.topic, standby.machine)
            if standby.max_age_us is None and not ages:
                self._report.error(
                    standby.mark,
                    "standby",
                    f"missing `max_age` of the standby: no reader of '{output.topic}' on "
                    f"'{standby.machine}' has one",
                    f"write `standby: {{machine: {standby.machine}, max_age: 50 ms}}`",
                )

    def ages(self, topic: str, machine: str) -> list[int]:
        return ages_of(self._nodes.values(), topic, machine)

    def together(self, names: tuple[str, ...], what: str, mark: Mark) -> None:
        places = {self._nodes[name].machine: name for name in names if name in self._nodes}
        if len(places) > 1:
            (one, first), (other, second) = list(places.items())[:2]
            self._report.error(
                mark,
                "machine-apart",
                f"expected all nodes of {what} on one machine, found '{first}' on '{one}' and "
                f"'{second}' on '{other}'",
                "move one of them",
            )


def ages_of(nodes: Iterable[Node], topic: str, machine: str) -> list[int]:
    """The `max_age` of the topic's readers on this machine."""
    return [
        source.max_age_us
        for node in nodes
        for source in node.inputs.values()
        if node.machine == machine and source.topic == topic and source.max_age_us is not None
    ]
