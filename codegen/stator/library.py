"""Finds and reads what a graph names: apps, messages, device classes, boards, chips.

Looked for beside the graph first, then in Stator itself. Each file is read once.
"""

from __future__ import annotations

import re
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator import language, yaml_tree
from stator.diagnostics import Mark, Report, nearest
from stator.model import TYPES, Board, Chip, Device, Field, Interface, Message, Param, Port, Value
from stator.names import is_reserved_type, upper_camel
from stator.quantities import CONVERSIONS, shown, split
from stator.shapes import Record, Struct, quoted
from stator.yaml_tree import Scalar

if TYPE_CHECKING:
    from collections.abc import Callable

HOME = Path(__file__).resolve().parents[2]
MOST_MESSAGE_BYTES = 8192
_FIELD_TYPE = re.compile(r"([a-z0-9]+)(?:\[([0-9]{1,5})\])?")


class Library:
    def __init__(self, beside: Path, report: Report) -> None:
        self._report = report
        self._bases = [beside] if beside == HOME else [beside, HOME]
        self._cache: dict[tuple[str, str], Any] = {}
        self.files: list[Path] = []

    # --- where things are ---

    def apps(self) -> dict[str, Path]:
        return self._folders("apps", "*/", lambda p: p.name, lambda p: p / f"{p.name}.yaml")

    def boards(self) -> dict[str, Path]:
        return self._folders("boards", "*/", lambda p: p.name, lambda p: p / "board.yaml")

    def classes(self) -> dict[str, Path]:
        return self._folders("drivers", "*/", lambda p: p.name, lambda p: p / f"{p.name}.yaml")

    def drivers(self) -> dict[str, Path]:
        def header(p: Path) -> Path:
            return p / f"{p.parent.name}_{p.name}.hpp"

        return self._folders("drivers", "*/*/", lambda p: f"{p.parent.name}/{p.name}", header)

    def messages(self) -> dict[str, Path]:
        found: dict[str, Path] = {}
        for base in self._bases:
            for folder in (base / "messages", base / "graph" / "messages"):
                for path in sorted(folder.glob("*.yaml")):
                    found.setdefault(path.stem, path)
        return found

    def _folders(self, top: str, pattern: str, name: Callable[[Path], str],
                 file: Callable[[Path], Path]) -> dict[str, Path]:
        key = ("folders", top + pattern)
        if key not in self._cache:
            found: dict[str, Path] = {}
            for base in self._bases:
                for folder in sorted((base / top).glob(pattern)):
                    if file(folder).is_file():
                        found.setdefault(name(folder), file(folder))
            self._cache[key] = found
        result: dict[str, Path] = self._cache[key]
        return result

    def _read(self, path: Path, shape: Struct) -> Record | None:
        self.files.append(path)
        tree = yaml_tree.load(path, self._report)
        return None if tree is None else shape.read(tree, self._report)

    def _once(self, what: str, name: str, make: Callable[[], Any]) -> Any:
        if (what, name) not in self._cache:
            self._cache[what, name] = make()
        return self._cache[what, name]

    # --- messages ---

    def message(self, name: str, mark: Mark) -> Message | None:
        paths = self._once("paths", "messages", self.messages)
        if name not in paths:
            self._report.error(mark, "message-unknown", f"there is no message '{name}'",
                               nearest(name, paths))
            return None
        found: Message | None = self._once("message", name, lambda: self._message(name, paths[name]))
        return found

    def _message(self, name: str, path: Path) -> Message | None:
        record = self._read(path, language.MESSAGE)
        mark = Mark(path, 1, 1)
        if is_reserved_type(name):
            self._report.error(mark, "reserved-name", f"a message cannot be called '{name}': "
                               "the runtime has taken it", f"for example {name}Sample")
            return None
        if record is None or record.get("fields") is None:
            return None
        table = record.get("fields")
        fields = [self._field(key, table.keys[key], value) for key, value in table.values.items()]
        known = [field for field in fields if field is not None]
        message = Message(name, record.value("doc", ""), pad(known), mark)
        if message.bytes > MOST_MESSAGE_BYTES:
            self._report.error(mark, "message-too-large", f"{message.bytes} bytes, more than "
                               f"{MOST_MESSAGE_BYTES}", "split it into several samples")
            return None
        return message

    def _field(self, name: str, mark: Mark, record: Record) -> Field | None:
        leaf = record.get("type")
        if leaf is None:
            return None
        match = _FIELD_TYPE.fullmatch(leaf.value)
        if match is None or match.group(1) not in TYPES or match.group(2) == "0":
            self._report.error(leaf.mark, "field-type", f"{quoted(leaf.value)} is no field type",
                               nearest(leaf.value.split("[")[0], TYPES))
            return None
        values = record.get("values")
        if values is not None and leaf.value != "uint8":
            self._report.error(mark, "field-type", "a field with `values` has type uint8")
            return None
        items = tuple((k, v.value) for k, v in values.values.items()) if values else ()
        count = int(match.group(2)) if match.group(2) else None
        return Field(name, match.group(1), count, record.value("unit", ""),
                     record.value("frame", ""), items, record.value("doc", ""))

    # --- interfaces ---

    def app(self, name: str, mark: Mark) -> Interface | None:
        return self._interface(self.apps(), "app", "app-unknown", name, mark)

    def device_class(self, name: str, mark: Mark) -> Interface | None:
        return self._interface(self.classes(), "device class", "class-unknown", name, mark)

    def _interface(self, paths: dict[str, Path], what: str, rule: str, name: str,
                   mark: Mark) -> Interface | None:
        if name not in paths:
            where = "drivers" if what == "device class" else "apps"
            self._report.error(mark, rule, f"there is no {what} '{name}'", nearest(name, paths)
                               or f"make {where}/{name}/{name}.yaml")
            return None
        found: Interface | None = self._once(
            what, name, lambda: self._read_interface(name, paths[name], what == "app"))
        return found

    def _read_interface(self, name: str, path: Path, is_app: bool) -> Interface | None:
        record = self._read(path, language.INTERFACE)
        if record is None:
            return None
        lines = record.get("lines")
        if is_app and lines is not None:
            self._report.error(record.keys["lines"], "irq-needs-device",
                               "only a device class has lines", "remove the key")
        params = {key: param for key, value in _items(record, "params")
                  if (param := self._param(key, value)) is not None}
        return Interface(
            name=name,
            file=path,
            doc=record.value("doc", ""),
            lines={key: value.value("doc", "") for key, value in _items(record, "lines")},
            inputs=self._ports(record, "inputs"),
            outputs=self._ports(record, "outputs"),
            params=params,
            reads_log=record.value("reads_log", False),
            params_message=params_message(name, params, Mark(path, 1, 1)),
        )

    def _ports(self, record: Record, key: str) -> dict[str, Port]:
        ports = {}
        for name, value in _items(record, key):
            leaf = value.get("message")
            message = None if leaf is None else self.message(leaf.value, leaf.mark)
            if message is not None:
                ports[name] = Port(name, message, value.value("optional", False),
                                   value.value("doc", ""))
        return ports

    def _param(self, name: str, record: Record) -> Param | None:
        type_name = record.value("type")
        default = record.get("default")
        if type_name is None or default is None:
            return None
        param = Param(name, type_name, record.value("unit", "1"), None, None, 0,
                      record.value("doc", ""))
        bounds: list[Value | None] = [None, None]
        if record.get("range") is not None:
            bounds = [read_value(param, item, self._report, in_file=True)
                      for item in record.get("range").value]
        param = Param(param.name, param.type, param.unit, _fraction(bounds[0]),
                      _fraction(bounds[1]), 0, param.doc)
        value = read_value(param, default, self._report, in_file=True)
        if value is None:
            return None
        return Param(name, type_name, param.unit, param.least, param.most, value, param.doc)

    # --- boards ---

    def board(self, name: str, mark: Mark) -> Board | None:
        paths = self.boards()
        if name not in paths:
            self._report.error(mark, "board-unknown", f"there is no board '{name}'",
                               nearest(name, paths))
            return None
        found: Board | None = self._once("board", name, lambda: self._board(name, paths[name]))
        return found

    def _board(self, name: str, path: Path) -> Board | None:
        record = self._read(path, language.BOARD)
        if record is None or record.value("executor") is None:
            return None
        chip = record.get("chip")
        reserved = record.get("reserved_vectors")
        return Board(
            name=name,
            file=path,
            executor=record.value("executor"),
            chip=None if chip is None else self._chip(chip.value, chip.mark, path),
            reserved_vectors=tuple(leaf.value for leaf in reserved.value) if reserved else (),
            devices={key: device for key, value in _items(record, "devices")
                     if (device := self._device(key, value)) is not None},
        )

    def _device(self, name: str, record: Record) -> Device | None:
        driver = record.get("driver")
        if driver is None:
            return None
        if driver.value == "none" and record.get("class") is None:
            self._report.error(driver.mark, "missing-key", "a device without driver needs `class`")
            return None
        if driver.value != "none" and driver.value not in self.drivers():
            self._report.error(driver.mark, "driver-unknown", f"there is no driver '{driver.value}'",
                               nearest(driver.value, self.drivers()))
            return None
        device_class = record.value("class") or driver.value.split("/")[0]
        lines = {key: leaf.value for key, leaf in _items(record, "lines")}
        return Device(name, driver.value, device_class, lines)

    def _chip(self, name: str, mark: Mark, board: Path) -> Chip | None:
        path = board.parents[1] / f"{name}.yaml"
        if not path.is_file():
            self._report.error(mark, "file-missing", f"there is no chip file '{path.name}'")
            return None
        record = self._read(path, language.CHIP)
        if record is None:
            return None
        return Chip(name, {key: leaf.value for key, leaf in _items(record, "vectors")})


def _items(record: Record, key: str) -> list[tuple[str, Any]]:
    table = record.get(key)
    return [] if table is None else list(table.values.items())


def _fraction(value: Value | None) -> Fraction | None:
    return None if value is None else Fraction(value)


def pad(fields: list[Field]) -> tuple[Field, ...]:
    """The fields behind `timestamp`, with every gap a named field, so that no byte is stale."""
    doc = "When it was published; set by publish."
    result = [Field("timestamp", "uint64", None, "us", "", (), doc)]
    offset = 8
    paddings = 0

    def fill(alignment: int) -> None:
        nonlocal offset, paddings
        gap = -offset % alignment
        if gap:
            result.append(Field(f"_padding{paddings}", "uint8", gap, "", "", (), ""))
            paddings += 1
            offset += gap

    for field in fields:
        fill(field.alignment)
        result.append(field)
        offset += field.bytes
    fill(8)
    return tuple(result)


def params_message(app: str, params: dict[str, Param], mark: Mark) -> Message | None:
    """Parameters travel as a message of their own."""
    if not params:
        return None
    fields = [Field(p.name, p.type, None, p.unit, "", (), p.doc) for p in params.values()]
    return Message(upper_camel(app) + "Params", f"Parameters of {app}.", pad(fields), mark)


def read_value(param: Param, item: Scalar, report: Report, *, in_file: bool = False) -> Value | None:
    """A parameter's value in its own unit, from text. In the interface itself (`in_file`) numbers
    are bare, as the unit stands beside them."""
    if param.type == "bool":
        if item.text in ("true", "false"):
            return item.text == "true"
        report.error(item.mark, "wrong-type", f"'{param.name}' is true or false, not "
                     f"{quoted(item.text)}", "write true or false")
        return None
    parts = split(item.text)
    if parts is None:
        report.error(item.mark, "wrong-type",
                     f"'{param.name}' is a number, not {quoted(item.text)}")
        return None
    number, unit = parts
    if not in_file:
        factor = _factor(param, unit, item, report)
        if factor is None:
            return None
        number *= factor
    elif unit:
        report.error(item.mark, "unit-unknown", "numbers in an interface are bare",
                     f"the unit stands in the key `unit`: {param.unit}")
        return None
    if abs(number) > Fraction(10) ** 37:
        report.error(item.mark, "out-of-range", f"{quoted(item.text)} is too large for a float")
        return None
    if param.type == "int32":
        if number.denominator != 1 or abs(number) >= 2**31:
            report.error(item.mark, "wrong-type", f"'{param.name}' is a whole number of 32 bits, "
                         f"not {quoted(item.text)}")
            return None
        number = Fraction(int(number))
    least, most = param.least, param.most
    if (least is not None and number < least) or (most is not None and number > most):
        unit_shown = "" if param.unit == "1" else f" {param.unit}"
        report.error(item.mark, "param-range", f"'{param.name}' is {shown(number)}{unit_shown}, "
                     f"outside {shown(least or Fraction(0))} to {shown(most or Fraction(0))}"
                     f"{unit_shown}")
        return None
    return int(number) if param.type == "int32" else number


def _factor(param: Param, unit: str, item: Scalar, report: Report) -> Fraction | None:
    if unit == param.unit or (unit == "" and param.unit == "1"):
        return Fraction(1)
    known = CONVERSIONS.get(param.unit, {})
    if unit in known:
        return known[unit]
    choices = [u for u in (param.unit, *known) if u != "1"]
    if unit == "":
        report.error(item.mark, "unit-missing", f"'{param.name}' needs a unit",
                     "write " + " or ".join(f"{item.text} {u}" for u in choices))
    else:
        hint = "use " + " or ".join(choices) if choices else f"it has no unit: {item.text.split()[0]}"
        report.error(item.mark, "unit-unknown", f"'{param.name}' is in {param.unit}, not in "
                     f"{quoted(unit)}", hint)
    return None
