"""Reads from C++ what Python must know as well: constants, and the layout of structs that travel as
bytes."""

from __future__ import annotations

import re
import struct
from functools import cache
from typing import NamedTuple

from stator import HOME

_CODES = {"uint8_t": "B", "uint16_t": "H", "uint32_t": "I", "uint64_t": "Q", "char": "s"}
_CODES |= {"int32_t": "i", "float": "f", "double": "d"}
_FIELD = re.compile(
    r"^    (?:std::array<(\w+), (\d+)>|(\w+)) (\w+)(?:\{\}| = [^;]+);", re.MULTILINE
)


class Layout(NamedTuple):
    """A struct of C++, little-endian and without padding, as its own static_assert sees to."""

    packed: struct.Struct
    names: tuple[str, ...]  # of an array, once for each number in it

    def read(self, data: bytes) -> dict[str, tuple[int | float | bytes, ...]]:
        """Values of each field by name. Raises `struct.error` if the length is another one."""
        found: dict[str, tuple[int | float | bytes, ...]] = {}
        for name, value in zip(self.names, self.packed.unpack(data), strict=True):
            found[name] = (*found.get(name, ()), value)
        return found


@cache
def constant(file: str, name: str) -> float:
    """A number that a file of the project, such as apps/navigator/route.cpp, gives a name."""
    text = (HOME / file).read_text(encoding="utf-8")
    found = re.search(rf"\b{name} = (0x[\da-fA-F']+|[\d.']+)", text)
    assert found is not None, f"{file} has no number {name}"
    digits = found[1].replace("'", "")
    return int(digits, 0) if re.fullmatch(r"0x.*|\d+", digits) else float(digits)


@cache
def layout(file: str, name: str) -> Layout:
    """A struct of numbers and arrays of them; bytes and text are one value."""
    text = (HOME / file).read_text(encoding="utf-8")
    found = re.search(rf"^struct {name} \{{\n(.*?)^\}};", text, re.MULTILINE | re.DOTALL)
    assert found is not None, f"{file} has no struct {name}"
    body = found[1]
    own = re.findall(r"enum class (\w+) : (\w+)", body)
    codes = _CODES | {kind: _CODES[base] for kind, base in own}
    form, names = "<", []
    for kind, count, single, field in _FIELD.findall(body):
        is_text = kind in ("char", "uint8_t")
        form += f"{count}{'s' if is_text else codes[kind]}" if kind else codes[single]
        names += [field] * (1 if not kind or is_text else int(count))
    return Layout(struct.Struct(form), tuple(names))


@cache
def enumerators(file: str, name: str) -> dict[str, int]:
    """The names of an enum of C++, without their k, and their numbers."""
    text = (HOME / file).read_text(encoding="utf-8")
    found = re.search(rf"enum class {name} : \w+ \{{(.*?)\}};", text, re.DOTALL)
    assert found is not None, f"{file} has no enum {name}"
    return {key: int(value) for key, value in re.findall(r"\bk(\w+) = (\d+)", found[1])}


@cache
def numbers(file: str, name: str) -> frozenset[int]:
    """The numbers of an array of C++."""
    text = (HOME / file).read_text(encoding="utf-8")
    found = re.search(rf"\b{name}\{{([\d,\s]+)\}};", text)
    assert found is not None, f"{file} has no array {name}"
    return frozenset(int(number) for number in found[1].split(","))
