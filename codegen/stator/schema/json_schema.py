"""The language as JSON Schema, for editors: the same description that the checker uses.

A schema sees one file. It is strict with a whole graph, which has `board` and includes nothing. A
part, or a graph that includes parts, may omit any key, contain ${variables}, and remove keys with
null.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stator.graph import failsafe
from stator.language import keys as language
from stator.language.vehicle_keys import VEHICLE
from stator.mission import yaml as mission_yaml
from stator.version import SCHEMA_VERSION

if TYPE_CHECKING:
    from stator.language.shapes import Shape

_DIALECT = "https://json-schema.org/draft/2020-12/schema"
_VERSION = f"schema {SCHEMA_VERSION}"
_SUBSCHEMAS = ("properties", "patternProperties")

# The kinds of files.
KINDS: dict[str, Shape] = {
    "graph": language.GRAPH,
    "message": language.MESSAGE,
    "interface": language.INTERFACE,
    "board": language.BOARD,
    "chip": language.CHIP,
    "budgets": language.BUDGETS,
    "failsafe": failsafe.SHAPE,
    "mission": mission_yaml.MISSION,
    "vehicle": VEHICLE,
}


def graph_schema() -> dict[str, Any]:
    strict = language.GRAPH.schema()
    return {
        "$schema": _DIALECT,
        "title": "Stator graph",
        "$comment": _VERSION,
        "if": {"required": ["board"], "not": {"required": ["include"]}},
        "then": strict,
        "else": _part(strict),
        "$defs": {
            "from_elsewhere": {
                "description": "A variable of the including file, or null to remove the key.",
                "anyOf": [{"type": "null"}, {"type": "string", "pattern": r"^\$\{[^}]*\}$"}],
            }
        },
    }


def schema(kind: str) -> dict[str, Any]:
    """The schema of one kind of file, of KINDS."""
    if kind == "graph":
        return graph_schema()
    head = {"$schema": _DIALECT, "title": f"Stator {kind}", "$comment": _VERSION}
    return head | KINDS[kind].schema()


def _part(strict: dict[str, Any]) -> dict[str, Any]:
    """The schema of a file that other files complete."""
    loose = {key: value for key, value in strict.items() if key != "required"}
    for key in _SUBSCHEMAS:
        if key in loose:
            loose[key] = {name: _elsewhere(item) for name, item in loose[key].items()}
    if "items" in loose:
        loose["items"] = _elsewhere(loose["items"])
    if "anyOf" in loose:
        loose["anyOf"] = [_part(item) for item in loose["anyOf"]]
    return loose


def _elsewhere(item: dict[str, Any]) -> dict[str, Any]:
    return {"anyOf": [_part(item), {"$ref": "#/$defs/from_elsewhere"}]}
