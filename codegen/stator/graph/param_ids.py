"""How others know a parameter: its id for ground stations, and its key in a memory for records.

Both depend on nothing but the parameter's own name or `id`, so a new parameter renames no other.
"""

from __future__ import annotations

import re
import zlib
from base64 import b32encode
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stator.graph.model import Param

NUMBER = "{n}"  # in an id: the number at the end of the node's name
_NODE, _PARAM, _DIGITS = 4, 6, 4  # letters of a derived id


def full_name(node: str, param: str) -> str:
    return f"{node}.{param}"


def id_of(node: str, param: Param) -> str:
    """At most 16 characters: what the interface says, or else letters of both names, and digits of
    the checksum of the full name, which tell alike ones apart."""
    if param.id:
        number = re.search("[0-9]*$", node)
        return param.id.replace(NUMBER, (number and number[0]) or "0")
    digits = b32encode(key_of(node, param.name).to_bytes(4, "big"))[:_DIGITS].decode()
    return f"{_letters(node)[:_NODE]}_{_letters(param.name)[:_PARAM]}_{digits}"


def _letters(name: str) -> str:
    return name.replace("_", "").upper()


def key_of(node: str, param: str) -> int:
    """Of its record in a memory."""
    return zlib.crc32(full_name(node, param).encode())


def former_keys_of(node: str, param: Param) -> list[int]:
    """Of the records that it had under other names."""
    return [
        zlib.crc32((name if "." in name else full_name(node, name)).encode()) for name in param.was
    ]


def definition_of(param: Param) -> int:
    """A kept value of another definition has another meaning. The range is not a part: each value
    is checked against it."""
    return zlib.crc32(f"{param.type} {param.unit}".encode())
