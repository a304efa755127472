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
Row = dict[str, Any]


def definitions() -> Any:
    """The definitions as mavgen reads them: fields as they travel, lengths, CRC_EXTRA."""
    return mavparse.MAVXML(str(DEFINITIONS), mavparse.PROTOCOL_2_0)


def _field(field: Any) -> str:
    kind = _TYPES.get(field.type, field.type)
    if field.array_length:
        kind = f"std::array<{kind}, {field.array_length}>"
    return f"{kind} {field.name}{{}};"


def message_row(message: Any) -> Row:
    return {
        "name": upper_camel(message.name.lower()),
        "id": message.id,
        "crc_extra": message.crc_extra,
        "length": message.wire_length,
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
