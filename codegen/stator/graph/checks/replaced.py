"""A message or a device class beside the graph replaces Stator's of the same name.

Stator's own code must still compile with it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import Mark, Report
from stator.graph.interfaces import find_device_class
from stator.graph.messages import find_message
from stator.graph.sources import Sources

if TYPE_CHECKING:
    from collections.abc import Iterable

    from stator.graph.model import Board, Field, Interface, Message, Node


def check_replaced(nodes: Iterable[Node], board: Board, sources: Sources, report: Report) -> None:
    stators = Sources(HOME, Report())
    for user, interface in _code_of_stator(nodes, board, sources, stators):
        for port in (*interface.inputs.values(), *interface.outputs.values()):
            message = port.message
            if stators.messages().get(message.name, message.mark.file) != message.mark.file:
                _check_message(message, user, stators, report)


def _code_of_stator(
    nodes: Iterable[Node], board: Board, sources: Sources, stators: Sources
) -> Iterable[tuple[str, Interface]]:
    """Apps and drivers whose code is Stator's: what they are, and the interface that they get."""
    for node in nodes:
        if node.device is None and stators.apps().get(node.interface.name) == node.interface.file:
            yield f"app {node.interface.name}", node.interface
    for device in board.devices.values():
        file = stators.drivers().get(device.driver)
        if device.interface is None or file is None or sources.drivers()[device.driver] != file:
            continue
        if stators.classes()[device.device_class] != device.interface.file:
            _check_class(device.interface, f"driver {device.driver}", stators, sources.report)
        yield f"driver {device.driver}", device.interface


def _check_message(message: Message, user: str, stators: Sources, report: Report) -> None:
    original = find_message(stators, message.name, message.mark)
    assert original is not None
    missing = _first_missing(original.fields, message.fields)
    if missing is None:
        return
    found = next((field for field in message.fields if field.name == missing.name), None)
    report.error(
        message.mark,
        "message-replaced",
        f"expected the field '{missing.name}' of Stator's {message.name}, which {user} uses, "
        f"found {'none' if found is None else 'one of another type or in another place'}",
        "rename the file; or keep all fields of Stator's message, in their order, and add others",
    )


def _first_missing(expected: Iterable[Field], found: Iterable[Field]) -> Field | None:
    """Code writes fields by name, in their order: further fields between them do no harm."""
    rest = iter(found)
    for field in expected:
        if not field.name.startswith("_padding") and not any(_is_same(field, f) for f in rest):
            return field
    return None


def _is_same(a: Field, b: Field) -> bool:
    return (a.name, a.type, a.count, a.unit, a.values) == (
        b.name,
        b.type,
        b.count,
        b.unit,
        b.values,
    )


def _check_class(interface: Interface, user: str, stators: Sources, report: Report) -> None:
    mark = Mark(interface.file, 1, 1)
    original = find_device_class(stators, interface.name, mark)
    assert original is not None
    found = _ports(interface)
    for what, message in _ports(original).items():
        if found.get(what) != message:
            report.error(
                mark,
                "class-replaced",
                f"expected the {what} of Stator's device class {interface.name}, which {user} "
                f"uses, found {'another type' if what in found else 'none'}",
                "rename the class; or keep all that Stator's has, and add to it",
            )
            return


def _ports(interface: Interface) -> dict[str, str]:
    """What each port, line and parameter is called, and its message or type."""
    return {
        **{f"input '{name}'": port.message.name for name, port in interface.inputs.items()},
        **{f"output '{name}'": port.message.name for name, port in interface.outputs.items()},
        **{f"line '{name}'": "" for name in interface.lines},
        **{f"parameter '{name}'": param.type for name, param in interface.params.items()},
    }
