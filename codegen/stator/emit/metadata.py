"""The files that describe all parameters to ground stations: MAVLink's component metadata."""

from __future__ import annotations

import json
import lzma
import zlib
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from stator.graph.param_ids import full_name, id_of

if TYPE_CHECKING:
    from fractions import Fraction

    from stator.graph.model import Node, Param
    from stator.plan.plan import Plan

FOLDER = "mftp://etc/"  # as apps/mavlink serves them
PARAMETERS = "parameters.json.xz"
TYPES = {"float": "Float", "int32": "Int32", "bool": "Int32"}
_OF_PARAMETERS = 1  # COMP_METADATA_TYPE_PARAMETER
_BYTES_A_ROW = 16


@dataclass(frozen=True)
class MetadataFile:
    name: str
    rows: list[str]
    crc: str

    @staticmethod
    def of(name: str, data: bytes) -> MetadataFile:
        rows = [data[i : i + _BYTES_A_ROW] for i in range(0, len(data), _BYTES_A_ROW)]
        return MetadataFile(
            name=name,
            rows=[", ".join(f"{byte:#04x}" for byte in row) for row in rows],
            crc=f"{plain_crc(data):#010x}U",
        )


def is_read(plan: Plan) -> bool:
    return any(node.interface.reads_metadata for node in plan.graph.nodes.values())


def files(plan: Plan) -> list[MetadataFile]:
    described = packed(parameters_json(plan))
    general = {
        "version": 1,
        "metadataTypes": [
            {
                "type": _OF_PARAMETERS,
                "uri": FOLDER + PARAMETERS,
                "fileCrc": plain_crc(described),
            }
        ],
    }
    return [
        MetadataFile.of("general", _text(general)),
        MetadataFile.of("parameters", described),
    ]


def packed(data: bytes) -> bytes:
    """As small readers of xz can read it: they know no other checksum."""
    return lzma.compress(data, format=lzma.FORMAT_XZ, check=lzma.CHECK_CRC32, preset=9)


def plain_crc(data: bytes) -> int:
    """MAVLink's CRC-32: without the inversions before and after."""
    return zlib.crc32(data, 0xFFFFFFFF) ^ 0xFFFFFFFF


def parameters_json(plan: Plan) -> bytes:
    described = [
        _described(node, param)
        for node in plan.graph.changeable.values()
        for param in node.interface.params.values()
    ]
    described.sort(key=lambda entry: str(entry["name"]))
    return _text({"version": 1, "parameters": described})


def _text(data: object) -> bytes:
    return json.dumps(data, separators=(",", ":"), ensure_ascii=False).encode()


def _described(node: Node, param: Param) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "name": id_of(node.name, param),
        "type": TYPES[param.type],
        "shortDesc": full_name(node.name, param.name),
        "longDesc": param.doc,
        "group": node.name,
        "default": _number(param, node.params[param.name]),
    }
    if param.unit != "1":
        entry["units"] = param.unit
    if param.least is not None and param.most is not None:
        entry |= {"min": _number(param, param.least), "max": _number(param, param.most)}
    if param.type == "bool":
        entry["values"] = [
            {"value": 0, "description": "no"},
            {"value": 1, "description": "yes"},
        ]
    if param.values:
        entry["values"] = [{"value": value, "description": name} for name, value in param.values]
    if param.flags:
        entry["bitmask"] = [
            {"index": index, "description": name} for index, name in enumerate(param.flags)
        ]
    if param.is_fixed:
        entry["readOnly"] = True
    return entry


def _number(param: Param, value: Fraction | int) -> float | int:
    return float(value) if param.type == "float" else int(value)
