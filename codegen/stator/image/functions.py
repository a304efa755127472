"""The functions of an image: their instructions, as the disassembler prints them, and the bytes of
the image at each address."""

from __future__ import annotations

import re
import struct
from bisect import bisect_right
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

from stator.image.tools import run

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

_HEAD = re.compile(r"^([0-9a-f]+) <(.+)>:$")
_LINE = re.compile(r"^ *([0-9a-f]+):\t([a-z][a-z0-9.]*)(?:\t([^@;<]*))?(?:[^@;]*[@;] *(.*))?")
_NARROW = re.compile(r"\.[nw]$")


@dataclass(frozen=True)
class Instruction:
    at: int
    name: str  # without its width: `add`, not `add.w`
    operands: str
    note: str  # the disassembler's: the address of a constant, for example


@dataclass
class Function:
    at: int
    name: str
    code: dict[int, Instruction] = field(default_factory=dict)

    @cached_property
    def order(self) -> list[int]:
        return sorted(self.code)

    def after(self, at: int) -> int | None:
        """The address of the next instruction, unless there is data or the end before it."""
        place = bisect_right(self.order, at)
        found = self.order[place] if place < len(self.order) else None
        return found if found is not None and found - at <= 4 else None


class Code:
    def __init__(self, functions: dict[int, Function], memory: Memory) -> None:
        self.functions = functions
        self.memory = memory
        self._starts = sorted(functions)

    @cached_property
    def addressed(self) -> list[int]:
        """Functions whose address is a constant somewhere in the image."""
        words = {word & ~1 for word in self.memory.words() if word & 1}
        return [at for at in self._starts if at in words]

    def function_at(self, address: int) -> Function | None:
        """The function that this instruction belongs to."""
        place = bisect_right(self._starts, address) - 1
        found = self.functions[self._starts[place]] if place >= 0 else None
        return found if found is not None and address in found.code else None


class Memory:
    """What the image loads, by address."""

    def __init__(self, image: Path) -> None:
        raw = image.read_bytes()
        at, size, count = struct.unpack_from("<28xI10x2H", raw)
        self._parts: list[tuple[int, bytes]] = []
        for i in range(count):
            kind, offset, address, _, bytes_ = struct.unpack_from("<5I", raw, at + i * size)
            if kind == 1:  # PT_LOAD
                self._parts.append((address, raw[offset : offset + bytes_]))

    def words(self) -> Iterator[int]:
        for _, part in self._parts:
            yield from (word for (word,) in struct.iter_unpack("<I", part[: len(part) & ~3]))

    def read(self, address: int, count: int) -> int | None:
        for begin, part in self._parts:
            if begin <= address and address + count <= begin + len(part):
                return int.from_bytes(part[address - begin : address - begin + count], "little")
        return None


def read_code(image: Path) -> Code:
    text = run("objdump", "-d", "-C", "--no-show-raw-insn", str(image))
    return Code(_functions(text), Memory(image))


def _functions(text: str) -> dict[int, Function]:
    functions: dict[int, Function] = {}
    function = Function(0, "")
    for line in text.splitlines():
        if head := _HEAD.match(line):
            function = functions.setdefault(int(head[1], 16), Function(int(head[1], 16), head[2]))
        elif row := _LINE.match(line):
            at = int(row[1], 16)
            name = _NARROW.sub("", row[2])
            function.code[at] = Instruction(at, name, (row[3] or "").strip(), row[4] or "")
    return {at: function for at, function in functions.items() if function.code}
