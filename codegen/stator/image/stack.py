"""The worst case of the one stack of an image.

Jobs nest: at most one of each level is active, and each interrupt leaves a frame of what it
interrupts. So the bound is the thread, and of each level the worst of its handlers, each with the
frame that is pushed when the next one interrupts it. A fault pushes one more frame and continues on
a stack of its own."""

from __future__ import annotations

import re
from collections import defaultdict
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.image.calls import frames_at, short
from stator.image.frames import frame_of
from stator.image.functions import read_code
from stator.image.targets import targets_of
from stator.image.tools import addresses, sizes

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence
    from pathlib import Path

    from stator.image.calls import Frame as Inlined
    from stator.image.frames import Call, Frame
    from stator.image.functions import Code

# What an exception pushes (ARMv7-M, B1.5.7): 8 words, 26 with the registers of the FPU, and one to
# align the stack. The room for these is taken even where the FPU's state is saved later.
PLAIN_FRAME = 36
FPU_FRAME = 108
ALIGNMENT = 8
THREAD = 0  # the level of what runs when no handler does
FAULT_STACK = "stator_fault_stack"
_NODE = re.compile(r'^node: \{ title: "(?:[^"]*:)?([^":]+)" label: "([^"]*)"')
_SIZE = re.compile(r"(\d+) bytes \((static|dynamic|dynamic,bounded)\)")


@dataclass(frozen=True)
class Root:
    """A handler, or the thread."""

    level: int
    at: int
    name: str  # of its node, or its function


@dataclass(frozen=True)
class RootStack:
    root: Root
    bytes: int  # without the exception's frame
    uses_fpu: bool
    path: tuple[str, ...]  # the functions of the deepest way

    @property
    def with_frame(self) -> int:
        """And what the next interrupt pushes."""
        return self.bytes + (FPU_FRAME if self.uses_fpu else PLAIN_FRAME)


@dataclass(frozen=True)
class Stack:
    roots: tuple[RootStack, ...]  # the thread first, then by level
    fault: tuple[int, int]  # of the stack of the fault handler: what it needs, and what it has
    limit: int
    faults: tuple[str, ...]  # why it has no bound

    @property
    def bytes(self) -> int:
        """Of all levels, at the worst instant."""
        worst: dict[int, int] = defaultdict(int)
        for row in self.roots:
            worst[row.root.level] = max(worst[row.root.level], row.with_frame)
        return -(-sum(worst.values()) // ALIGNMENT) * ALIGNMENT

    def overflows(self) -> list[str]:
        """One error for each stack that can be too small."""
        rows = (("stack", self.bytes, self.limit), ("fault handler's stack", *self.fault))
        return [
            f"error: the {name} may need {need:,} bytes, and has {limit:,}\n"
            "hint: ./stator prove shows the deepest way of each level; take large variables from "
            "the stack into a node, or give nodes one priority: they then never nest"
            for name, need, limit in rows
            if need > limit
        ]

    def worst_of(self, level: int) -> RootStack:
        rows = (row for row in self.roots if row.root.level == level)
        return max(rows, key=lambda row: row.with_frame)


@dataclass(frozen=True)
class _Depth:
    bytes: int
    uses_fpu: bool
    path: tuple[str, ...]


class _Depths:
    """How deep each function goes, with all that it calls."""

    def __init__(self, image: Path, code: Code, sizes: Mapping[str, tuple[int, str]]) -> None:
        self._image = image
        self._code = code
        self._sizes = sizes
        self._names = _symbols(image)
        self._frames: dict[int, Frame] = {}
        self._found: dict[int, _Depth] = {}
        self._active: list[int] = []
        self._inlined: dict[int, list[Inlined]] = {}
        self.may_switch: frozenset[int] = frozenset()
        self.faults: list[str] = []

    def of(self, at: int) -> _Depth:
        found = self._found.get(at)
        if found is not None:
            return found
        if at in self._active:
            names = [self._shown(a) for a in [*self._active[self._active.index(at) :], at]]
            self._refuse(f"calls itself: {' -> '.join(names)}: the stack has no bound", at)
            return _Depth(0, False, ())
        frame = self._frame(at)
        if frame.switches and at not in self.may_switch:
            self._refuse("moves the stack pointer to another stack", at)
        self._active.append(at)
        below = [(call.depth, self.of(target)) for call, target in self._calls(at, frame)]
        self._active.pop()
        depth = max(
            ((call + d.bytes, d.path) for call, d in below), default=(0, ()), key=lambda row: row[0]
        )
        deepest = max(depth[0], frame.deepest)
        path = depth[1] if depth[0] > frame.deepest else ()
        uses_fpu = frame.uses_fpu or any(d.uses_fpu for _, d in below)
        self._found[at] = _Depth(deepest, uses_fpu, (self._shown(at), *path))
        return self._found[at]

    def resolve_pointers(self, roots: Sequence[Root]) -> None:
        """Looks all calls through pointers up at once: the program that knows takes a second."""
        seen, waiting, pointers = set[int](), [root.at for root in roots], []
        while waiting:
            at = waiting.pop()
            if at in seen or (frame := self._quiet_frame(at)) is None:
                continue
            seen.add(at)
            waiting += [call.target for call in frame.calls if call.target is not None]
            pointers += [call.at for call in frame.calls if call.target is None]
        self._inlined = frames_at(self._image, pointers)

    def _calls(self, at: int, frame: Frame) -> Iterator[tuple[Call, int]]:
        for call in frame.calls:
            if call.target is not None and self._code.function_at(call.target) is None:
                self._refuse("calls what is not a function: its stack has no size", call.at)
                continue
            if call.target is not None:
                yield call, call.target
                continue
            if call.at not in self._inlined:
                self._inlined |= frames_at(self._image, [call.at])
            inlined = self._inlined[call.at]
            targets = targets_of(self._code, inlined)
            if targets is None:
                where = inlined[0]
                self.faults.append(
                    f"{where.place}error: {where.function or self._shown(at)} calls through a "
                    "pointer: the stack has no bound\n"
                    "hint: call the function by its name, or use a switch"
                )
            for target in targets or ():
                yield call, target

    def _quiet_frame(self, at: int) -> Frame | None:
        """Without errors. A function that returns nowhere ends the way that calls it."""
        if at in self._frames or (function := self._code.function_at(at)) is None:
            return self._frames.get(at)
        frame = self._frames[at] = frame_of(self._code, function, at)
        called = {call.target for call in frame.calls if call.target is not None}
        below = {target: self._quiet_frame(target) for target in called}
        ends = frozenset(t for t, found in below.items() if found is not None and not found.returns)
        if ends:
            self._frames[at] = frame_of(self._code, function, at, ends)
        return self._frames[at]

    def _frame(self, at: int) -> Frame:
        frame = self._quiet_frame(at)
        assert frame is not None
        for problem in frame.problems:
            self._refuse(f"{problem}: the stack has no bound", at)
        size = next((self._sizes[n] for n in self._names.get(at, ()) if n in self._sizes), None)
        if size is not None and not frame.problems:
            if size[1] != "static":
                self._refuse("has a frame that grows as it runs (alloca, an array of any size)", at)
            elif frame.deepest > size[0] + frame.arguments and not frame.switches:
                self._refuse(
                    f"has inline assembly that moves the stack pointer: {frame.deepest} bytes, and "
                    f"{size[0]} of the compiler",
                    at,
                )
        return frame

    def _refuse(self, what: str, at: int) -> None:
        place = frames_at(self._image, [at])[at][-1].place
        self.faults.append(f"{place}error: {self._shown(at)} {what}")

    def _shown(self, at: int) -> str:
        function = self._code.function_at(at)
        return hex(at) if function is None else short(function.name)


def stack_of(image: Path, roots: Sequence[Root], fault_handlers: Sequence[int] = ()) -> Stack:
    code = read_code(image)
    depths = _Depths(image, code, compiler_sizes(image))
    depths.may_switch = frozenset(fault_handlers)
    depths.resolve_pointers(roots)
    rows = []
    for root in sorted(roots, key=lambda root: root.level):
        depth = depths.of(root.at)
        rows.append(RootStack(root, depth.bytes, depth.uses_fpu, depth.path))
    fault_bytes = max((depths.of(at).bytes for at in set(fault_handlers)), default=0)
    at = addresses(image)
    return Stack(
        tuple(rows),
        (fault_bytes, sizes(image).get(FAULT_STACK, 0)),
        at.get("stator_stack_end", 0) - at.get("stator_stack_begin", 0),
        tuple(dict.fromkeys(depths.faults)),
    )


def compiler_sizes(image: Path) -> dict[str, tuple[int, str]]:
    """Symbol: bytes of its frame, and whether these are static, as the compiler says
    (-fcallgraph-info=su). Of what is optimised as a whole, the linker's step says it."""
    found = {}
    for file in image.parent.glob(f"{image.name}*.ci"):
        for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
            node = _NODE.match(line)
            size = None if node is None else _SIZE.search(node[2])
            if node is not None and size is not None:
                found[node[1]] = (int(size[1]), size[2])
    return found


def _symbols(image: Path) -> dict[int, list[str]]:
    found: dict[int, list[str]] = defaultdict(list)
    for name, at in addresses(image).items():
        found[at & ~1].append(name)
    return found
