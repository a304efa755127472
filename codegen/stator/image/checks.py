"""The rules of images, checked on symbols and instructions instead of the source.

These chips have no instructions for double precision: a library computes it. The compiler refuses
implicit double precision (-Wdouble-promotion). This file refuses the explicit one, except in nodes
whose interface says why they need it, and in constructors, which run before the flight."""

from __future__ import annotations

import re
from collections import defaultdict
from pathlib import Path
from typing import TYPE_CHECKING

from stator.diagnostics import shown_path
from stator.image.calls import BEFORE_START, FUNCTION, Calls, Place
from stator.image.tools import run

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from stator.graph.model import Node

# Forbidden symbols, and what they mean.
DOUBLE = (
    r"__aeabi_(c?d\w+|[filu]+2d|f2d|h2d)|__\w+df[23]|__\w+didf|__\w+sidf"
    r"|__truncdfsf2|__extendsfdf2"
)
FORBIDDEN = {
    r"_?(malloc|calloc|realloc|free|sbrk)(_r)?|_Zn[wa]\w*|_Zd[la]\w*": "the heap",
    r"__cxa_(throw|begin_catch|rethrow)|_Unwind_\w+|__gxx_personality_v0": "exceptions",
    r"_ZT[IS]\w+": "run-time type information",
    r"_ZGV\w+|__cxa_guard_\w+": "a guard variable",
    DOUBLE: "double precision, which this chip has no instructions for",
}
LIBM_WHY = "a libm function, whose bits differ between machines"
CALLEES_SHOWN = 3
# The names of newlib's libm. Our own functions are in stator::math, never plain C names.
NAMES = """acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2
    expm1 fabs fdim floor fma fmax fmin fmod frexp hypot ilogb ldexp lgamma llrint llround log log10
    log1p log2 logb lrint lround modf nearbyint nextafter pow remainder remquo rint round scalbln
    scalbn sin sinh sincos sqrt tan tanh tgamma trunc"""
LIBM = frozenset(f"{name}{suffix}" for suffix in ("", "f", "l") for name in NAMES.split())
# PRIMASK and FAULTMASK mask interrupts that touch no topic, too. CPS and MSR write them.
MASKS = re.compile(r"\t(cps(id|ie)\b|msr\s+(primask|faultmask)\b)", re.IGNORECASE)
BASEPRI = re.compile(r"\tmsr\s+basepri(_max)?\b", re.IGNORECASE)
# Of topics that several levels publish (emit/templates/topics.cpp.j2).
SECTION = re.compile(
    r"stator::topics::(?P<topic>\w+)_parts::(?P<operation>loan|commit|is_due)_in_section\("
)
# boards/stm32f4/dma.hpp, and the generated linker script.
DMA_BUFFER = "stator::stm32f4::DmaBuffer<"
STACK = ("stator_stack_begin", "stator_stack_end")


def faults_of(image: Path, nodes: Mapping[str, Node] | None = None) -> list[str]:
    """One error for each rule that the image breaks, or for each function that breaks it.
    `nodes`: the nodes of the graph."""
    code = _code(image)
    faults = [*_symbol_faults(image, code, nodes or {}), *_instruction_faults(code)]
    return [*faults, *_dma_faults(image)]


def double_lines(image: Path) -> dict[str, int]:
    """Node -> the number of its source lines that compute in double precision, in a library."""
    found: dict[str, set[tuple[str, int]]] = defaultdict(set)
    symbols = _symbols(image)
    doubles = {address for address, name in symbols if re.fullmatch(DOUBLE, name)}
    if doubles:
        for place in _calls(image, _code(image), symbols).places(doubles):
            found[place.node].add((place.frame.file, place.frame.line))
    found.pop(BEFORE_START, None)
    return {node: len(lines) for node, lines in found.items()}


def _dma_faults(image: Path) -> list[str]:
    """DMA does not reach the core-coupled memory, which holds the stack only."""
    symbols = [line.split(maxsplit=2) for line in run("nm", "-C", str(image)).splitlines()]
    at = {parts[2]: int(parts[0], 16) for parts in symbols if len(parts) == 3}
    stack = range(at.get(STACK[0], 0), at.get(STACK[1], 0))
    return [
        f"error: DMA cannot reach {name}: it is in the memory of the stack"
        for name, address in at.items()
        if name.startswith(DMA_BUFFER) and address in stack
    ]


def _symbol_faults(image: Path, code: str, nodes: Mapping[str, Node]) -> list[str]:
    broken: dict[str, dict[str, int]] = defaultdict(dict)  # why: name: address
    symbols = _symbols(image)
    for address, name in symbols:
        for pattern, why in FORBIDDEN.items():
            if re.fullmatch(pattern, name):
                broken[why][name] = address
        if name in LIBM:
            broken[LIBM_WHY][name] = address
    if not broken:
        return []
    calls = _calls(image, code, symbols)
    faults = []
    for why, names in broken.items():
        functions = set(names.values())
        places = calls.places(functions)
        if not calls.are_called(functions):
            faults += [f"error: the image uses {name}: {why}" for name in names]
        elif why == FORBIDDEN[DOUBLE]:
            allowed = {name for name, node in nodes.items() if node.interface.double_precision}
            refused = (p for p in places if p.node not in allowed and p.node != BEFORE_START)
            faults += _callers(refused, why, nodes, is_double=True)
        else:
            faults += _callers(places, why, nodes)
    return faults


def _callers(
    places: Iterable[Place], why: str, nodes: Mapping[str, Node], *, is_double: bool = False
) -> list[str]:
    """An error for each function, at its first line with a forbidden call."""
    functions: dict[tuple[str, str, str], list[Place]] = defaultdict(list)
    for place in places:
        functions[place.node, place.frame.function, place.frame.file].append(place)
    faults = []
    for (name, function, file), calls in functions.items():
        line = calls[0].frame.line
        callees = list(dict.fromkeys(call.callee for call in calls))
        shown = ", ".join(callees[:CALLEES_SHOWN])
        if len(callees) > CALLEES_SHOWN:
            shown += f" and {len(callees) - CALLEES_SHOWN} more"
        where = f"{shown_path(Path(file))}:{line}: " if line else ""
        whose = f" of node '{name}'" if name in nodes else f" {name}" if name else ""
        fault = f"{where}error: {function}{whose} calls {shown}: {why}"
        faults.append(fault + (_double_hint(nodes.get(name)) if is_double else ""))
    return faults


def _double_hint(node: Node | None) -> str:
    hint = "\nhint: compute in float (1.0F, not 1.0), and use the functions of stator::math"
    if node is None:
        return hint
    interface = shown_path(node.interface.file)
    return f"{hint}; if only double is precise enough, write `double_precision: WHY` in {interface}"


def _symbols(image: Path) -> list[tuple[int, str]]:
    rows = (line.split() for line in run("nm", str(image)).splitlines())
    return [(int(row[0], 16) & ~1, row[-1]) for row in rows if len(row) == 3]


def _calls(image: Path, code: str, symbols: list[tuple[int, str]]) -> Calls:
    """Prefers the names of Arm's run-time ABI, which are clearer."""
    names = {address: name for address, name in symbols if name.startswith("__aeabi_")}
    return Calls(image, code, names)


def _code(image: Path) -> str:
    return run("objdump", "-d", "-C", "--no-show-raw-insn", str(image))


def _instruction_faults(code: str) -> list[str]:
    faults = []
    function = ""
    for line in code.splitlines():
        start = FUNCTION.match(line)
        if start:
            function = start.group(2)
        elif MASKS.search(line):
            faults.append(f"error: {function} masks all interrupts: {' '.join(line.split()[1:])}")
        elif BASEPRI.search(line) and not SECTION.match(function):
            faults.append(f"error: {function} writes BASEPRI: only topic operations may")
    return faults


def sections_of(image: Path) -> dict[str, dict[str, int]]:
    """Topic -> operation -> instructions with BASEPRI raised, on the longest path."""
    found: dict[str, dict[str, int]] = {}
    for text in _code(image).split("\n\n"):
        head, _, body = text.partition("\n")
        start = FUNCTION.match(head)
        name = SECTION.match(start.group(2)) if start else None
        if name:
            found.setdefault(name["topic"], {})[name["operation"]] = _longest_section(body)
    return {topic: dict(sorted(found[topic].items())) for topic in sorted(found)}


_INSTRUCTION = re.compile(r"^ *([0-9a-f]+):\t(\S+)(?:\t(.*))?$")
_BRANCH = re.compile(r"^(b|cbn?z)(eq|ne|cs|cc|mi|pl|vs|vc|hi|ls|ge|lt|gt|le)?(\.[nw])?$")
_ENDS = ("bl", "bx", "pop", "udf", ".word")  # a call inside a section is a call of `fail`


def _longest_section(body: str) -> int:
    """Instructions from the write that raises BASEPRI to the one that restores it, the longest
    path."""
    lines = [match.groups() for match in map(_INSTRUCTION.match, body.splitlines()) if match]
    index = {int(at, 16): i for i, (at, _, _) in enumerate(lines)}

    def longest(i: int, depth: int) -> int:
        if i >= len(lines) or depth > len(lines):
            return 0
        _, name, operands = lines[i]
        if name == "msr" and (operands or "").upper().startswith("BASEPRI,"):
            return 1
        if name in _ENDS:
            return 0
        next_ones = [i + 1]
        branch = _BRANCH.match(name)
        if branch:
            target = index[int((operands or "").split("<")[0].split(",")[-1].strip(), 16)]
            always = branch[1] == "b" and branch[2] is None
            next_ones = [target] if always else [i + 1, target]
        ways = [longest(n, depth + 1) for n in next_ones]
        return max(ways) + 1 if max(ways) else 0

    raised = [
        i
        for i, (_, name, operands) in enumerate(lines)
        if name == "msr" and (operands or "").upper().startswith("BASEPRI_MAX")
    ]
    return max((longest(i + 1, 0) for i in raised), default=0)
