"""Writes C++ codecs of the MAVLink messages that Stator speaks, from their definitions in
runtime/mavlink/messages.xml, which mavgen of the package `pymavlink` reads. The build runs it:
python -m stator.build.mavlink_codecs FOLDER"""

from __future__ import annotations

import itertools
import sys
from pathlib import Path
from typing import Any

import jinja2
from pymavlink.generator import mavparse

from stator import HOME
from stator.names import upper_camel

DEFINITIONS = HOME / "runtime" / "mavlink" / "messages.xml"
_TEMPLATES = Path(__file__).parent
_TYPES = {"char": "char", "float": "float", "double": "double"}
_HAS_COMPONENT = 0x80  # `kHasComponent` of known.hpp
_NO_TARGET = 0xFF
Row = dict[str, Any]


def definitions() -> Any:
    """The definitions as mavgen reads them: fields as they travel, lengths, CRC_EXTRA."""
    return mavparse.MAVXML(str(DEFINITIONS), mavparse.PROTOCOL_2_0)


def _field(field: Any) -> str:
    kind = _TYPES.get(field.type, field.type)
    if field.array_length:
        kind = f"std::array<{kind}, {field.array_length}>"
    return f"{kind} {field.name}{{}};"


def _target(message: Any) -> int:
    """Where its payload has the system that it is for, as known.hpp says."""
    offsets: dict[str, int] = {f.name: f.wire_offset for f in message.ordered_fields}
    system = offsets.get("target_system", offsets.get("target"))
    if system is None:
        return _NO_TARGET
    component = offsets.get("target_component")
    assert component in (None, system + 1), f"{message.name}: its target is in two places"
    return system | (0 if component is None else _HAS_COMPONENT)


def _is_plain(message: Any) -> bool:
    """Whether a struct of its fields has no gaps, as C++ lays it out: then it is the payload."""
    return all(field.wire_offset % field.type_length == 0 for field in message.ordered_fields)


def message_row(message: Any) -> Row:
    return {
        "name": upper_camel(message.name.lower()),
        "id": message.id,
        "crc_extra": message.crc_extra,
        "length": message.wire_length,
        "target": _target(message),
        "is_plain": _is_plain(message),
        "fields": [_field(field) for field in message.ordered_fields],
        "names": [field.name for field in message.ordered_fields],
    }


def enum_row(enum: Any) -> Row:
    """MAV_CMD_NAV_TAKEOFF of MAV_CMD becomes mav_cmd::kNavTakeoff. What all entries begin with is
    the enum's name, or most of it."""
    found = [entry for entry in enum.entry if not entry.end_marker]
    words = [(enum.name + "_").split("_"), *(entry.name.split("_") for entry in found)]
    common = itertools.takewhile(lambda same: len(set(same)) == 1, zip(*words, strict=False))
    begin = sum(len(word) + 1 for word, *_ in common)
    entries = [
        {"name": "k" + upper_camel(entry.name[begin:].lower()), "value": entry.value}
        for entry in found
    ]
    return {"name": enum.name.lower(), "entries": entries}


def generate(folder: Path) -> None:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES),
        undefined=jinja2.StrictUndefined,
        autoescape=False,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    parsed = definitions()
    messages = sorted((message_row(m) for m in parsed.message), key=lambda row: int(row["id"]))
    path = folder / "mavlink" / "messages.hpp"
    path.parent.mkdir(parents=True, exist_ok=True)
    template = environment.get_template("mavlink_messages.hpp.j2")
    enums = [enum_row(enum) for enum in parsed.enum]
    path.write_text(template.render(messages=messages, enums=enums), encoding="utf-8")


if __name__ == "__main__":
    generate(Path(sys.argv[1]))
