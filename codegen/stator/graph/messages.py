"""Reads the file of a message, and adds the padding between its fields."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import Mark, Report
from stator.graph.model import TYPES, Field, Message
from stator.graph.sources import Sources
from stator.language import keys as language
from stator.language.shapes import Record, quoted
from stator.names import reserved_type_reason, upper_camel

if TYPE_CHECKING:
    from pathlib import Path

MAX_MESSAGE_BYTES = 8192
_FIELD_TYPE = re.compile(r"([a-z0-9]+)(?:\[([0-9]{1,5})\])?")


def read_message(sources: Sources, name: str, path: Path) -> Message | None:
    report = sources.report
    record = sources.read(path, language.MESSAGE)
    mark = Mark(path, 1, 1)
    reason = reserved_type_reason(name)
    if reason:
        report.error(
            mark,
            "reserved-name",
            f"'{name}' cannot be a message name: {reason}",
            f"rename the file, for example to {name}Sample.yaml",
        )
        return None
    if record is None or record.get("fields") is None:
        return None
    table = record.get("fields")
    fields = [_field(key, value, report) for key, value in table.values.items()]
    known = [field for field in fields if field is not None]
    if len(known) < len(table.keys):
        return None
    message = Message(name, record.value("doc", ""), pad(known), mark)
    if message.bytes > MAX_MESSAGE_BYTES:
        report.error(
            record.keys["fields"],
            "message-too-large",
            f"expected a message of at most {MAX_MESSAGE_BYTES} bytes, found {message.bytes} bytes "
            f"in {name}",
            "split it into several messages",
        )
        return None
    return message if _enums_differ(name, known, table, report) else None


def _field(name: str, record: Record, report: Report) -> Field | None:
    leaf = record.get("type")
    if leaf is None:
        return None
    match = _FIELD_TYPE.fullmatch(leaf.value)
    if match is None or match.group(1) not in TYPES:
        report.error(
            leaf.mark,
            "field-type",
            f"unknown field type {quoted(leaf.value)}",
            report.nearest(re.sub("[^a-z0-9].*", "", leaf.value), TYPES),
        )
        return None
    if match.group(2) is not None and int(match.group(2)) == 0:
        report.error(
            leaf.mark,
            "field-type",
            f"expected an array of at least 1 item, found {quoted(leaf.value)}",
            "write the number of items in the brackets",
        )
        return None
    values = record.get("values")
    if values is not None and leaf.value != "uint8":
        report.error(
            leaf.mark,
            "field-type",
            f"expected type uint8 for a field with `values`, found {quoted(leaf.value)}",
            "write `type: uint8`, or remove `values`",
        )
        return None
    items = tuple((k, v.value) for k, v in values.values.items()) if values else ()
    count = int(match.group(2)) if match.group(2) else None
    return Field(
        name,
        match.group(1),
        count,
        record.value("unit", ""),
        record.value("frame", ""),
        items,
        record.value("doc", ""),
    )


def _enums_differ(message: str, fields: list[Field], table: Record, report: Report) -> bool:
    """Each enumeration becomes a C++ type inside the message's, named after its field."""
    types = {message: ""}
    good = True
    for field in fields:
        if not field.values:
            continue
        other = types.setdefault(upper_camel(field.name), field.name)
        if other != field.name:
            good = False
            whose = f"the enumeration of '{other}'" if other else "the message"
            report.error(
                table.keys[field.name],
                "name-clash",
                f"the enumeration of '{field.name}' and {whose} would both be called "
                f"{upper_camel(field.name)} in C++",
                "rename the field",
            )
        items = {upper_camel(name) for name, _ in field.values}
        if len(items) < len(field.values):
            good = False
            report.error(
                table.values[field.name].keys["values"],
                "name-clash",
                f"two values of '{field.name}' would have the same name in C++",
                "rename one of them: names must differ in more than underscores",
            )
    return good


def pad(fields: list[Field]) -> tuple[Field, ...]:
    """`timestamp`, then the fields. Each gap is a named field, so that every byte is written."""
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


def find_message(sources: Sources, name: str, mark: Mark) -> Message | None:
    path = sources.messages().get(name)
    if path is None:
        sources.report.error(
            mark,
            "message-unknown",
            f"unknown message '{name}'",
            sources.report.nearest(name, sources.messages())
            or f"write messages/{name}.yaml beside the graph",
        )
        return None
    found: Message | None = sources.once("message", name, lambda: read_message(sources, name, path))
    return found


def own_field(message: str, name: str) -> Field:
    """A field of one of Stator's own messages."""
    found = find_message(Sources(HOME, Report()), message, Mark(HOME, 1, 1))
    assert found is not None
    return next(field for field in found.fields if field.name == name)
