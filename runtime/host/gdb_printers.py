"""For gdb, which `./stator debug` tells to read this: Eigen's fixed-size matrices and quaternions
print as their numbers, not as their nested storage."""

from __future__ import annotations

import re

import gdb

MATRIX = r"Eigen::(Matrix|Array)<(.+), (\d+), (\d+), (\d+), \d+, \d+>"
NAME = re.compile(MATRIX + r"|Eigen::Quaternion<.+>")
ROW_MAJOR = 1


class Numbers:
    """Rows of a matrix; w, x, y, z of a quaternion."""

    def __init__(self, value: gdb.Value, shape: re.Match[str]) -> None:
        self.value = value
        self.shape = shape

    def to_string(self) -> str:
        if not self.shape[1]:
            storage = self.value["m_coeffs"]["m_storage"]["m_data"]["array"]
            x, y, z, w = (str(storage[i]) for i in range(4))
            return f"w {w}, x {x}, y {y}, z {z}"
        storage = self.value["m_storage"]["m_data"]["array"]
        rows, columns, options = (int(self.shape[i]) for i in (3, 4, 5))
        along, across = (columns, 1) if options & ROW_MAJOR else (1, rows)
        lines = [
            ", ".join(str(storage[i * along + j * across]) for j in range(columns))
            for i in range(rows)
        ]
        return f"[{(', ' if columns == 1 else '; ').join(lines)}]"


def printer(value: gdb.Value) -> Numbers | None:
    name = value.type.strip_typedefs().unqualified().name
    shape = NAME.fullmatch(name or "")
    return Numbers(value, shape) if shape else None


gdb.pretty_printers.append(printer)
