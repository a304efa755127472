"""What a function does to the stack: the depth at each of its instructions, and its calls.

The compiler says how large its frames are (-fstack-usage), but not those of libraries and of
assembly, and not what inline assembly does. So the depth is followed through the instructions, and
the compiler's figure is compared with it."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from stator.image.functions import Code, Function, Instruction

_CONDITIONS = "eq|ne|cs|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le"
_BRANCH = re.compile(rf"^b({_CONDITIONS})?$|^cbn?z$")
_RETURN = re.compile(rf"^(bx|pop|ldr|ldmia)({_CONDITIONS})?$")
_NUMBER = re.compile(r"#(-?\d+)")
_REGISTERS = re.compile(r"\b(r\d+|sl|fp|ip|lr)\b")
_LOADED = re.compile(r"^\(?([0-9a-f]+)\b")
_TABLES = {"tbb": 1, "tbh": 2}
# By the function that is called.
_SAVED = frozenset(("r4", "r5", "r6", "r7", "r8", "r9", "sl", "fp"))
_WORD = 4
Known = tuple[tuple[str, int], ...]  # registers that hold an address


@dataclass(frozen=True)
class Call:
    at: int
    target: int | None  # None: through a pointer
    depth: int  # bytes on the stack when it begins
    is_last: bool  # a branch: it returns to the caller of this function


@dataclass
class Frame:
    deepest: int = 0
    calls: list[Call] = field(default_factory=list)
    uses_fpu: bool = False
    problems: list[str] = field(default_factory=list)
    returns: bool = False
    switches: bool = False  # to another stack, before it uses this one
    arguments: int = 0  # in registers, which it puts beside those on the stack


@dataclass(frozen=True)
class _State:
    depth: int
    known: Known = ()


class _Walk:
    def __init__(self, code: Code, function: Function, at: int, ends: frozenset[int]) -> None:
        self._code = code
        self._at = at
        self._function = function
        self._ends = ends  # functions that do not return
        self._seen: dict[int, _State] = {}
        self._waiting: list[int] = []
        self._falls: list[Call] = []  # into the next function, as libraries do
        self.frame = Frame()

    def run(self) -> Frame:
        frame = self.frame
        frame.uses_fpu = any(i.name.startswith("v") for i in self._function.code.values())
        self._reach(self._at, _State(0))
        while self._waiting:
            at = self._waiting.pop()
            self._step(self._function.code[at], self._seen[at])
        frame.arguments = self._stored_arguments()
        frame.problems = list(dict.fromkeys(frame.problems))
        frame.calls = self._calls()
        return frame

    def _stored_arguments(self) -> int:
        """Where an argument is partly on the stack, the function begins with room for the rest.
        The compiler does not count it to its frame."""
        order = self._function.order[:2]
        first, *then = (self._function.code[at] for at in order)
        number = _NUMBER.search(first.operands)
        is_push = any(i.name == "push" or i.operands.startswith("sp!") for i in then)
        if first.name != "sub" or not first.operands.startswith("sp") or number is None:
            return 0
        return int(number[1]) if is_push else 0

    def _calls(self) -> list[Call]:
        """Of the last states."""
        found = list(self._falls)
        for at, state in self._seen.items():
            instruction = self._function.code[at]
            call = self._call(instruction, state)
            if call is not None:
                found.append(call)
        return found

    def _reach(self, at: int | None, state: _State, *, is_table: bool = False) -> None:
        if at is None or at not in self._function.code:
            return
        old = self._seen.get(at)
        if old is None:
            self._seen[at] = state
        else:
            if old.depth != state.depth:
                if not is_table:
                    self.frame.problems.append("the depth of the stack differs between two ways")
                return
            known = tuple(sorted(set(old.known) & set(state.known)))
            if known == old.known:
                return
            self._seen[at] = _State(old.depth, known)
        self.frame.deepest = max(self.frame.deepest, state.depth)
        self._waiting.append(at)

    def _step(self, i: Instruction, state: _State) -> None:
        after = self._function.after(i.at)
        call = self._call(i, state)
        if call is not None:
            if not call.is_last and call.target not in self._ends:
                self._reach(after, _State(state.depth, _kept(state.known)))
            elif call.is_last and i.name not in ("b", "bx"):
                self._reach(after, state)
            self.frame.returns |= call.is_last and call.target not in self._ends
            return
        if _BRANCH.match(i.name):
            target = int(i.operands.split(",")[-1].split()[0], 16)
            self._reach(target, state)
            if i.name != "b":
                self._reach(after, state)
            return
        if i.name in _TABLES or (i.name == "ldr" and i.operands.startswith("pc, [r")):
            for target in self._table(i, state):
                self._reach(target, state, is_table=True)
            return
        if i.name == "udf":
            return
        if self._is_return(i):
            self.frame.returns = True
            if i.name not in ("bx", "pop", "ldr", "ldmia"):
                self._reach(after, state)
            return
        new = _State(self._depth(i, state.depth), self._known(i, state.known))
        if after is None:
            following = next((i.at + n for n in (2, 4) if i.at + n in self._code.functions), None)
            if following is not None:
                self._falls.append(Call(i.at, following, new.depth, True))
                self.frame.returns = True
        self._reach(after, new)

    def _is_return(self, i: Instruction) -> bool:
        match = _RETURN.match(i.name)
        if match is None:
            return False
        if match[1] == "bx":
            return i.operands == "lr"
        return re.search(r"^pc\b|\bpc\}", i.operands) is not None

    def _call(self, i: Instruction, state: _State) -> Call | None:
        known = dict(state.known)
        if i.name == "blx" or (i.name.startswith("bx") and i.operands != "lr"):
            return Call(i.at, known.get(i.operands), state.depth, i.name != "blx")
        if i.name == "bl":
            return Call(i.at, int(i.operands.split()[0], 16), state.depth, False)
        if _BRANCH.match(i.name):
            target = int(i.operands.split(",")[-1].split()[0], 16)
            if target not in self._function.code:
                return Call(i.at, target, state.depth, True)
        return None

    def _depth(self, i: Instruction, depth: int) -> int:
        """After the instruction."""
        change = self._change(i, depth)
        if change is None:
            self.frame.problems.append(f"moves the stack pointer: {i.name} {i.operands}")
            return depth
        return depth + change

    def _change(self, i: Instruction, depth: int) -> int | None:
        """Bytes that it adds to the stack."""
        first, _, rest = i.operands.partition(",")
        name = i.name
        if name in ("push", "vpush"):
            return _listed(i.operands)
        if name in ("pop", "vpop"):
            return -_listed(i.operands)
        if first == "sp!":
            return _listed(rest) * (1 if name in ("stmdb", "vstmdb") else -1)
        if "[sp, #" in i.operands and i.operands.endswith("]!"):
            number = _NUMBER.search(i.operands.partition("[sp")[2])
            return None if number is None else -int(number[1])
        if "[sp], #" in i.operands:
            number = _NUMBER.search(i.operands.partition("[sp]")[2])
            return None if number is None else -int(number[1])
        if first != "sp" or name.startswith(("cmp", "tst", "str", "stm", "ldm")):
            if name == "msr" and first.lower() == "msp":
                self.frame.switches = depth == 0
                return 0 if depth == 0 else None
            return 0
        number = _NUMBER.search(rest)
        if number is None or name not in ("add", "addw", "sub", "subw") or "r" in rest:
            return None
        return int(number[1]) * (1 if name.startswith("sub") else -1)

    def _known(self, i: Instruction, known: Known) -> Known:
        """A register that an instruction names keeps no address: few do more than load and call."""
        named = set(_REGISTERS.findall(i.operands))
        rest = tuple(row for row in known if row[0] not in named) if named else known
        if i.name == "ldr" and "[pc" in i.operands:
            loaded = _LOADED.match(i.note)
            value = None if loaded is None else self._code.memory.read(int(loaded[1], 16), _WORD)
            register = i.operands.partition(",")[0]
            if value is not None and value & 1 and (value & ~1) in self._code.functions:
                return tuple(sorted((*rest, (register, value & ~1))))
        if "(adr " in f"({i.note}":
            register, _, at = i.note.removeprefix("(").removeprefix("adr ").partition(", ")
            return tuple(sorted((*rest, (register, int(at.split()[0], 16)))))
        if i.name == "mov" and "#" not in i.operands:
            to, _, source = i.operands.partition(", ")
            value = dict(known).get(source)
            if value is not None:
                return tuple(sorted((*(r for r in known if r[0] != to), (to, value))))
        return rest

    def _table(self, i: Instruction, state: _State) -> list[int]:
        """Where a branch by a table can go."""
        code, read = self._function.code, self._code.memory.read
        found = []
        if i.name in _TABLES:
            size, base = _TABLES[i.name], i.at + 4
            at = base
            while at not in code and (value := read(at, size)) is not None:
                found.append(base + 2 * value)
                at += size
        else:
            at = dict(state.known).get(i.operands[len("pc, [") :].split(",")[0], 0)
            while (value := read(at, _WORD)) is not None and value & 1 and value - 1 in code:
                found.append(value - 1)
                at += _WORD
        if not found:
            self.frame.problems.append("branches by a table that is not known")
        return found


def _listed(text: str) -> int:
    """Bytes of a list of registers."""
    inner = text[text.index("{") + 1 : text.index("}")]
    total = 0
    for part in inner.split(","):
        first, _, last = part.strip().partition("-")
        count = 1 if not last else int(last[1:]) - int(first[1:]) + 1
        total += count * (8 if first.startswith("d") else 4)
    return total


def _kept(known: Known) -> Known:
    return tuple(row for row in known if row[0] in _SAVED)


def frame_of(code: Code, function: Function, at: int, ends: frozenset[int] = frozenset()) -> Frame:
    """From the instruction at `at`: libraries jump into the middle of their functions. `ends`:
    functions that do not return."""
    return _Walk(code, function, at, ends).run()
