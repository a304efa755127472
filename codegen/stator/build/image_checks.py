"""The rules of images, checked on symbols and instructions instead of the source."""

from __future__ import annotations

import re
import subprocess
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

TOOLS = "arm-none-eabi-"

# Forbidden symbols, and what they mean.
DOUBLE = (
    r"__aeabi_(d\w+|[filu]+2d|f2d|h2d)|__\w+df[23]|__\w+didf|__\w+sidf"
    r"|__truncdfsf2|__extendsfdf2"
)
FORBIDDEN = {
    r"_?(malloc|calloc|realloc|free|sbrk)(_r)?|_Zn[wa]\w*|_Zd[la]\w*": "the heap",
    r"__cxa_(throw|begin_catch|rethrow)|_Unwind_\w+|__gxx_personality_v0": "exceptions",
    r"_ZT[IS]\w+": "run-time type information",
    r"_ZGV\w+|__cxa_guard_\w+": "a guard variable",
    DOUBLE: "double precision, which this chip has no instructions for",
}
# The names of newlib's libm. Our own functions are in stator::math, never plain C names.
NAMES = """acos acosh asin asinh atan atan2 atanh cbrt ceil copysign cos cosh erf erfc exp exp2
    expm1 fabs fdim floor fma fmax fmin fmod frexp hypot ilogb ldexp lgamma llrint llround log log10
    log1p log2 logb lrint lround modf nearbyint nextafter pow remainder remquo rint round scalbln
    scalbn sin sinh sincos sqrt tan tanh tgamma trunc"""
LIBM = frozenset(f"{name}{suffix}" for suffix in ("", "f", "l") for name in NAMES.split())
# PRIMASK and FAULTMASK mask interrupts that touch no topic, too. CPS and MSR write them.
MASKS = re.compile(r"\t(cps(id|ie)\b|msr\s+(primask|faultmask)\b)", re.IGNORECASE)
BASEPRI = re.compile(r"\tmsr\s+basepri(_max)?\b", re.IGNORECASE)
FUNCTION = re.compile(r"^[0-9a-f]+ <(.+)>:$")
# Of topics that several levels publish (emit/templates/topics.cpp.j2).
SECTION = re.compile(
    r"stator::topics::(?P<topic>\w+)_parts::(?P<operation>loan|commit|is_due)_in_section\("
)
# boards/stm32f4/dma.hpp, and the generated linker script.
DMA_BUFFER = "stator::stm32f4::DmaBuffer<"
STACK = ("stator_stack_begin", "stator_stack_end")


def faults_of(image: Path) -> list[str]:
    """One line for each rule that the image breaks."""
    return [*_symbol_faults(image), *_instruction_faults(image), *_dma_faults(image)]


def _dma_faults(image: Path) -> list[str]:
    """DMA does not reach the core-coupled memory, which holds the stack only."""
    symbols = [line.split(maxsplit=2) for line in _run("nm", "-C", str(image)).splitlines()]
    at = {parts[2]: int(parts[0], 16) for parts in symbols if len(parts) == 3}
    stack = range(at.get(STACK[0], 0), at.get(STACK[1], 0))
    return [
        f"DMA cannot reach {name}: it is in the memory of the stack"
        for name, address in at.items()
        if name.startswith(DMA_BUFFER) and address in stack
    ]


def _symbol_faults(image: Path) -> list[str]:
    names = [line.split()[-1] for line in _run("nm", str(image)).splitlines() if line.split()]
    faults = [
        f"the image uses {name}: {why}"
        for name in names
        for pattern, why in FORBIDDEN.items()
        if re.fullmatch(pattern, name)
    ]
    return faults + [
        f"the image uses {name}: a libm function, whose bits differ between machines"
        for name in names
        if name in LIBM
    ]


def _instruction_faults(image: Path) -> list[str]:
    faults = []
    function = ""
    for line in _run("objdump", "-d", "-C", "--no-show-raw-insn", str(image)).splitlines():
        start = FUNCTION.match(line)
        if start:
            function = start.group(1)
        elif MASKS.search(line):
            faults.append(f"{function} masks all interrupts: {' '.join(line.split()[1:])}")
        elif BASEPRI.search(line) and not SECTION.match(function):
            faults.append(f"{function} writes BASEPRI: only topic operations may")
    return faults


def sections_of(image: Path) -> dict[str, dict[str, int]]:
    """Topic -> operation -> instructions with BASEPRI raised, on the longest path."""
    found: dict[str, dict[str, int]] = {}
    code = _run("objdump", "-d", "-C", "--no-show-raw-insn", str(image))
    for text in code.split("\n\n"):
        head, _, body = text.partition("\n")
        start = FUNCTION.match(head)
        name = SECTION.match(start.group(1)) if start else None
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


def _run(tool: str, *arguments: str) -> str:
    return subprocess.run(
        [TOOLS + tool, *arguments], check=True, capture_output=True, text=True
    ).stdout
