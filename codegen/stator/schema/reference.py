"""The language as docs/reference.md, from the same description that the checker uses."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from stator.language.shapes import NAME_PATTERN
from stator.schema.json_schema import KINDS

if TYPE_CHECKING:
    from collections.abc import Iterator

FILES = {
    "graph": ("Graph", "`graph/*.yaml`: the nodes, what activates each one, and how urgent it is."),
    "message": ("Message", "`graph/messages/NAME.yaml`: one type of sample."),
    "interface": ("Interface", "`NAME.yaml` of an app or a device class: the ports of a node."),
    "board": ("Board", "`boards/NAME/board.yaml`: the board that a graph runs on."),
    "chip": ("Chip", "`boards/FAMILY/CHIP.yaml`: what all boards with this chip share."),
    "budgets": ("Budgets", "`graph/budgets/BOARD.yaml`: execution times, measured on that board."),
    "failsafe": (
        "Failsafe table",
        "Beside the interface of an app: the next flight mode for each mode and event.",
    ),
    "mission": ("Mission", "`graph/missions/*.yaml`, for `./stator fly --mission`."),
    "vehicle": (
        "Vehicle",
        "`graph/vehicles/NAME.yaml`: what flies. Lengths are from the centre of mass: x forward,\n"
        "y to the right, z down.",
    ),
}
HEAD = """# The language

`./stator schema --reference` writes this page from the description that the checker uses. A dot
enters a mapping, NAME is a name that you choose, and [] is an item of a list. **Bold** keys are
required. `./stator schema` prints the same for editors, as JSON Schema.
"""
TIME = "us|ms|s|min"


def reference() -> str:
    parts = [HEAD]
    for kind, shape in KINDS.items():
        title, text = FILES.get(kind, (kind.capitalize(), ""))
        parts.append(f"\n## {title}\n\n{text}\n\n| key | value | meaning |\n|---|---|---|\n")
        parts += [f"| {key} | {value} | {what} |\n" for key, value, what in _rows(shape.schema())]
    return "".join(parts)


def _rows(schema: dict[str, Any], path: str = "") -> Iterator[tuple[str, str, str]]:
    """Key, value and meaning of each key below, in the order of the description."""
    for key, item in schema.get("properties", {}).items():
        name = f"`{path}{key}`"
        if key in schema.get("required", ()):
            name = f"**{name}**"
        yield name, _value(item), _cell(item.get("description", ""))
        yield from _below(item, path + key)
    for item in schema.get("patternProperties", {}).values():
        if not path:
            yield "`NAME`", _value(item), _cell(item.get("description", ""))
        yield from _below(item, f"{path}NAME")


def _below(item: dict[str, Any], path: str) -> Iterator[tuple[str, str, str]]:
    if item.get("type") == "object":
        yield from _rows(item, f"{path}.")
    elif "items" in item:
        yield from _below(item["items"], f"{path}[]")
    elif "anyOf" in item:
        # A value alone and the same value in a list have the same keys: print them once.
        printed: set[str] = set()
        for choice in item["anyOf"]:
            for row in _below(choice, path):
                if row[0].replace("[]", "") not in printed:
                    printed.add(row[0].replace("[]", ""))
                    yield row


def _value(item: dict[str, Any]) -> str:
    if "enum" in item:
        return " or ".join(f"`{value}`" for value in item["enum"])
    if "anyOf" in item:
        return " or ".join(dict.fromkeys(_value(choice) for choice in item["anyOf"]))
    kind = item.get("type")
    if kind == "integer":
        return _range("whole number", item)
    if kind == "object":
        return "mapping"
    if kind == "array":
        return f"list of {_value(item['items'])}" if item.get("items") else "list"
    if kind == "string":
        return _text(item.get("pattern", ""))
    return "true or false" if kind == "boolean" else "text or number"


def _range(what: str, item: dict[str, Any]) -> str:
    low, high = item.get("minimum"), item.get("maximum")
    return what if low is None or high is None else f"{what}, {low} to {high}"


def _text(pattern: str) -> str:
    if TIME in pattern:
        return "time or rate, with unit"
    return "name" if NAME_PATTERN in pattern else "text"


def _cell(text: str) -> str:
    return re.sub(r"\s+", " ", text).replace("|", "\\|")
