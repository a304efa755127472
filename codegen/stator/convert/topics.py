"""The topics of a log, with the types of their fields."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from stator.diagnostics import UserError, nearest, shown_path

if TYPE_CHECKING:
    from pathlib import Path

    from pyulog import ULog

Columns: TypeAlias = list[NDArray[Any]]
_ELEMENT = re.compile(r"(.+)\[(\d+)\]")
_DTYPES = {"float": "f4", "double": "f8", "bool": "?", "char": "u1"} | {
    f"{sign}int{bits}_t": f"{'u' if sign else 'i'}{bits // 8}"
    for sign in ("", "u")
    for bits in (8, 16, 32, 64)
}


@dataclass(frozen=True)
class Field:
    """One field of a topic: a number, or an array of a fixed length."""

    name: str
    dtype: np.dtype[Any]
    columns: Columns  # one for each element
    is_array: bool


@dataclass(frozen=True)
class Topic:
    name: str
    time_us: NDArray[np.uint64]  # since the vehicle's start
    fields: list[Field]  # the first one is `timestamp`; padding is left out


def topics_of(log: ULog, path: Path, wanted: list[str]) -> list[Topic]:
    """Those that are wanted, or all. Raises `UserError` for one that the log does not have."""
    found = {topic.name: topic for topic in map(_topic, log.data_list)}
    for name in wanted:
        if name not in found:
            raise UserError(
                f"error: unknown topic '{name}' of the log '{shown_path(path)}'\n"
                f"hint: {nearest(name, found)}"
            )
    return [found[name] for name in sorted(wanted or found)]


def _topic(data: ULog.Data) -> Topic:
    fields: dict[str, Field] = {}
    for item in data.field_data:
        element = _ELEMENT.fullmatch(item.field_name)
        name = re.sub(r"\W+", "_", element[1] if element else item.field_name)
        if name.startswith("_padding"):
            continue
        dtype = np.dtype(_DTYPES[item.type_str])
        fields.setdefault(name, Field(name, dtype, [], element is not None))
        fields[name].columns.append(np.asarray(data.data[item.field_name], dtype=dtype))
    number = f"_{data.multi_id}" if data.multi_id else ""
    return Topic(data.name + number, data.data["timestamp"], list(fields.values()))
