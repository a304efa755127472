"""Cuts a graph at its links: what crosses them travels through generated nodes, and readers on
another machine read a copy of the topic that the generated receiver publishes.

Topic T is, on machine M, `T_on_M`. Of a node with a standby, T is what the selector publishes;
`T_by_M` is what the instance on machine M publishes.
"""

from __future__ import annotations

import json
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import Report
from stator.graph.checks.machines import ages_of
from stator.graph.interfaces import find_device_class
from stator.graph.messages import find_message
from stator.graph.model import (
    Bridge,
    BridgeTopic,
    Device,
    Interface,
    Node,
    NodeInput,
    NodeOutput,
    Port,
    Topic,
    TopicConfig,
    Trigger,
    Wire,
)
from stator.graph.sources import Sources
from stator.plan.rates import Rates

if TYPE_CHECKING:
    from collections.abc import Iterable

    from stator.diagnostics import Mark
    from stator.graph.model import Board, Graph, Link, Message

HELLO_PERIOD_US = 100_000
LINK_DRIVER = "link/line"
STATUS_TOPIC = "vehicle_status"
STATUS_MESSAGE = "VehicleStatus"
_NO_CONFIG = TopicConfig(None, None, False, None)


def join(graph: Graph, board: Board) -> tuple[Graph, Board]:
    """All machines in one program, with their links between them; and the board that it is for.
    Levels are those of the graph; in virtual time an activation takes no time, so that no machine
    waits for another."""
    return _Cut(graph).joined(board)


@dataclass(frozen=True)
class _Crossing:
    """A topic on one direction of a link."""

    topic: str
    message: Message
    max_age_us: int
    every_us: int | None
    period_us: Fraction | None
    urgency: tuple[int, int, int]  # the smallest first
    mark: Mark


class _Cut:
    def __init__(self, graph: Graph) -> None:
        self._graph = graph
        self._sources = Sources(graph.file.parent, Report())
        self._periods = {name: Rates(graph).topic(name) for name in graph.topics}
        self._nodes: dict[str, Node] = {}
        self._configs = {name: topic.config for name, topic in graph.topics.items()}

    def joined(self, board: Board) -> tuple[Graph, Board]:
        graph = self._graph
        for node in graph.nodes.values():
            self._add_with_standby(node)
        wires = []
        devices: dict[str, Device] = {}
        for machine in graph.machines.values():
            if machine.link is not None:
                wire = self._add_link(machine.name, machine.link, devices)
                wires.append(wire)
        own = replace(graph.board, chip=None, devices=graph.board.devices | devices)
        bound = own
        if board.name != graph.board.name:
            bound = replace(board, devices=board.devices | devices)
        nodes = {node.name: node for node in self._nodes.values()}
        cut = replace(
            graph,
            board=own,
            nodes=nodes,
            topics=self._topics(nodes.values()),
            wires=tuple(wires),
            files=tuple(dict.fromkeys([*graph.files, *self._sources.files])),
        )
        return cut, bound

    # --- standby ---

    def _add_with_standby(self, node: Node) -> None:
        standby = node.standby
        if standby is None:
            self._nodes[node.name] = node
            return
        self._nodes[node.name] = _by(node, node.name, node.machine)
        copy = f"{node.name}_standby"
        self._nodes[copy] = replace(_by(node, copy, standby.machine), machine=standby.machine)
        self._nodes[f"{node.name}_selector"] = self._selector(node)

    def _selector(self, node: Node) -> Node:
        standby, mark = node.standby, node.mark
        assert standby is not None
        ages = {
            key: standby.max_age_us
            or min(ages_of(self._graph.nodes.values(), output.topic, standby.machine))
            for key, output in node.outputs.items()
        }
        wired: dict[str, NodeInput] = {}
        for key, output in node.outputs.items():
            message = output.port.message
            for name, machine in ((key, node.machine), (f"{key}_standby", standby.machine)):
                doc = f"What {node.name} on {machine} publishes."
                topic = f"{output.topic}_by_{machine}"
                age = ages[key] if name == key else None
                wired[name] = _reads(name, message, topic, age, doc, output.mark)
        status = self._graph.topics.get(STATUS_TOPIC)
        triggers = [_on_topic(source.topic, None, mark) for source in wired.values()]
        if status is not None and status.message.name == STATUS_MESSAGE:
            doc = "Whether the vehicle is armed."
            wired["status"] = _reads("status", status.message, STATUS_TOPIC, None, doc, mark)
        outputs = {
            f"{key}_chosen": _publishes(
                f"{key}_chosen", output.port.message, output.topic, "Of the one that acts.", mark
            )
            for key, output in node.outputs.items()
        }
        outputs["selection"] = self._status("selection", "StandbyStatus", node.name, mark)
        bridge = Bridge(
            "selector",
            node.name,
            tuple(
                BridgeTopic(f"{key}_chosen", o.port.message, ages[key], self._periods[o.topic])
                for key, o in node.outputs.items()
            ),
            "",
        )
        own = f"{node.name}_selector"
        return replace(
            node,
            name=own,
            interface=_interface(own, bridge, wired, outputs, {}),
            triggers=(*triggers, _every(HELLO_PERIOD_US, mark)),
            inputs=wired,
            outputs=outputs,
            params={},
            budget=None,
            machine=standby.machine,
            standby=None,
        )

    def _status(self, port: str, message: str, of: str, mark: Mark) -> NodeOutput:
        found = find_message(self._sources, message, mark)
        assert found is not None
        return _publishes(port, found, f"{of}_{port}", found.doc, mark)

    # --- links ---

    def _add_link(self, machine: str, link: Link, devices: dict[str, Device]) -> Wire:
        interface = find_device_class(self._sources, "link", link.mark)
        assert interface is not None
        ends = {}
        for one, other in ((machine, link.to), (link.to, machine)):
            ends[one] = f"{one}_{other}_link"
            devices[ends[one]] = Device(
                ends[one], LINK_DRIVER, "link", dict.fromkeys(interface.lines, ()), "", interface
            )
        pairs = ((machine, link.to), (link.to, machine))
        directions = {pair: self._crossings(*pair) for pair in pairs}
        cut = self._cut_text(machine, link, directions)
        for (here, there), crossings in directions.items():
            self._add_sender(here, there, ends[here], crossings, cut)
            self._add_receiver(there, here, ends[there], crossings, cut)
        return Wire(ends[machine], ends[link.to], machine, link)

    def _crossings(self, here: str, there: str) -> list[_Crossing]:
        """What `there` reads of `here`, most urgent first."""
        found = []
        homes = {o.topic: n.machine for n in self._nodes.values() for o in n.outputs.values()}
        for place, (topic, home) in enumerate(homes.items()):
            readers = [
                (node, source)
                for node in self._nodes.values()
                for source in node.inputs.values()
                if home == here and node.machine == there and source.topic == topic
            ]
            if not readers:
                continue
            config = self._configs.get(_stem(topic, self._configs), _NO_CONFIG)
            levels = [node.priority for node, _ in readers if node.priority is not None]
            level = config.link_priority or max(levels, default=0)
            deadline = min((n.deadline_us for n, _ in readers if n.deadline_us), default=1 << 40)
            ages = [source.max_age_us for _, source in readers if source.max_age_us is not None]
            period = self._periods.get(_stem(topic, self._configs))
            every = config.link_every_us
            if period is not None and every is not None:
                period = max(period, Fraction(every))
            source = readers[0][1]
            found.append(
                _Crossing(
                    topic,
                    source.port.message,
                    max(ages, default=1 << 31),
                    every,
                    period or (None if every is None else Fraction(every)),
                    (-level, deadline, place),
                    source.mark,
                )
            )
        return sorted(found, key=lambda crossing: crossing.urgency)

    def _cut_text(
        self, machine: str, link: Link, directions: dict[tuple[str, str], list[_Crossing]]
    ) -> str:
        """What both ends of a link must have in common."""
        return json.dumps(
            [
                self._graph.name,
                machine,
                link.to,
                [
                    [pair, [[c.topic, c.max_age_us, c.every_us, layout(c.message)] for c in row]]
                    for pair, row in directions.items()
                ],
            ],
            separators=(",", ":"),
        )

    def _add_sender(
        self, here: str, there: str, device: str, crossings: list[_Crossing], cut: str
    ) -> None:
        name, mark = f"{here}_{there}_sender", self._graph.machines[here].mark
        inputs = {
            c.topic: _reads(c.topic, c.message, c.topic, None, f"To {there}.", mark)
            for c in crossings
        }
        publishers = [n for n in self._nodes.values() if n.machine == here]
        own = [n for n in publishers if any(o.topic in inputs for o in n.outputs.values())]
        bridge = _bridge("sender", here, there, crossings, cut)
        interface = _interface(name, bridge, inputs, {}, {"sent": "The frame has gone out."})
        self._nodes[name] = Node(
            name=name,
            interface=interface,
            device=device,
            triggers=(
                *(_on_topic(c.topic, c.every_us, mark) for c in crossings),
                _on_line("sent", mark),
                _every(HELLO_PERIOD_US, mark),
            ),
            priority=self._priority(own),
            deadline_us=self._deadline_us(own),
            budget=None,
            inputs=inputs,
            outputs={},
            params={},
            mark=mark,
            machine=here,
        )

    def _add_receiver(
        self, here: str, there: str, device: str, crossings: list[_Crossing], cut: str
    ) -> None:
        """Readers of this machine get the copies of the topics."""
        name, mark = f"{here}_{there}_receiver", self._graph.machines[here].mark
        topics = {c.topic: f"{c.topic}_on_{here}" for c in crossings}
        readers = [
            node
            for node in self._nodes.values()
            if node.machine == here and any(i.topic in topics for i in node.inputs.values())
        ]
        for node in readers:
            self._nodes[node.name] = _reading(node, topics)
        outputs = {
            c.topic: _publishes(c.topic, c.message, topics[c.topic], f"From {there}.", c.mark)
            for c in crossings
        }
        status = self._status("link_status", "LinkStatus", f"{here}_{there}", mark)
        outputs["link_status"] = status
        for topic, copy in topics.items():
            config = self._configs.get(_stem(topic, self._configs), _NO_CONFIG)
            self._configs[copy] = replace(config, depth=None, many_publishers=False)
        bridge = _bridge("receiver", here, there, crossings, cut)
        interface = _interface(name, bridge, {}, outputs, {"received": "Bytes have come."})
        self._nodes[name] = Node(
            name=name,
            interface=interface,
            device=device,
            triggers=(_on_line("received", mark), _every(HELLO_PERIOD_US, mark)),
            priority=self._priority(readers),
            deadline_us=self._deadline_us(readers),
            budget=None,
            inputs={},
            outputs=outputs,
            params={},
            mark=mark,
            machine=here,
        )

    @property
    def _has_priorities(self) -> bool:
        return any(node.priority is not None for node in self._graph.nodes.values())

    def _priority(self, others: list[Node]) -> int | None:
        """A generated node is as urgent as the most urgent one at its end of the topics."""
        levels = [node.priority for node in others if node.priority is not None]
        return max(levels, default=1) if self._has_priorities else None

    def _deadline_us(self, others: list[Node]) -> int | None:
        deadlines = [node.deadline_us for node in others if node.deadline_us is not None]
        return None if self._has_priorities else min(deadlines, default=HELLO_PERIOD_US)

    # --- the whole ---

    def _topics(self, nodes: Iterable[Node]) -> dict[str, Topic]:
        publishers: dict[str, list[str]] = {}
        readers: dict[str, list[tuple[str, str]]] = {}
        messages: dict[str, Message] = {}
        for node in nodes:
            for output in node.outputs.values():
                publishers.setdefault(output.topic, []).append(node.name)
                messages[output.topic] = output.port.message
            for key, source in node.inputs.items():
                readers.setdefault(source.topic, []).append((node.name, key))
        return {
            name: Topic(
                name,
                messages[name],
                tuple(names),
                tuple(readers.get(name, ())),
                self._configs.get(name, _NO_CONFIG),
            )
            for name, names in publishers.items()
        }


def layout(message: Message) -> list[list[str | int | None]]:
    return [[field.name, field.type, field.count] for field in message.fields]


def _stem(topic: str, known: dict[str, TopicConfig]) -> str:
    """The topic of the graph that this one carries: `T` of `T_by_M`."""
    return topic if topic in known else topic.rpartition("_by_")[0]


def _by(node: Node, name: str, machine: str) -> Node:
    """An instance of a node with a standby."""
    outputs = {
        key: replace(output, topic=f"{output.topic}_by_{machine}")
        for key, output in node.outputs.items()
    }
    return replace(node, name=name, outputs=outputs, standby=None)


def _reading(node: Node, topics: dict[str, str]) -> Node:
    inputs = {
        key: replace(source, topic=topics.get(source.topic, source.topic))
        for key, source in node.inputs.items()
    }
    triggers = tuple(
        replace(t, name=topics.get(t.name, t.name)) if t.kind == "topic" else t
        for t in node.triggers
    )
    return replace(node, inputs=inputs, triggers=triggers)


def _bridge(kind: str, here: str, there: str, crossings: list[_Crossing], cut: str) -> Bridge:
    topics = tuple(BridgeTopic(c.topic, c.message, c.max_age_us, c.period_us) for c in crossings)
    return Bridge(kind, f"{here}_{there}", topics, cut)


def _interface(
    name: str,
    bridge: Bridge,
    inputs: dict[str, NodeInput],
    outputs: dict[str, NodeOutput],
    lines: dict[str, str],
) -> Interface:
    what = {
        "sender": "Sends topics to another machine.",
        "receiver": "Publishes what comes from another machine.",
        "selector": f"Chooses between {bridge.link} on another machine and its standby here.",
    }
    return Interface(
        name=name,
        file=HOME / "drivers" / "link" / "link.yaml",
        doc=what[bridge.kind],
        lines=lines,
        inputs={key: source.port for key, source in inputs.items()},
        outputs={key: output.port for key, output in outputs.items()},
        params={},
        reads_log=False,
        reads_graph=False,
        publishes_params=False,
        reads_metadata=False,
        needs_timer=False,
        double_precision="",
        failsafe=None,
        params_message=None,
        bridge=bridge,
    )


def _reads(
    port: str, message: Message, topic: str, age: int | None, doc: str, mark: Mark
) -> NodeInput:
    return NodeInput(
        Port(port, message, optional=False, burst=1, min_interval_us=0, doc=doc),
        topic,
        age,
        queue=False,
        mark=mark,
    )


def _publishes(port: str, message: Message, topic: str, doc: str, mark: Mark) -> NodeOutput:
    made = Port(port, message, optional=False, burst=1, min_interval_us=0, doc=doc)
    return NodeOutput(made, topic, mark)


def _on_topic(topic: str, every_us: int | None, mark: Mark) -> Trigger:
    return Trigger("topic", topic, mark, min_interval_us=every_us)


def _on_line(line: str, mark: Mark) -> Trigger:
    return Trigger("irq", line, mark)


def _every(period_us: int, mark: Mark) -> Trigger:
    return Trigger("every", "", mark, period_us=period_us)
