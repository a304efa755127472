"""Writes C++ codecs of the DroneCAN types that Stator uses, from the DSDL in the package
`dronecan`. The build runs it: python -m stator.build.dronecan_codecs FOLDER"""

from __future__ import annotations

import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import dronecan
import jinja2
from dronecan.dsdl.parser import ArrayType, CompoundType, PrimitiveType, VoidType

from stator.names import snake, upper_camel

if TYPE_CHECKING:
    from collections.abc import Iterator

TYPES = (
    "uavcan.protocol.NodeStatus",
    "uavcan.protocol.GetNodeInfo",
    "uavcan.protocol.RestartNode",
    "uavcan.protocol.dynamic_node_id.Allocation",
    "uavcan.protocol.param.GetSet",
    "uavcan.equipment.esc.RawCommand",
    "uavcan.equipment.esc.Status",
    "uavcan.equipment.gnss.Fix2",
    "uavcan.equipment.gnss.Auxiliary",
    "uavcan.equipment.ahrs.MagneticFieldStrength2",
    "uavcan.equipment.air_data.StaticPressure",
    "uavcan.equipment.air_data.RawAirData",
    "uavcan.equipment.power.BatteryInfo",
    "uavcan.equipment.safety.ArmingStatus",
)
_TEMPLATES = Path(__file__).parent
Row = dict[str, Any]


def with_nested(names: tuple[str, ...]) -> list[Any]:
    """The types of these names and all types inside them, the innermost first."""
    found: dict[str, Any] = {}

    def add(kind: Any) -> None:
        for inner in _compounds(kind):
            add(inner)
        found.setdefault(kind.full_name, kind)

    for name in names:
        add(dronecan.TYPENAMES[name])
    return list(found.values())


def _compounds(kind: Any) -> Iterator[Any]:
    is_service = kind.kind == CompoundType.KIND_SERVICE
    for field in kind.request_fields + kind.response_fields if is_service else kind.fields:
        inner = field.type.value_type if isinstance(field.type, ArrayType) else field.type
        if isinstance(inner, CompoundType):
            yield inner


def header_of(kind: Any) -> str:
    """The path of the generated file, as in an include."""
    *folders, name = kind.full_name.split(".")[1:]
    return "/".join(["dronecan", *folders, snake(name)]) + ".hpp"


def _cpp_name(kind: Any) -> str:
    return "dronecan::" + "::".join(kind.full_name.split(".")[1:])


def _cpp_type(kind: Any) -> str:
    if isinstance(kind, CompoundType):
        return _cpp_name(kind)
    if isinstance(kind, ArrayType):
        item = _cpp_type(kind.value_type)
        fixed = kind.mode == ArrayType.MODE_STATIC
        return f"{'std::array' if fixed else 'Array'}<{item}, {kind.max_size}>"
    assert isinstance(kind, PrimitiveType), kind
    if kind.kind == PrimitiveType.KIND_BOOLEAN:
        return "bool"
    if kind.kind == PrimitiveType.KIND_FLOAT:
        return "float"
    bits = next(width for width in (8, 16, 32, 64) if width >= kind.bitlen)
    return f"{'u' if kind.kind == PrimitiveType.KIND_UNSIGNED_INT else ''}int{bits}_t"


def _visit(kind: Any, value: str, is_last: bool) -> str:
    """The statement that converts one field between bits and value."""
    if isinstance(kind, VoidType):
        return f"bits.skip({kind.bitlen});"
    if isinstance(kind, CompoundType):
        return f"{_cpp_name(kind)}::visit(bits, {value}, {'is_last' if is_last else 'false'});"
    if isinstance(kind, ArrayType):
        item = _visit(kind.value_type, "item", False)
        if kind.mode == ArrayType.MODE_STATIC:
            return f"for (auto& item : {value}) {item}"
        to_the_end = is_last and kind.value_type.get_min_bitlen() >= 8
        return (
            f"bits.array({value}, {kind.max_size.bit_length()}, "
            f"{'is_last' if to_the_end else 'false'}, [&](auto& item) {{ {item} }});"
        )
    assert isinstance(kind, PrimitiveType), kind
    if kind.kind == PrimitiveType.KIND_BOOLEAN:
        return f"bits.boolean({value});"
    saturated = kind.cast_mode == PrimitiveType.CAST_MODE_SATURATED
    if kind.kind == PrimitiveType.KIND_FLOAT:
        assert saturated and kind.bitlen in (16, 32), kind
        return f"bits.float{kind.bitlen}({value});"
    if kind.kind == PrimitiveType.KIND_SIGNED_INT:
        assert saturated, kind
        return f"bits.saturated_signed({value}, {kind.bitlen});"
    return f"bits.{'saturated' if saturated else 'truncated'}_unsigned({value}, {kind.bitlen});"


def _constant(constant: Any) -> Row:
    value = constant.value
    shown = str(value) if abs(value) < 2**31 else f"0x{value:X}"
    return {
        "type": _cpp_type(constant.type),
        "name": "k" + upper_camel(constant.name.lower()),
        "value": shown,
    }


def _struct(name: str, fields: list[Any], constants: list[Any], union: bool) -> Row:
    named = [field for field in fields if not isinstance(field.type, VoidType)]
    tags = ["k" + upper_camel(field.name) for field in fields] if union else []
    if union:
        statements = [f"bits.tag(self.tag, {(len(fields) - 1).bit_length()}, {len(fields)});"]
        statements += ["switch (self.tag) {"]
        for field, tag in zip(fields, tags, strict=True):
            move = _visit(field.type, f"self.{field.name}", True)
            statements += [f"case Tag::{tag}: {move} break;"]
        statements += ["}"]
    else:
        statements = [
            _visit(field.type, f"self.{field.name}", number == len(fields))
            for number, field in enumerate(fields, 1)
        ]
    return {
        "name": name,
        "kind": "",
        "constants": [_constant(constant) for constant in constants],
        "tags": tags,
        "fields": [f"{_cpp_type(field.type)} {field.name}{{}};" for field in named],
        "statements": statements,
    }


def _travelling(struct: Row, kind: Any, way: str, most_bits: int) -> Row:
    signature = f"0x{kind.get_data_type_signature():016x}"
    bytes_ = (most_bits + 7) // 8
    return struct | {
        "kind": way,
        "id": kind.default_dtid,
        "signature": signature,
        "most_bytes": bytes_,
    }


def rows(kind: Any) -> Row:
    """The fields of the template for one type."""
    *namespace, name = kind.full_name.split(".")[1:]
    service = ""
    if kind.kind == CompoundType.KIND_SERVICE:
        service = name
        request = _struct(
            "Request", kind.request_fields, kind.request_constants, kind.request_union
        )
        response = _struct(
            "Response", kind.response_fields, kind.response_constants, kind.response_union
        )
        structs = [
            _travelling(request, kind, "kRequest", kind.get_max_bitlen_request()),
            _travelling(response, kind, "kResponse", kind.get_max_bitlen_response()),
        ]
    else:
        struct = _struct(name, kind.fields, kind.constants, kind.union)
        if kind.default_dtid is not None:
            struct = _travelling(struct, kind, "kMessage", kind.get_max_bitlen())
        structs = [struct]
    return {
        "headers": sorted({header_of(inner) for inner in _compounds(kind)}),
        "namespace": "::".join(["stator", "dronecan", *namespace]),
        "service": service,
        "structs": structs,
    }


def generate(folder: Path) -> None:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(_TEMPLATES),
        undefined=jinja2.StrictUndefined,
        autoescape=False,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    template = environment.get_template("dronecan_codec.hpp.j2")
    for kind in with_nested(TYPES):
        source = re.sub(r"^.*/dsdl_specs/", "", str(kind.source_file))
        head = f"// Generated by stator from {source} of the package dronecan. Do not edit.\n"
        path = folder / header_of(kind)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(head + template.render(**rows(kind)), encoding="utf-8")


if __name__ == "__main__":
    generate(Path(sys.argv[1]))
