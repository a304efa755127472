"""No two things of a graph may get the same name in the generated C++."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator.diagnostics import Mark, beside
from stator.names import upper_camel

if TYPE_CHECKING:
    from stator.diagnostics import Report
    from stator.graph.model import Board, Interface, Message, Node, Topic


def check_generated_names(
    nodes: dict[str, Node], topics: dict[str, Topic], board: Board, report: Report
) -> None:
    messages, headers, ports = _Names(report), _Names(report), _Names(report)
    scopes: dict[str, _Names] = {}  # an app or a device class sees its own names and its messages
    for node in nodes.values():
        interface, mark = node.interface, node.mark
        kind = f"the {'app' if node.device is None else 'device class'} '{interface.name}'"
        scope = scopes.get(kind)
        if scope is None:
            scope = scopes[kind] = _Names(report)
            scope.add(f"{interface.class_name}Ports", f"the ports of {kind}", mark)
            ports.add(f"{interface.class_name}Ports", f"the ports of {kind}", mark)
            for message in _messages(interface):
                what = f"the message {message.name}"
                if message is interface.params_message:
                    what = f"the parameters of {kind}"
                scope.add(message.name, what, mark)
                if messages.add(message.name, what, mark):
                    headers.add(message.header, what, mark)
        if node.device is None:
            scope.add(interface.class_name, kind, mark)
        elif board.devices[node.device].driver != "none":
            driver = board.devices[node.device].driver
            scope.add(upper_camel(driver.replace("/", "_")), f"the driver '{driver}'", mark)
    for topic in topics.values():
        stem = topic.name.removesuffix("_storage")
        if stem != topic.name and stem in topics:
            outputs = nodes[topic.publishers[0]].outputs.values()
            mark = next(output.mark for output in outputs if output.topic == topic.name)
            report.error(
                mark,
                "name-clash",
                f"topic '{topic.name}' and the storage of topic '{stem}' would have the same "
                "name in C++",
                f"rename topic '{topic.name}'",
            )


def _messages(interface: Interface) -> list[Message]:
    ports = [*interface.inputs.values(), *interface.outputs.values()]
    own = [] if interface.params_message is None else [interface.params_message]
    return [*(port.message for port in ports), *own]


class _Names:
    """The names so far, and what has each one."""

    def __init__(self, report: Report) -> None:
        self._report = report
        self._taken: dict[str, tuple[str, Mark]] = {}

    def add(self, name: str, what: str, mark: Mark) -> bool:
        """False if something else has the name."""
        other, first = self._taken.setdefault(name, (what, mark))
        if other == what:
            return True
        where = "" if first == mark else f"; the other one: {beside(mark, first)}"
        self._report.error(
            mark,
            "name-clash",
            f"{what} and {other} would both be called {name} in C++",
            f"rename one of them{where}",
        )
        return False
