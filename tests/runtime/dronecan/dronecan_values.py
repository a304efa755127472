"""Values of DroneCAN types, built by the package `dronecan`: drawn at random or by a test."""

from __future__ import annotations

import math
import struct
from typing import TYPE_CHECKING, Any

import dronecan
from dronecan.dsdl.parser import ArrayType, CompoundType, PrimitiveType, VoidType
from dronecan.transport import CompoundValue, bits_from_bytes, bytes_from_bits

if TYPE_CHECKING:
    from collections.abc import Callable


def modes(kind: Any) -> list[str | None]:
    return ["request", "response"] if kind.kind == CompoundType.KIND_SERVICE else [None]


def _fields(kind: Any, mode: str | None) -> tuple[list[Any], bool]:
    if mode == "request":
        return kind.request_fields, kind.request_union
    if mode == "response":
        return kind.response_fields, kind.response_union
    return kind.fields, kind.union


def make(
    kind: Any,
    mode: str | None,
    draw: Callable[[Any], Any],
    length: Callable[[int], int],
    pick: Callable[[int], int],
) -> Any:
    """A value: `draw` gives that of a primitive type, `length` that of an array of at most so many
    items, `pick` which field a union has."""
    value = CompoundValue(kind, mode)
    fields, union = _fields(kind, mode)
    if union:
        fields = [fields[pick(len(fields))]]
        getattr(value, fields[0].name)  # which chooses it
    for field in fields:
        if isinstance(field.type, VoidType):
            continue
        if isinstance(field.type, PrimitiveType):
            setattr(value, field.name, draw(field.type))
        elif isinstance(field.type, CompoundType):
            value._fields[field.name] = make(field.type, None, draw, length, pick)
        else:
            _fill(value._fields[field.name], field.type, draw, length, pick)
    return value


def _fill(
    array: Any,
    kind: Any,
    draw: Callable[[Any], Any],
    length: Callable[[int], int],
    pick: Callable[[int], int],
) -> None:
    fixed = kind.mode == ArrayType.MODE_STATIC
    count = kind.max_size if fixed else length(kind.max_size)
    for index in range(count):
        if isinstance(kind.value_type, PrimitiveType):
            item = draw(kind.value_type)
        else:
            item = make(kind.value_type, None, draw, length, pick)
        if fixed:
            array[index] = item
        else:
            array.append(item)


def pack(value: Any) -> bytes:
    return bytes(bytes_from_bits(value._pack(True)))


def unpack(kind: Any, mode: str | None, payload: bytes) -> Any:
    value = CompoundValue(kind, mode)
    value._unpack(bits_from_bytes(payload), True)
    return value


def renewed(value: Any) -> Any:
    """The same with each number through the package's own conversion, and one form of NaN: what it
    unpacked, it packs again bit by bit."""
    for field in getattr(value, "_fields", {}).values():
        renewed(field)
    if hasattr(value, "append"):
        for item in value._ArrayValue__items:
            renewed(item)
    number = getattr(value, "value", None)
    if isinstance(number, float):
        value.value = math.nan if math.isnan(number) else number
    return value


def service_or_message(name: str) -> Any:
    return dronecan.TYPENAMES[name]


def single(value: float) -> float:
    """Rounded to 32 bits."""
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def limits(kind: Any) -> list[Any]:
    """Values at the edges of a primitive type."""
    if kind.kind == PrimitiveType.KIND_BOOLEAN:
        return [False, True]
    least, most = kind.value_range
    if kind.kind == PrimitiveType.KIND_FLOAT:
        edges = [0.0, -0.0, 1.0, -2.5, least, most, 6.1e-5, 5.96e-8, 2.9e-8, 1e-10, 0.333, 2049.0]
        return [single(edge) for edge in edges] + ([math.inf, -math.inf, 65519.0, 7e4])
    return [least, most, 0, 1, most // 2, least // 3]
