"""Reads the nodes of a graph against the interfaces of their apps and device classes."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from difflib import get_close_matches
from typing import TYPE_CHECKING

from stator.diagnostics import Mark, Report, beside
from stator.graph.checks.triggers import TriggerReader
from stator.graph.interfaces import find_app
from stator.graph.model import Board, Budget, Interface, Node, NodeInput, NodeOutput, Value
from stator.graph.value import read_value
from stator.language.keys import PROVENANCES
from stator.language.shapes import Record, items

if TYPE_CHECKING:
    from stator.graph.checks.machines import Machines
    from stator.graph.model import Port
    from stator.graph.sources import Sources
    from stator.language.yaml_tree import Scalar


@dataclass
class Nodes:
    """The nodes that later checks can use, and what later checks must not report, so that one
    mistake gives one error."""

    good: dict[str, Node] = field(default_factory=dict)
    declared: frozenset[str] = frozenset()
    damaged: set[str] = field(default_factory=set)  # nodes with an error in app, inputs or outputs
    # Topics that damaged nodes would publish; None if these are not known.
    doubtful_topics: set[str] | None = field(default_factory=set)

    def may_publish(self, topic: str) -> bool:
        """Whether a damaged node may be the publisher."""
        return self.doubtful_topics is None or topic in self.doubtful_topics


def read_nodes(
    record: Record,
    machines: Machines,
    sources: Sources,
    budgets: dict[str, Budget],
) -> Nodes:
    table = record.get("nodes")
    nodes = Nodes(declared=frozenset(table.keys))
    owners: dict[str, Mark] = {}
    if len(table.values) < len(table.keys):
        nodes.doubtful_topics = None
    for name, value in table.values.items():
        reader = _NodeReader(name, table.keys[name], value, sources)
        machine = machines.of_node(value, sources.report)
        first = machines.is_first(machine)
        node = reader.read(*machines.boards(machine), owners, budgets if first else {})
        if node is not None:
            nodes.good[name] = replace(
                node, machine=machine, standby=machines.standby(value, machine, sources.report)
            )
        if reader.is_damaged:
            nodes.damaged.add(name)
            _doubt_outputs(value, node, nodes)
    _check_priorities(nodes.good, table, sources.report)
    return nodes


def _doubt_outputs(record: Record, node: Node | None, nodes: Nodes) -> None:
    outputs = record.get("outputs")
    if "outputs" not in record.keys or nodes.doubtful_topics is None:
        return
    if outputs is None or len(outputs.values) < len(outputs.keys):
        nodes.doubtful_topics = None
        return
    nodes.doubtful_topics |= {
        leaf.value
        for key, leaf in outputs.values.items()
        if node is None or key not in node.outputs
    }


def _check_priorities(nodes: dict[str, Node], table: Record, report: Report) -> None:
    """All nodes have a priority, or none. The error names the smaller group."""
    given = [node for node in nodes.values() if "priority" in table.values[node.name].keys]
    missing = [node for node in nodes.values() if "priority" not in table.values[node.name].keys]
    if not given or not missing:
        return
    if len(missing) <= len(given):
        for node in missing:
            report.error(
                node.mark,
                "priority-some",
                f"missing priority of '{node.name}': other nodes have one",
                "give all nodes a priority, or none",
            )
    else:
        for node in given:
            report.error(
                table.values[node.name].keys["priority"],
                "priority-some",
                f"'{node.name}' has a priority, and most nodes have none",
                "give all nodes a priority, or none",
            )


class _NodeReader:
    def __init__(self, name: str, mark: Mark, record: Record, sources: Sources) -> None:
        self._name = name
        self._mark = mark
        self._record = record
        self._sources = sources
        self._report = sources.report
        self.is_damaged = False
        # What an included file gives to the app that this file replaced: key -> names, and where.
        self._left_over: dict[str, dict[str, Mark]] = {}

    def read(
        self,
        own: Board | None,
        board: Board | None,
        owners: dict[str, Mark],
        budgets: dict[str, Budget],
    ) -> Node | None:
        interface = self._interface(own, board, owners)
        if interface is None:
            self.is_damaged = True
            return None
        record = self._record
        inputs = self._inputs(interface)
        device = record.get("device")
        triggers = TriggerReader(self._name, interface, record, self._report)
        node = Node(
            name=self._name,
            interface=interface,
            device=None if device is None else device.value,
            triggers=triggers.read([b for b in (own, board) if b is not None]),
            priority=record.value("priority"),
            deadline_us=record.value("deadline"),
            budget=self._budget(budgets),
            inputs=inputs,
            outputs=self._outputs(interface),
            params=self._params(interface),
            mark=self._mark,
        )
        self._tell_left_over(interface)
        return node

    def _budget(self, budgets: dict[str, Budget]) -> Budget | None:
        """What the graph writes goes before what was measured."""
        written = self._record.value("budget")
        return budgets.get(self._name) if written is None else Budget(written, PROVENANCES[0])

    def _interface(
        self, own: Board | None, board: Board | None, owners: dict[str, Mark]
    ) -> Interface | None:
        keys = self._record.keys
        if "device" in keys and "app" in keys:
            self._report.error(
                keys["app"],
                "device-is-not-app",
                "expected `device` or `app`, found both",
                "remove `app`: the board says which driver the device has",
            )
        device, app = self._record.get("device"), self._record.get("app")
        if "device" in keys:
            return (
                None
                if device is None
                else self._device(device.value, device.mark, own, board, owners)
            )
        if "app" in keys:
            return None if app is None else find_app(self._sources, app.value, app.mark)
        return self._app_of_name(own)

    def _app_of_name(self, own: Board | None) -> Interface | None:
        if own is not None and self._name in own.devices and self._name not in self._sources.apps():
            self._report.error(
                self._mark,
                "app-unknown",
                f"unknown app '{self._name}'",
                f"add `device: {self._name}`: '{self._name}' is a device of the board",
            )
            return None
        return find_app(self._sources, self._name, self._mark)

    def _device(
        self, name: str, mark: Mark, own: Board | None, board: Board | None, owners: dict[str, Mark]
    ) -> Interface | None:
        if name in owners:
            self._report.error(
                mark,
                "device-twice",
                f"expected one owner of device '{name}', found two nodes",
                f"first one: {beside(mark, owners[name])}; keep one of them",
            )
        owners.setdefault(name, self._mark)
        for candidate in (own, board):
            if candidate is not None and name not in candidate.devices:
                self._report.error(
                    mark,
                    "device-unknown",
                    f"unknown device '{name}' of board '{candidate.name}'",
                    self._report.nearest(name, candidate.devices),
                )
                return None
        if own is None:
            return None
        device = own.devices[name]
        if board is not None and board.devices[name].device_class != device.device_class:
            self._report.error(
                mark,
                "class-mismatch",
                f"expected class '{device.device_class}' for device '{name}', as on {own.name}, "
                f"found '{board.devices[name].device_class}' on {board.name}",
                f"bind it to a driver of class {device.device_class} in the board.yaml of "
                f"{board.name}",
            )
        return device.interface

    # --- ports ---

    def _inputs(self, interface: Interface) -> dict[str, NodeInput]:
        record = self._record.get("inputs")
        inputs: dict[str, NodeInput] = {}
        taken: dict[str, str] = {}
        for key, value in items(self._record, "inputs"):
            port = self._port(key, record.keys[key], interface.inputs, "input")
            topic = value.get("topic")
            if port is None or topic is None:
                self.is_damaged = True
                continue
            if topic.value in taken:
                self._report.error(
                    topic.mark,
                    "input-twice",
                    f"duplicate topic '{topic.value}': input '{taken[topic.value]}' reads it "
                    "already",
                    "keep one of them",
                )
            taken[topic.value] = key
            inputs[key] = NodeInput(
                port,
                topic.value,
                value.value("max_age"),
                value.value("read") == "queue",
                topic.mark,
            )
        self._check_wired(interface, record)
        # In the order of the interface.
        return {key: inputs[key] for key in interface.inputs if key in inputs}

    def _check_wired(self, interface: Interface, record: Record | None) -> None:
        if "inputs" in self._record.keys and record is None:
            self.is_damaged = True
            return
        written = {} if record is None else record.keys
        unknown = [key for key in written if key not in interface.inputs]
        for key, port in interface.inputs.items():
            if key in written or port.optional or get_close_matches(key, unknown):
                continue
            self._report.error(
                self._mark,
                "input-missing",
                f"missing input '{key}' of '{self._name}'",
                f"add `{key}: TOPIC` to its `inputs`; the message is {port.message.name}",
            )

    def _outputs(self, interface: Interface) -> dict[str, NodeOutput]:
        record = self._record.get("outputs")
        outputs: dict[str, NodeOutput] = {}
        taken: dict[str, str] = {}
        if "outputs" in self._record.keys and (
            record is None or len(record.values) < len(record.keys)
        ):
            self.is_damaged = True
        for key, leaf in items(self._record, "outputs"):
            port = self._port(key, record.keys[key], interface.outputs, "output")
            if port is None:
                self.is_damaged = True
                continue
            if leaf.value in taken:
                self._report.error(
                    leaf.mark,
                    "output-twice",
                    f"duplicate topic '{leaf.value}': output '{taken[leaf.value]}' publishes it "
                    "already",
                    "keep one of them",
                )
                continue
            taken[leaf.value] = key
            outputs[key] = NodeOutput(port, leaf.value, leaf.mark)
        return {key: outputs[key] for key in interface.outputs if key in outputs}

    def _port(self, key: str, mark: Mark, ports: dict[str, Port], what: str) -> Port | None:
        if key in ports:
            return ports[key]
        if self._is_left_over(f"{what}s", key, mark):
            return None
        self._report.error(
            mark,
            "port-unknown",
            f"unknown {what} '{key}' of '{self._name}'",
            self._report.nearest(key, ports) or f"remove it: this node has no {what}s",
        )
        return None

    def _params(self, interface: Interface) -> dict[str, Value]:
        values: dict[str, Value] = {name: p.default for name, p in interface.params.items()}
        record = self._record.get("params")
        given: list[tuple[str, Scalar]] = items(self._record, "params")
        for key, scalar in given:
            if key not in interface.params:
                if self._is_left_over("params", key, record.keys[key]):
                    continue
                self._report.error(
                    record.keys[key],
                    "param-unknown",
                    f"unknown parameter '{key}' of '{self._name}'",
                    self._report.nearest(key, interface.params)
                    or "remove it: this node has no parameters",
                )
                continue
            value = read_value(interface.params[key], scalar, self._report)
            if value is not None:
                values[key] = value
        return values

    # --- an app in place of another one ---

    def _is_left_over(self, kind: str, key: str, mark: Mark) -> bool:
        """Whether another file than the one that names the app has this: the user replaces the app
        of an included node, and need not edit that file."""
        app = self._record.keys.get("app")
        if app is None or app.file == mark.file:
            return False
        self._left_over.setdefault(kind, {})[key] = mark
        return True

    def _tell_left_over(self, interface: Interface) -> None:
        """One error for all, with the text to write."""
        if not self._left_over:
            return
        app = self._record.keys["app"]
        names = ", ".join(
            f"{'parameter' if kind == 'params' else kind[:-1]} '{key}'"
            for kind, keys in self._left_over.items()
            for key in keys
        )
        first = min(mark for keys in self._left_over.values() for mark in keys.values())
        lines = "".join(
            f", {kind}: {{{', '.join(f'{key}: null' for key in keys)}}}"
            for kind, keys in self._left_over.items()
        )
        self._report.error(
            app,
            "port-unknown",
            f"unknown {names} of app '{interface.name}', which {beside(app, first)} gives to "
            f"'{self._name}'",
            f"write `{self._name}: {{app: {interface.name}{lines}}}` in your file",
        )
