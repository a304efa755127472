"""Reads the interface of an app or of a device class: its ports, lines and parameters."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

from stator.diagnostics import Mark
from stator.graph.failsafe import STATUS, read_failsafe
from stator.graph.messages import find_message, pad
from stator.graph.model import Failsafe, Field, Interface, Message, Param, Port
from stator.graph.value import read_value
from stator.graph.vehicle import values_of
from stator.language import keys as language
from stator.language.shapes import Leaf, Record, items
from stator.names import upper_camel
from stator.quantities import shown

if TYPE_CHECKING:
    from collections.abc import Set
    from pathlib import Path

    from stator.diagnostics import Report
    from stator.graph.model import Value
    from stator.graph.sources import Sources


# Keys that add a port to the node, and the name of that port.
GIVEN_PORTS = {
    "reads_log": "log",
    "reads_graph": "graph",
    "publishes_params": "parameters",
    "reads_metadata": "metadata",
}


def read_interface(sources: Sources, name: str, path: Path, *, is_app: bool) -> Interface | None:
    report = sources.report
    count = len(report)
    record = sources.read(path, language.INTERFACE)
    if record is None:
        return None
    if is_app and "lines" in record.keys:
        report.error(
            record.keys["lines"],
            "irq-needs-device",
            "unknown key 'lines': only a device class has lines",
            "remove the key; write a driver in drivers/ for input and output",
        )
    if record.value("publishes_params", False):
        _check_params_publisher(record, report, is_app=is_app)
    inputs, outputs = _ports(sources, record, "inputs"), _ports(sources, record, "outputs")
    _check_names(record, outputs, report)
    params = {
        key: param
        for key, value in items(record, "params")
        if (param := _param(key, value, sources)) is not None
    }
    whole = {name for name, param in params.items() if param.type == "int32"}
    failsafe = _failsafe(sources, record, path, whole)
    if len(report) > count or any(
        key in record.keys and record.get(key) is None
        for key in ("lines", "inputs", "outputs", "params")
    ):
        return None  # its ports are not all known; the errors are reported
    return Interface(
        name=name,
        file=path,
        doc=record.value("doc", ""),
        lines={key: value.value("doc", "") for key, value in items(record, "lines")},
        inputs=inputs,
        outputs=outputs,
        params=params,
        reads_log=record.value("reads_log", False),
        reads_graph=record.value("reads_graph", False),
        publishes_params=record.value("publishes_params", False),
        reads_metadata=record.value("reads_metadata", False),
        needs_timer=record.value("needs_timer", False),
        double_precision=record.value("double_precision", ""),
        failsafe=failsafe,
        params_message=params_message(name, params, Mark(path, 1, 1)),
    )


def _check_params_publisher(record: Record, report: Report, *, is_app: bool) -> None:
    """A replay must run this node, and it runs neither drivers nor observers."""
    is_observer = record.value("reads_log", False) or record.value("reads_graph", False)
    if not is_app or is_observer:
        report.error(
            record.keys["publishes_params"],
            "params-publisher",
            "expected an app that reads neither the log nor the graph, found "
            + ("one that does" if is_app else "a device class"),
            "move the key `publishes_params` to an app of its own",
        )


def _failsafe(sources: Sources, record: Record, path: Path, params: Set[str]) -> Failsafe | None:
    leaf = record.get("failsafe")
    status = None if leaf is None else find_message(sources, STATUS, leaf.mark)
    if leaf is None or status is None:
        return None
    return read_failsafe(sources, path.parent / leaf.value, status, params)


def _ports(sources: Sources, record: Record, key: str) -> dict[str, Port]:
    ports = {}
    for name, value in items(record, key):
        leaf = value.get("message")
        message = None if leaf is None else find_message(sources, leaf.value, leaf.mark)
        if message is not None:
            ports[name] = Port(
                name=name,
                message=message,
                optional=value.value("optional", False),
                burst=value.value("burst", 1),
                min_interval_us=value.value("min_interval", 0),
                doc=value.value("doc", ""),
            )
    return ports


def _check_names(record: Record, outputs: dict[str, Port], report: Report) -> None:
    """Inputs and outputs become members of one struct."""
    inputs = record.get("inputs")
    for name in outputs:
        if inputs is not None and name in inputs.keys:
            report.error(
                record.get("outputs").keys[name],
                "name-clash",
                f"input and output have the same name '{name}'",
                "rename one of them",
            )
    for key, port in GIVEN_PORTS.items():
        for table in (inputs, record.get("outputs")):
            if table is not None and record.value(key, False) and port in table.keys:
                report.error(
                    table.keys[port],
                    "name-clash",
                    f"'{port}' is also the port that `{key}` adds",
                    "rename this one",
                )


def _param(name: str, record: Record, sources: Sources) -> Param | None:
    report = sources.report
    type_name, default = record.value("type"), record.get("default")
    if type_name is None or not _has_default(record, report):
        return None
    unit, doc = record.value("unit", "1"), record.value("doc", "")
    param = Param(
        name,
        type_name,
        unit,
        None,
        None,
        0,
        doc,
        is_fixed=record.value("fixed", False),
        in_flight=record.value("in_flight", True),
        id=record.value("id", ""),
        was=tuple(leaf.value for leaf in record.value("was", [])),
        values=tuple((key, leaf.value) for key, leaf in items(record, "values")),
        flags=tuple(leaf.value for leaf in record.value("flags", [])),
    )
    for key in ("values", "flags"):
        if key in record.keys and type_name != "int32":
            report.error(
                record.keys[key],
                "wrong-type",
                f"expected type int32 for a parameter with `{key}`, found '{type_name}'",
                f"write `type: int32`, or remove `{key}`",
            )
            return None
    bounds = _bounds_of_names(param)
    written = record.get("range")
    if written is not None:
        values = [read_value(param, item, report, in_file=True) for item in written.value]
        bounds = [None if value is None else Fraction(value) for value in values]
    least, most = bounds if len(bounds) == 2 else (None, None)
    if least is not None and most is not None and least > most:
        report.error(
            written.mark,
            "out-of-range",
            "expected the lower bound first, found the higher one",
            "swap the two bounds",
        )
        return None
    param = replace(param, least=least, most=most)
    value = (
        _of_vehicle(param, record.get("vehicle"), sources)
        if default is None
        else read_value(param, default, report, in_file=True)
    )
    return None if value is None else replace(param, default=value)


def _bounds_of_names(param: Param) -> list[Fraction | None]:
    """Of a parameter whose interface writes no range."""
    if param.flags:
        return [Fraction(0), Fraction(2 ** len(param.flags) - 1)]
    numbers = [Fraction(number) for _, number in param.values]
    return [min(numbers), max(numbers)] if numbers else [None, None]


def _has_default(record: Record, report: Report) -> bool:
    """A value of its own, or one of the vehicle."""
    count = sum(key in record.keys for key in ("default", "vehicle"))
    if count == 1:
        return record.get("default") is not None or record.get("vehicle") is not None
    report.error(
        record.owner,
        "missing-key" if count == 0 else "name-clash",
        "missing key 'default'" if count == 0 else "expected `default` or `vehicle`, found both",
        "add `default`: the value if the graph gives none" if count == 0 else "remove one of them",
    )
    return False


def _of_vehicle(param: Param, leaf: Leaf, sources: Sources) -> Value | None:
    known = values_of(sources)
    if leaf.value not in known:
        sources.report.error(
            leaf.mark,
            "vehicle-value",
            f"unknown value '{leaf.value}' of a vehicle",
            sources.report.nearest(leaf.value, known),
        )
        return None
    value = known[leaf.value]
    least, most = param.least, param.most
    if (least is None or least <= value) and (most is None or value <= most):
        return int(value) if param.type == "int32" else value
    sources.report.error(
        leaf.mark,
        "param-range",
        f"expected a value from {shown(least or value)} to {shown(most or value)} for "
        f"'{param.name}', found {shown(value)}, the {leaf.value} of vehicle '{sources.vehicle}'",
        "change the vehicle or the range",
    )
    return None


def params_message(app: str, params: dict[str, Param], mark: Mark) -> Message | None:
    """The message that carries the parameters of an app."""
    if not params:
        return None
    fields = [Field(p.name, p.type, None, p.unit, "", (), p.doc) for p in params.values()]
    return Message(upper_camel(app) + "Params", f"Parameters of {app}.", pad(fields), mark)


def find_app(sources: Sources, name: str, mark: Mark) -> Interface | None:
    path = sources.apps().get(name)
    if path is None:
        sources.report.error(
            mark,
            "app-unknown",
            f"unknown app '{name}'",
            sources.report.nearest(name, sources.apps()) or f"write apps/{name}/{name}.yaml",
        )
        return None
    found: Interface | None = sources.once(
        "app", name, lambda: read_interface(sources, name, path, is_app=True)
    )
    return found


def find_device_class(sources: Sources, name: str, mark: Mark) -> Interface | None:
    path = sources.classes().get(name)
    if path is None:
        sources.report.error(
            mark,
            "class-unknown",
            f"unknown device class '{name}'",
            sources.report.nearest(name, sources.classes()) or f"write drivers/{name}/{name}.yaml",
        )
        return None
    found: Interface | None = sources.once(
        "class", name, lambda: read_interface(sources, name, path, is_app=False)
    )
    return found
