"""The parameters of a graph in the order of their ids, and values as people write them."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from stator.diagnostics import Failed, Mark, Report, UserError, nearest
from stator.graph.param_ids import full_name, id_of
from stator.graph.value import as_written, read_value
from stator.quantities import split

if TYPE_CHECKING:
    from stator.graph.model import Graph, Node, Param

# As the vehicle has it: a float of 32 bits, an int32, or a bool.
Value: TypeAlias = float | int | bool


@dataclass(frozen=True)
class Row:
    index: int
    id: str
    node: Node
    param: Param

    @property
    def name(self) -> str:
        return full_name(self.node.name, self.param.name)

    @property
    def default(self) -> Value:
        """The graph's value."""
        return self.stored(self.node.params[self.param.name])

    @property
    def unit(self) -> str:
        return "" if self.param.unit == "1" else self.param.unit

    def stored(self, value: Fraction | Value) -> Value:
        """As the vehicle stores it."""
        if self.param.type == "float" or isinstance(value, Fraction):
            return to_float32(float(value))
        return value

    def shown(self, value: Value) -> str:
        """With its unit."""
        return f"{in_words(value)} {self.unit}".rstrip()


def table_of(graph: Graph) -> list[Row]:
    rows = sorted(
        (id_of(node.name, param), node.name, param.name)
        for node in graph.nodes.values()
        for param in node.interface.params.values()
    )
    return [
        Row(i, param_id, graph.nodes[node], graph.nodes[node].interface.params[name])
        for i, (param_id, node, name) in enumerate(rows)
    ]


def find(table: list[Row], name: str) -> Row:
    """By id or by NODE.PARAMETER. Raises `UserError`."""
    for row in table:
        if name in (row.id, row.name):
            return row
    if not table:
        raise UserError(f"error: unknown parameter '{name}': the graph has none")
    exact = next((row.id for row in table if row.id == name.upper()), "")
    hint = f"did you mean '{exact}'?" if exact else nearest(name, _names(table, name))
    raise UserError(f"error: unknown parameter '{name}'\nhint: {hint}")


def _names(table: list[Row], name: str) -> list[str]:
    """Of the kind that was meant."""
    return [row.name if "." in name or name.islower() else row.id for row in table]


def read_text(row: Row, text: str) -> Value:
    """A value as in a graph; a bare number is in the parameter's own unit. Raises `UserError`."""
    parts = split(text)
    if parts is not None and not parts[1]:
        text = f"{text} {row.unit}".rstrip()
    if row.param.type == "bool":
        text = {"1": "true", "0": "false"}.get(text, text)
    report = Report()
    value = read_value(row.param, as_written(row.param, text, Mark(Path(row.name), 1, 1)), report)
    try:
        report.stop_on_errors()
    except Failed as failed:
        error = failed.errors[0]
        raise UserError(f"error: {row.id}: {error.message}\nhint: {error.hint}") from None
    assert value is not None
    return row.stored(value)


def bits_of(row: Row, value: Value) -> int:
    """The 32 bits of a value."""
    form = "<f" if row.param.type == "float" else "<i"
    return int.from_bytes(struct.pack(form, value), "little")


def value_of_bits(row: Row, bits: int) -> Value:
    form = "<f" if row.param.type == "float" else "<i"
    (value,) = struct.unpack(form, bits.to_bytes(4, "little"))
    return bool(value) if row.param.type == "bool" else value


def to_float32(value: float) -> float:
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def in_words(value: Value) -> str:
    """The shortest text that is the same float of 32 bits."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int):
        return str(value)
    texts = (f"{value:.{digits}g}" for digits in range(6, 10))
    return next((text for text in texts if to_float32(float(text)) == value), f"{value:.9g}")
