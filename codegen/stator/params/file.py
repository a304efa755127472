"""Files of parameters that ground stations exchange: QGroundControl's `.params`, which we write,
and MAVProxy's `.parm`, which is read, too."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from stator.diagnostics import UserError, shown_path
from stator.params.table import Row, Value, in_words, read_text

if TYPE_CHECKING:
    from pathlib import Path

VEHICLE, COMPONENT = 1, 1
REAL32, INT32 = 9, 6  # MAV_PARAM_TYPE
SYSTEM_ID = "MAV_SYS_ID"


@dataclass
class Loaded:
    values: dict[str, Value] = field(default_factory=dict)  # by id
    unknown: list[str] = field(default_factory=list)
    other_type: list[str] = field(default_factory=list)


def write(path: Path, graph: str, table: list[Row], values: dict[str, Value]) -> None:
    """Raises `UserError`."""
    lines = [
        "# Onboard parameters",
        "#",
        "# Stack: Stator",
        f"# Vehicle: {graph}",
        "#",
        "# Vehicle-Id Component-Id Name Value Type",
    ]
    vehicle = values.get(SYSTEM_ID, VEHICLE)
    for row in table:
        kind = REAL32 if row.param.type == "float" else INT32
        value = values[row.id]
        number = in_words(value) if kind == REAL32 else str(int(value))
        lines.append(f"{vehicle}\t{COMPONENT}\t{row.id}\t{number}\t{kind}")
    try:
        path.write_text("\n".join(lines) + "\n", encoding="utf-8", newline="\n")
    except OSError as error:
        raise UserError(f"error: cannot write '{shown_path(path)}': {error.strerror}") from None


def read(path: Path, table: list[Row], vehicle: int = VEHICLE) -> Loaded:
    """Raises `UserError` for a file that is not one, is of another vehicle, or has a value that a
    parameter cannot have: with all errors."""
    try:
        text = path.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise UserError(f"error: cannot read '{shown_path(path)}': {error.strerror}") from None
    rows = {row.id: row for row in table}
    loaded, errors = Loaded(), []
    for number, line in enumerate(text.splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            _read_line(line.strip(), rows, vehicle, loaded)
        except UserError as error:
            message, _, hint = str(error).removeprefix("error: ").partition("\n")
            errors.append(
                "\n".join(filter(None, (f"{path.name}:{number}: error: {message}", hint)))
            )
    if errors:
        raise UserError("\n".join(errors) + "\nnothing was changed")
    return loaded


def _read_line(line: str, rows: dict[str, Row], vehicle: int, loaded: Loaded) -> None:
    words = re.split(r"[\s,]+", line)
    kind = None
    if len(words) == 5:
        if words[0] != str(vehicle):
            raise UserError(
                f"expected parameters of vehicle {vehicle}, found vehicle '{words[0][:20]}'\n"
                "hint: use a file of this vehicle"
            )
        name, value, kind = words[2:]
    elif len(words) == 2:
        name, value = words
    else:
        raise UserError(
            f"expected a parameter, found '{line[:60]}'\n"
            "hint: write VEHICLE COMPONENT NAME VALUE TYPE, or NAME VALUE"
        )
    row = rows.get(name)
    if row is None:
        loaded.unknown.append(name)
    elif kind is not None and kind != str(REAL32 if row.param.type == "float" else INT32):
        loaded.other_type.append(name)
    else:
        loaded.values[name] = _number(row, value)


def _number(row: Row, text: str) -> Value:
    """Others write whole numbers as 1.000000, and floats with more digits than theirs. So a value
    at the end of a range may lie a little outside."""
    try:
        number = float(text)
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise UserError(f"{row.id}: expected a number, found '{text[:30]}'")
    if row.param.type != "float":
        return read_text(row, str(int(number)) if number.is_integer() else text)
    value = row.stored(number)
    for bound in (row.param.least, row.param.most):
        if bound is not None and value == row.stored(bound):
            return value
    return read_text(row, in_words(value))
