"""Checks a graph and freezes it into the model: each step reports all it finds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from stator import language
from stator.check_parts import read_chains, read_modes
from stator.check_topics import connect
from stator.compose import Composer, check_variables
from stator.diagnostics import Mark, Report, nearest
from stator.library import HOME, Library, read_value
from stator.model import Board, Graph, Interface, Node, NodeInput, NodeOutput, Trigger, Value
from stator.shapes import Record, check_name
from stator.yaml_tree import Scalar

if TYPE_CHECKING:
    from stator.model import Port


def check(path: Path, board_name: str | None = None) -> tuple[Graph, Board]:
    """Reads and checks a graph. Returns it, bound to its own board, and the board to build for.

    Raises `Failed` with every error.
    """
    report = Report()
    path = path.resolve()
    composer = Composer(report, (path.parent, HOME / "graph"))
    tree = composer.compose(path)
    if tree is None:
        report.stop_on_errors()
    assert tree is not None
    check_variables(tree, report)
    check_name(path.stem, Mark(path, 1, 1), "a graph's name (its file's)", report)
    record = language.GRAPH.read(tree, report)
    report.stop_on_errors()
    assert record is not None

    library = Library(path.parent, report)
    leaf = record.get("board")
    own = library.board(leaf.value, leaf.mark)
    board = own if board_name is None else library.board(board_name, leaf.mark)
    nodes = _nodes(record, own, board, library, report)
    topics = connect(record, nodes, report)
    modes = read_modes(record, nodes, report)
    chains = read_chains(record, nodes, report)
    report.stop_on_errors()
    assert own is not None
    assert board is not None
    graph = Graph(
        name=path.stem,
        file=path,
        doc=record.value("doc", ""),
        board=own,
        nodes=nodes,
        topics=topics,
        modes=modes,
        chains=chains,
        files=tuple(dict.fromkeys([*composer.files, *library.files])),
    )
    return graph, board


def _nodes(record: Record, own: Board | None, board: Board | None, library: Library,
           report: Report) -> dict[str, Node]:
    nodes: dict[str, Node] = {}
    owners: dict[str, Mark] = {}
    table = record.get("nodes")
    for name, value in table.values.items():
        node = _NodeReader(name, table.keys[name], value, library, report)
        checked = node.read(own, board, owners)
        if checked is not None:
            nodes[name] = checked
    return nodes


class _NodeReader:
    def __init__(self, name: str, mark: Mark, record: Record, library: Library,
                 report: Report) -> None:
        self._name = name
        self._mark = mark
        self._record = record
        self._library = library
        self._report = report

    def read(self, own: Board | None, board: Board | None, owners: dict[str, Mark]) -> Node | None:
        interface = self._interface(own, board, owners)
        if interface is None:
            return None
        record = self._record
        inputs = self._inputs(interface)
        return Node(
            name=self._name,
            interface=interface,
            device=record.value("device"),
            triggers=self._triggers(interface, inputs, own),
            priority=record.value("priority"),
            deadline_us=record.value("deadline"),
            budget_us=record.value("budget"),
            inputs=inputs,
            outputs=self._outputs(interface),
            params=self._params(interface),
            mark=self._mark,
        )

    def _interface(self, own: Board | None, board: Board | None,
                   owners: dict[str, Mark]) -> Interface | None:
        device = self._record.get("device")
        app = self._record.get("app")
        if device is None:
            mark = app.mark if app is not None else self._mark
            return self._library.app(app.value if app is not None else self._name, mark)
        if app is not None:
            self._report.error(app.mark, "device-is-not-app", "a node has `device` or `app`, not "
                               "both", "the board says which driver the device has")
        if device.value in owners:
            self._report.error(device.mark, "device-twice", f"device '{device.value}' has two owners",
                               f"the other one is in line {owners[device.value].line}")
        owners[device.value] = self._mark
        for candidate in (own, board):
            if candidate is not None and device.value not in candidate.devices:
                self._report.error(device.mark, "device-unknown", f"board '{candidate.name}' has no "
                                   f"device '{device.value}'",
                                   nearest(device.value, candidate.devices))
                return None
        if own is None:
            return None
        return self._library.device_class(own.devices[device.value].device_class, device.mark)

    def _inputs(self, interface: Interface) -> dict[str, NodeInput]:
        record = self._record.get("inputs")
        given = {} if record is None else record.values
        inputs: dict[str, NodeInput] = {}
        topics: dict[str, str] = {}
        for key, value in given.items():
            port = self._port(key, record.keys[key], interface.inputs, "input")
            topic = value.get("topic")
            if port is None or topic is None:
                continue
            if topic.value in topics:
                self._report.error(topic.mark, "input-twice", f"topic '{topic.value}' is on input "
                                   f"'{topics[topic.value]}' already", "remove one of the two")
            topics[topic.value] = key
            inputs[key] = NodeInput(port, topic.value, value.value("max_age"),
                                    value.value("read") == "queue", topic.mark)
        for key, port in interface.inputs.items():
            if key not in given and not port.optional:
                self._report.error(self._mark, "input-missing",
                                   f"input '{key}' of '{self._name}' is not wired",
                                   f"add `inputs: {{{key}: TOPIC}}`, a topic of {port.message.name}")
        # In the interface's order, whatever the graph's.
        return {key: inputs[key] for key in interface.inputs if key in inputs}

    def _outputs(self, interface: Interface) -> dict[str, NodeOutput]:
        record = self._record.get("outputs")
        given = {} if record is None else record.values
        outputs: dict[str, NodeOutput] = {}
        topics: dict[str, str] = {}
        for key, leaf in given.items():
            port = self._port(key, record.keys[key], interface.outputs, "output")
            if port is None:
                continue
            if leaf.value in topics:
                self._report.error(leaf.mark, "output-twice", f"topic '{leaf.value}' is on output "
                                   f"'{topics[leaf.value]}' already", "remove one of the two")
            topics[leaf.value] = key
            outputs[key] = NodeOutput(port, leaf.value, leaf.mark)
        return {key: outputs[key] for key in interface.outputs if key in outputs}

    def _port(self, key: str, mark: Mark, ports: dict[str, Port], what: str) -> Port | None:
        if key in ports:
            return ports[key]
        self._report.error(mark, "port-unknown", f"'{self._name}' has no {what} '{key}'",
                           nearest(key, ports) or f"it has no {what}s")
        return None

    def _params(self, interface: Interface) -> dict[str, Value]:
        values: dict[str, Value] = {name: p.default for name, p in interface.params.items()}
        record = self._record.get("params")
        given: dict[str, Scalar] = {} if record is None else record.values
        for key, scalar in given.items():
            if key not in interface.params:
                self._report.error(record.keys[key], "param-unknown",
                                   f"'{self._name}' has no parameter '{key}'",
                                   nearest(key, interface.params) or "it has no parameters")
                continue
            value = read_value(interface.params[key], scalar, self._report)
            if value is not None:
                values[key] = value
        return values

    # --- triggers ---

    def _triggers(self, interface: Interface, inputs: dict[str, NodeInput],
                  own: Board | None) -> tuple[Trigger, ...]:
        leaf = self._record.get("trigger")
        if leaf is None:
            return ()
        triggers: list[Trigger] = []
        for record in leaf.value:
            trigger = self._trigger(record)
            if trigger is None:
                continue
            same = [t for t in triggers if (t.kind, t.name, t.period_us, t.offset_us)
                    == (trigger.kind, trigger.name, trigger.period_us, trigger.offset_us)]
            if same:
                self._report.error(record.mark, "trigger-twice", "the same trigger twice",
                                   f"the other one is in line {same[0].mark.line}")
                continue
            self._check_trigger(trigger, record, interface, inputs, own)
            triggers.append(trigger)
        return tuple(triggers)

    def _trigger(self, record: Record) -> Trigger | None:
        kinds = [kind for kind in ("irq", "topic", "every") if kind in record.keys]
        if len(kinds) != 1:
            self._report.error(record.mark, "trigger-kind", "a trigger is exactly one of irq, topic, "
                               f"every; this one has {', '.join(kinds) or 'none'}",
                               "write several triggers as a list" if kinds else
                               "for example {every: 10 ms}")
            return None
        kind = kinds[0]
        if record.get(kind) is None:
            return None
        belongs = {"min_interarrival": "irq", "min_interval": "topic", "offset": "every"}
        for key, owner in belongs.items():
            if key in record.keys and owner != kind:
                self._report.error(record.keys[key], "trigger-key", f"'{key}' goes with {owner}, not "
                                   f"with {kind}", nearest(key, [k for k, o in belongs.items()
                                                                 if o == kind]))
        period = record.value("every", 0)
        offset = record.value("offset", 0)
        if kind == "every" and offset >= period:
            self._report.error(record.get("offset").mark, "offset-range", f"offset {offset} us does "
                               f"not lie within the period of {period} us")
        return Trigger(
            kind=kind,
            name="" if kind == "every" else record.value(kind),
            mark=record.get(kind).mark,
            min_interarrival_us=record.value("min_interarrival"),
            min_interval_us=record.value("min_interval"),
            period_us=period,
            offset_us=offset,
            max_interval_us=record.value("max_interval"),
        )

    def _check_trigger(self, trigger: Trigger, record: Record, interface: Interface,
                       inputs: dict[str, NodeInput], own: Board | None) -> None:
        if trigger.kind == "irq":
            self._check_line(trigger, interface, own)
        if trigger.kind != "topic":
            return
        source = next((i for i in inputs.values() if i.topic == trigger.name), None)
        if source is None:
            self._report.error(trigger.mark, "trigger-not-input",
                               f"topic '{trigger.name}' is none of the inputs of '{self._name}'",
                               nearest(trigger.name, [i.topic for i in inputs.values()])
                               or "wire it to an input first")
        elif source.queue:
            key = record.get("topic").mark
            what = "thinned input is latest" if trigger.is_thinned else \
                "trigger input is read in order already"
            self._report.error(key, "thinned-queue", f"a {what}",
                               f"remove `read: queue` from input '{source.port.name}'")

    def _check_line(self, trigger: Trigger, interface: Interface, own: Board | None) -> None:
        device = self._record.get("device")
        if device is None:
            self._report.error(trigger.mark, "irq-needs-device",
                               f"'{self._name}' owns no device, so it has no lines",
                               "only a node with `device` does input and output")
            return
        if trigger.name not in interface.lines:
            self._report.error(trigger.mark, "line-unknown",
                               f"device class '{interface.name}' has no line '{trigger.name}'",
                               nearest(trigger.name, interface.lines) or "it has no lines")
            return
        if own is not None and own.chip is not None:
            wired = own.devices[device.value].lines
            if trigger.name not in wired:
                self._report.error(trigger.mark, "line-not-on-board", f"board '{own.name}' does not "
                                   f"wire line '{trigger.name}' of '{device.value}'",
                                   nearest(trigger.name, wired)
                                   or f"add it to `lines` in {own.file.name}")
