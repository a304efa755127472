"""Who calls a function of an image, in the words of the source: inlined functions included."""

from __future__ import annotations

import os
import re
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import shown_path
from stator.image.tools import run

if TYPE_CHECKING:
    from collections.abc import Collection, Iterable, Mapping

FUNCTION = re.compile(r"^([0-9a-f]+) <(.+)>:$")
# A branch to the first instruction of a function is a call, or a call that does not return here.
_CALL = re.compile(r"^ *([0-9a-f]+):\tb\S*\t([0-9a-f]+) <")
_TASK = re.compile(r"/generated/graph_program/tasks/(\w+)\.cpp$")
# Constructors of static objects. The optimiser merges the constructors of all nodes into one
# function; inlined constructors then have no names.
_CONSTRUCTORS = re.compile(r"_(GLOBAL_)?_?sub_I_")
BEFORE_START = "before the first task"  # stands for a node in constructors
_SHARED = (f"{HOME}/runtime/", "/usr/include/", "/usr/lib/", "/usr/local/include/")


def short(name: str) -> str:
    """A function's name without parameters, and without what the optimiser did to it."""
    return name.replace("(anonymous namespace)::", "").split("(")[0].split(" [clone")[0]


@dataclass(frozen=True)
class Frame:
    """A function of the source, and where in it an instruction belongs."""

    function: str
    file: str
    line: int

    @property
    def place(self) -> str:
        """As errors begin; empty if it is not known."""
        return f"{shown_path(Path(self.file))}:{self.line}: " if self.line else ""

    @property
    def is_project(self) -> bool:
        """Whether it is of an app, a driver or a board, and not of what they share."""
        is_found = (
            self.line > 0 and Path(self.file).is_file()
        )  # the sources of libgcc are not installed
        return is_found and not self.file.startswith(_SHARED)


@dataclass(frozen=True)
class Place:
    """Where an app, a driver or a board calls something, itself or through shared functions."""

    node: str  # or BEFORE_START; empty: no task calls it
    frame: Frame
    callee: str


class Calls:
    """The calls between the functions of an image."""

    def __init__(self, image: Path, code: str, names: Mapping[int, str]) -> None:
        """`code`: as `objdump -d -C` prints it. `names`: of functions that have several, the one
        to show."""
        self._image = image
        self._names: dict[int, str] = {}
        self._callers: dict[int, list[int]] = defaultdict(list)  # function: calls of it
        self._within: dict[int, int] = {}  # call: the function that makes it
        self._callee: dict[int, int] = {}
        self._frames: dict[int, list[Frame]] = {}
        found = []
        function = 0
        for line in code.splitlines():
            if start := FUNCTION.match(line):
                function = int(start[1], 16)
                self._names[function] = names.get(function, short(start[2]))
            elif call := _CALL.match(line):
                found.append((int(call[1], 16), function, int(call[2], 16)))
        for address, caller, callee in found:
            if callee in self._names and callee != caller:
                self._callers[callee].append(address)
                self._within[address], self._callee[address] = caller, callee

    def are_called(self, functions: Collection[int]) -> bool:
        return any(self._callers[function] for function in functions)

    def places(self, functions: Collection[int]) -> list[Place]:
        """Where these are called from, except by each other."""
        calls = [
            call
            for function in sorted(functions)
            for call in self._callers[function]
            if self._within[call] not in functions
        ]
        self._read_frames(self._closure(calls))
        found = {place for call in calls for place in self._blamed(call, set())}
        return sorted(found, key=lambda p: (p.node, p.frame.file, p.frame.line, p.callee))

    def _closure(self, calls: Iterable[int]) -> set[int]:
        """These calls, those of the functions that make them, and so on."""
        waiting, found = list(calls), set[int]()
        while waiting:
            call = waiting.pop()
            if call not in found:
                found.add(call)
                waiting += self._callers[self._within[call]]
        return found

    def _blamed(self, call: int, seen: set[int]) -> set[Place]:
        """Up from the call, to the first function that is nobody else's."""
        if call in seen:
            return set()
        seen.add(call)
        frames = self._frames[call]
        callee = self._names[self._callee[call]]
        for frame in frames:
            if frame.is_project:
                nodes = self._nodes(call, set()) or {""}
                return {Place(node, frame, callee) for node in nodes}
            callee = frame.function
        function = self._within[call]
        if not self._callers[function]:
            frame = Frame(self._names[function], frames[-1].file, frames[-1].line)
            node = BEFORE_START if _CONSTRUCTORS.match(frame.function) else ""
            return {Place(node, frame, self._names[self._callee[call]])}
        return {place for above in self._callers[function] for place in self._blamed(above, seen)}

    def _nodes(self, call: int, seen: set[int]) -> set[str]:
        """Whose task leads to the call."""
        if call in seen:
            return set()
        seen.add(call)
        if _CONSTRUCTORS.match(self._names[self._within[call]]):
            return {BEFORE_START}
        tasks = {task[1] for frame in self._frames[call] if (task := _TASK.search(frame.file))}
        above = self._callers[self._within[call]]
        return tasks or {node for other in above for node in self._nodes(other, seen)}

    def _read_frames(self, calls: Collection[int]) -> None:
        """The function that has each call, after those inlined there, the innermost first."""
        wanted = [call for call in calls if call not in self._frames]
        self._frames |= frames_at(self._image, wanted)
        for call in wanted:
            last = self._frames[call][-1]
            if not last.function:  # without debugging information
                name = self._names[self._within[call]]
                self._frames[call][-1] = Frame(name, last.file, last.line)


def frames_at(image: Path, addresses: Iterable[int]) -> dict[int, list[Frame]]:
    """The function that has each instruction, after those inlined there, the innermost first."""
    text = "\n".join(map(hex, addresses))
    lines = run("addr2line", "-a", "-i", "-f", "-C", "-e", str(image), text=text).splitlines()
    found: dict[int, list[Frame]] = {}
    frames: list[Frame] = []
    rows = iter(lines)
    for row in rows:
        if re.fullmatch("0x[0-9a-f]{8}", row):
            frames = found.setdefault(int(row, 16), [])
            continue
        file, _, line = next(rows).partition(" (")[0].rpartition(":")
        known = row != "??"
        number = int(line) if line.isdigit() else 0
        frames.append(Frame(short(row) if known else "", os.path.normpath(file), number))
    return found
