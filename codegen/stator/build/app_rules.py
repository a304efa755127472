"""The rules of nodes, checked on their object files: no heap, no exceptions, no libm, no clock, no
variables that outlive or outrank the node. The images of firmware are checked as a whole besides.

    python -m stator.build.app_rules --node FOLDER ... --stamp FILE OBJECT ...
"""

from __future__ import annotations

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from stator import HOME
from stator.diagnostics import ANSWER_IS_NO, Error, Mark
from stator.image.checks import LIBM
from stator.processes import environment

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

MEMBER = "use members of a fixed size, such as std::array"
# What a node must not call: what it is, and what to use.
CALLS = (
    (r"malloc|calloc|realloc|free|aligned_alloc|_Zn[wa]\w*|_Zd[la]\w*", "the heap", MEMBER),
    (
        r"__cxa_(throw|allocate_exception|begin_catch)|_ZSt\d+__throw_\w+|__gxx_personality_v0",
        "exceptions",
        "check before, and publish or hold what is right then",
    ),
    (
        r"clock(_gettime)?|gettimeofday|time|_ZNSt6chrono\w+3nowEv",
        "a clock",
        "use ports.now, or a sample's timestamp",
    ),
    (r"s?rand(om)?|drand48", "random numbers of the machine", "use stator/random.hpp"),
)
LIBM_WHY = "libm, whose bits differ between machines"
STATE = "make it a member of the node's class: it then starts with the node, and is replayed"
_UNDEFINED = re.compile(r"^(?P<object>.+):\s+[Uw] (?P<symbol>\S+)$")
# Of `objdump -t`; constants with pointers in them lie in .data.rel.ro.
_WRITABLE = re.compile(
    r"\bO \.t?(?:data|bss)(?!\.rel\.ro)\S*\s+[0-9a-f]+\s+(?:\.hidden )?(?P<symbol>_Z\S+)$",
    re.MULTILINE,
)
_SECTION = re.compile(r"^Relocation section '\.rela?(?P<name>\.text\S*)'")
_RELOCATION = re.compile(
    r"^(?P<offset>[0-9a-f]{8,})\s+[0-9a-f]+\s+R_\S+\s+[0-9a-f]+ (?P<symbol>\S+)"
)
_OF_APP = re.compile(r"stator::apps::(?P<app>\w+)::(?P<rest>.*)")


class Call(NamedTuple):
    symbol: str
    what: str
    hint: str


def forbidden(symbol: str) -> Call | None:
    """What a call of this symbol is, if a node must not make it."""
    name = symbol.partition("@")[0]
    for pattern, what, hint in CALLS:
        if re.fullmatch(pattern, name):
            return Call(symbol, what, hint)
    if name in LIBM:
        return Call(symbol, f"{name} of {LIBM_WHY}", _ours(name))
    return None


def _ours(name: str) -> str:
    """The function to use in place of one of libm."""
    plain = name if name.removesuffix("f") not in LIBM else name.removesuffix("f")
    for header in ("scalar.hpp", "math/square_root.hpp", "math/rounding.hpp", "math/bits.hpp"):
        text = (HOME / "runtime" / "math" / "stator" / header).read_text(encoding="utf-8")
        if re.search(rf"\b{plain}\(", text):
            return f"use stator::math::{plain} of stator/{header}"
    return "stator/scalar.hpp lists the functions that a node may use"


def errors_of(objects: Iterable[Path], folders: Iterable[Path]) -> list[Error]:
    """Each call and variable in the apps' folders that breaks a rule, in order of position."""
    apps = [folder.resolve() for folder in folders]
    paths = [str(path) for path in objects]
    lines = _output(["nm", "-A", *paths]).splitlines()
    called: dict[str, dict[str, Call]] = {}
    found: dict[tuple[Mark, str], Error] = {}
    for match in filter(None, map(_UNDEFINED.match, lines)):
        call = forbidden(match["symbol"])
        if call is not None:
            called.setdefault(match["object"], {})[call.symbol] = call
    for path, calls in called.items():
        for mark, call in _places(path, calls, apps):
            message = f"{_app_of(mark.file, apps)} uses {call.what}"
            found.setdefault((mark, message), Error(mark, "wall", message, call.hint))
    writable = dict.fromkeys(_WRITABLE.findall(_output(["objdump", "-t", *paths])))
    for error in _variables(list(writable), apps):
        found.setdefault((error.mark, error.message), error)
    return [found[key] for key in sorted(found)]


def _places(path: str, calls: dict[str, Call], apps: list[Path]) -> Iterator[tuple[Mark, Call]]:
    """Where the object calls them: lines of an app."""
    section = ""
    by_section: dict[str, list[tuple[str, Call]]] = {}
    for line in _output(["readelf", "-rW", path]).splitlines():
        head, relocation = _SECTION.match(line), _RELOCATION.match(line)
        if line.startswith("Relocation section"):
            section = head["name"].rstrip("'") if head else ""
        elif relocation is not None and section and relocation["symbol"] in calls:
            place = (relocation["offset"], calls[relocation["symbol"]])
            by_section.setdefault(section, []).append(place)
    for name, places in by_section.items():
        command = ["addr2line", "-a", "-i", "-j", name, "-e", path]
        output = _output([*command, *(f"0x{offset}" for offset, _ in places)])
        blocks = re.split(r"^0x[0-9a-f]+\n", output, flags=re.MULTILINE)[1:]
        for block, (_, call) in zip(blocks, places, strict=True):
            mark = _mark_in_app(block.splitlines(), Path(path), apps, call)
            if mark is not None:
                yield mark, call


def _mark_in_app(frames: list[str], path: Path, apps: list[Path], call: Call) -> Mark | None:
    """The innermost line of an app, with the column of what it calls if that can be seen."""
    build = next((p for p in path.parents if (p / "CMakeCache.txt").is_file()), path.parent)
    for frame in frames:
        name, _, number = frame.partition(" (")[0].rpartition(":")
        file = Path(os.path.realpath(build / name))
        if number.isdigit() and any(file.is_relative_to(app) for app in apps):
            return Mark(file, int(number), _column(file, int(number), call.symbol))
    return None


def _column(file: Path, number: int, symbol: str) -> int:
    lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
    line = lines[number - 1] if number <= len(lines) else ""
    words = [re.escape(symbol.removesuffix("f")), "new", "delete", r"\S"]
    at = next((m.start() for word in words if (m := re.search(word, line))), 0)
    return at + 1


def _variables(symbols: list[str], apps: list[Path]) -> Iterator[Error]:
    """Variables that do not belong to an object of the node's class."""
    names = _output(["c++filt", *symbols]).splitlines() if symbols else []
    by_name = {app.name: app for app in apps}
    for symbol, name in zip(symbols, names, strict=True):
        match = _OF_APP.fullmatch(name.removeprefix("guard variable for "))
        if match is None or match["app"] not in by_name or symbol.startswith(("_ZTV", "_ZGV")):
            continue
        variable = re.split(r"::", re.sub(r"\[abi:\w+\]", "", match["rest"]))[-1]
        if _is_constant(variable, by_name[match["app"]]):
            continue
        is_local = symbol.startswith("_ZZ")
        what = "the function static" if is_local else "the global variable"
        message = f"{match['app']} has {what} '{variable}'"
        yield Error(_mark_of(variable, by_name[match["app"]]), "wall", message, STATE)


def _is_constant(variable: str, folder: Path) -> bool:
    """Also a constant can lie in writable memory, if it has pointers in it."""
    declared = re.compile(rf"\bconst(?:expr)?\b[^;()]*\b{re.escape(variable)}\b")
    files = folder.rglob("*.[ch]pp")
    return any(declared.search(file.read_text(encoding="utf-8")) for file in files)


def _mark_of(variable: str, folder: Path) -> Mark:
    """Where the app's code first names it; a line with `static` before others."""
    found = [
        (not re.search(r"\bstatic\b", line), Mark(file, number, match.start() + 1))
        for file in sorted(folder.rglob("*.[ch]pp"))
        for number, line in enumerate(file.read_text(encoding="utf-8").splitlines(), 1)
        if (match := re.search(rf"\b{re.escape(variable)}\b", line.partition("//")[0]))
    ]
    return min(found, default=(True, Mark(folder / f"{folder.name}.hpp", 1, 1)))[1]


def _app_of(file: Path, apps: list[Path]) -> str:
    return next(app.name for app in apps if file.is_relative_to(app))


def _output(command: list[str]) -> str:
    finished = subprocess.run(
        command, env=environment(), check=True, capture_output=True, text=True
    )
    return finished.stdout


def main(arguments: list[str]) -> int:
    parser = argparse.ArgumentParser(prog="stator.build.app_rules")
    parser.add_argument("--node", type=Path, action="append", default=[])
    parser.add_argument("--stamp", type=Path, required=True)
    parser.add_argument("objects", type=Path, nargs="*")
    parsed = parser.parse_args(arguments)
    errors = errors_of(parsed.objects, parsed.node)
    if errors:
        print("\n\n".join(error.text() for error in errors), file=sys.stderr)
        return ANSWER_IS_NO
    parsed.stamp.touch()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
