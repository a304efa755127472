"""What an app, a driver or a board may include, and where it may declare.

The build checks it before it compiles: include folders cannot refuse `../`, nor the standard
library.

    python -m stator.build.walls --node FOLDER PORTS ... --board FOLDER --stamp FILE

PORTS is the folder of the node's generated ports, which name its messages.
"""

# ruff: noqa: SIM905 - words read best as words
from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from stator import HOME
from stator.build.cpp_scan import Source
from stator.diagnostics import ANSWER_IS_NO, Error, Mark, nearest
from stator.names import upper_camel

if TYPE_CHECKING:
    from collections.abc import Iterator

    from stator.build.cpp_scan import Include

# Rooms of the runtime that a node sees. Its ports include others, which are not for it.
ROOMS = ("core", "math", "dronecan", "mavlink", "bytes")
OF_DRIVERS = ("machines",)  # those that only drivers see

# A driver's part of the simulated world, which generated code includes.
OF_WORLD = "_world.hpp"

# The standard library without clocks, input and output, allocation, threads and libm.
STANDARD = frozenset(
    """algorithm array bit bitset cfloat charconv cinttypes climits compare concepts cstddef cstdint
    cstring initializer_list iterator limits numbers numeric optional ranges ratio span string_view
    tuple type_traits utility variant version float.h inttypes.h limits.h stdbool.h stddef.h
    stdint.h string.h""".split()
)
PRINTING = ("cstdio", "stdio.h")
# Why another header is refused, and what to use.
_REASONS = (
    ("reads a clock", "use ports.now, or a sample's timestamp", "chrono ctime time.h sys/time.h"),
    (
        "does input or output",
        "publish a message; only a driver does input and output (nodes may print, by <cstdio>, on "
        "boards of this machine)",
        """cstdio stdio.h iostream istream ostream fstream sstream spanstream streambuf ios iosfwd
        iomanip syncstream filesystem print locale clocale csignal signal.h cstdlib stdlib.h
        unistd.h fcntl.h""",
    ),
    (
        "waits or shares",
        "publish a message; the graph says what runs when",
        """thread mutex shared_mutex condition_variable future semaphore latch barrier stop_token
        atomic stdatomic.h pthread.h coroutine execution""",
    ),
    (
        "allocates",
        "use std::array, std::span or std::string_view",
        """any deque forward_list functional list map memory memory_resource new queue regex
        scoped_allocator set stack string unordered_map unordered_set valarray vector""",
    ),
    (
        "gives other bits on other machines",
        "use stator/scalar.hpp or stator/random.hpp",
        "cmath math.h cfenv fenv.h complex complex.h random tgmath.h ctgmath",
    ),
)


class Room(NamedTuple):
    """Where a file lies, as its folders' names say."""

    kind: str  # app, driver, board; empty: another place
    folder: Path

    @property
    def name(self) -> str:
        depth = 3 if self.kind == "driver" else 2
        return "/".join(self.folder.parts[-depth:])


class Node(NamedTuple):
    folder: Path
    ports: Path

    @property
    def kind(self) -> str:
        return "app" if self.folder.parent.name == "apps" else "driver"

    @property
    def room(self) -> Room:
        return Room(self.kind, self.folder)

    @property
    def sources(self) -> list[Path]:
        """What is compiled, or included from outside."""
        of_world = sorted(self.folder.glob(f"*{OF_WORLD}"))
        return [*sorted(self.folder.glob("*.cpp")), self.header, *of_world]

    @property
    def header(self) -> Path:
        stem = self.room.name.split("/", 1)[1].replace("/", "_")
        return self.folder / f"{stem}.hpp"

    def namespace(self, file: Path) -> tuple[str, ...]:
        """Its folder's. What all drivers of a class share lies beside the class's interface."""
        names = self.room.name.split("/")
        if self.kind == "driver" and file.parent == self.folder.parent:
            names = names[:-1]
        return ("stator", *names)

    def owns(self, file: Path) -> bool:
        if file.is_relative_to(self.folder):
            return True
        return self.kind == "driver" and file.parent == self.folder.parent


def room_of(file: Path) -> Room:
    """The innermost room around a file."""
    for folder in file.parents:
        above = folder.parent
        if above.name == "apps":
            return Room("app", folder)
        if above.parent.name == "drivers":
            return Room("driver", folder)
        if above.name == "boards" and (folder / "board.yaml").is_file():
            return Room("board", folder)
    return Room("", file.parent)


def _rooms_for(kind: str) -> tuple[str, ...]:
    return (*ROOMS, *OF_DRIVERS) if kind == "driver" else ROOMS


class Walls:
    """Collects errors, and every file that was read."""

    def __init__(self, *, may_print: bool = False) -> None:
        """`may_print`: nodes may print, which is for debugging on this machine."""
        self._may_print = may_print
        self.errors: list[Error] = []
        self.files: dict[Path, None] = {}

    def check_node(self, node: Node) -> None:
        messages = {
            include.name
            for ports in sorted(node.ports.glob("*.hpp"))
            for include in Source(ports).includes()
        }
        todo = [file.resolve() for file in node.sources if file.is_file()]
        seen: set[Path] = set()
        while todo:
            file = todo.pop()
            if file in seen:
                continue
            seen.add(file)
            source = self._read(file)
            for include in source.includes():
                found = _own_file(include, file, node.folder)
                if found is not None and node.owns(found):
                    todo.append(found)
                elif not (file.name.endswith(OF_WORLD) and include.name.startswith("world/")):
                    self._check_include(include, found, node, messages)
            own = node.namespace(file)
            for outside in source.outside(own):
                place = f"namespace {outside.namespace}" if outside.namespace else "no namespace"
                self._error(
                    outside.mark,
                    f"expected namespace {'::'.join(own)}, found {place}: {outside.words}",
                    f"write `namespace {'::'.join(own)} {{` around it: code of another node that "
                    "has the same name cannot take its place there",
                )
                break  # the others of this file have the same cause
        if node.kind == "app" and node.header in seen:
            self._check_class(node)

    def _check_class(self, node: Node) -> None:
        """The class that the generated task makes, and its function."""
        name, ports = upper_camel(node.folder.name), f"{upper_camel(node.folder.name)}Ports"
        expected = f"write `class {name} {{ public: void step({ports}& ports); }};`"
        classes = [c for file in self.files if node.owns(file) for c in Source(file).classes()]
        own = [found for found in classes if found.name == name]
        if not own:
            near = next((c for c in classes if c.mark.file == node.header), None)
            mark = Mark(node.header, 1, 1) if near is None else near.mark
            found = "found none" if near is None else f"found class '{near.name}'"
            self._error(mark, f"expected class '{name}' of {node.room.name}, {found}", expected)
        elif not own[0].has_bases and "step" not in own[0].words:
            self._error(own[0].mark, f"missing function 'step' of class '{name}'", expected)

    def check_board(self, folder: Path) -> None:
        """A board knows drivers and executors, but neither apps nor other boards."""
        for file in sorted(folder.glob("*.[ch]pp")):
            for include in self._read(file).includes():
                found = _own_file(include, file, folder)
                room = room_of(found) if found is not None else Room("", folder)
                if room.kind == "board" and room.folder == folder:
                    continue
                if room.kind in ("app", "board") or include.name.startswith("apps/"):
                    self._error(
                        include.mark,
                        f"a board cannot include {_named(room, include)}",
                        "a board sees its own folder, drivers, executors and what boards share",
                    )

    def _read(self, file: Path) -> Source:
        self.files[file] = None
        return Source(file)

    def _check_include(
        self, include: Include, found: Path | None, node: Node, messages: set[str]
    ) -> None:
        name, kind = include.name, node.kind
        sees = f"{kind}s see their own folder, their ports and these ports' messages, and " + (
            ", ".join(f"runtime/{room}" for room in _rooms_for(kind))
        )
        if found is not None:
            room = room_of(found)
            self._error(include.mark, f"{_a(kind)} cannot include {_named(room, include)}", sees)
        elif not name:
            self._error(include.mark, "expected a file's name, found a macro", "write the name")
        elif name.startswith("messages/"):
            if name not in messages:
                self._error(
                    include.mark,
                    f"{name} is not a message of this {kind}'s ports",
                    f"add a port with this message to the interface; {sees}",
                )
        elif name.startswith("stator/"):
            if any((HOME / "runtime" / room / name).is_file() for room in _rooms_for(kind)):
                return
            if not _room_of_runtime(name):
                self._missing(include, node)
                return
            shown = f"'{name}' of runtime/{_room_of_runtime(name)}"
            self._error(include.mark, f"{_a(kind)} cannot include {shown}", sees)
        elif name.startswith(("Eigen/", "dronecan/", "mavlink/")) or name in _names_in(node.ports):
            pass
        elif include.is_quoted or ".." in Path(name).parts:
            self._missing(include, node)
        elif name in PRINTING and self._may_print:
            pass
        elif kind == "app" and name not in STANDARD:
            self._error(include.mark, *_refusal(name))

    def _missing(self, include: Include, node: Node) -> None:
        known = _names_in(node.folder) | _names_in(node.ports)
        for room in _rooms_for(node.kind):
            known |= {f"stator/{name}" for name in _names_in(HOME / "runtime" / room / "stator")}
        self._error(
            include.mark,
            f"the folder of this {node.kind}, its ports and the runtime have no header "
            f"'{include.name}'",
            nearest(include.name, known),
        )

    def _error(self, mark: Mark, message: str, hint: str) -> None:
        self.errors.append(Error(mark, "wall", message, hint))


def _own_file(include: Include, file: Path, folder: Path) -> Path | None:
    """What the name is beside the file, or from the room's folder on."""
    if not include.name or not include.is_quoted:
        return None
    places = (file.parent / include.name, folder / include.name)
    return next((place.resolve() for place in places if place.is_file()), None)


def _names_in(folder: Path) -> set[str]:
    return {file.name for file in folder.glob("*.hpp")}


def _refusal(name: str) -> tuple[str, str]:
    for what, hint, names in _REASONS:
        if name in names.split():
            return f"an app cannot include <{name}>, which {what}", hint
    shown = ", ".join(sorted(name for name in STANDARD if not name.endswith(".h")))
    return f"an app cannot include <{name}>", f"of the standard library: {shown}"


def _named(room: Room, include: Include) -> str:
    return f"'{include.name}'" + (f" of {room.name}" if room.kind else "")


def _room_of_runtime(name: str) -> str:
    return next((r.name for r in sorted((HOME / "runtime").iterdir()) if (r / name).is_file()), "")


def _a(kind: str) -> str:
    return f"an {kind}" if kind == "app" else f"a {kind}"


def _arguments(arguments: list[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="stator.build.walls")
    parser.add_argument("--node", nargs=2, type=Path, action="append", default=[])
    parser.add_argument("--board", type=Path)
    parser.add_argument("--may-print", action="store_true")
    parser.add_argument("--stamp", type=Path, required=True)
    return parser.parse_args(arguments)


def _dependencies(stamp: Path, walls: Walls, folders: list[Path]) -> Iterator[str]:
    yield f"{stamp}:"
    for path in (*walls.files, *folders):
        yield " " + str(path).replace(" ", "\\ ").replace("#", "\\#").replace("$", "$$")


def main(arguments: list[str]) -> int:
    """Beside the stamp, STAMP.d says which files and folders were read."""
    parsed = _arguments(arguments)
    walls = Walls(may_print=parsed.may_print)
    nodes = [Node(folder.resolve(), ports) for folder, ports in parsed.node]
    for node in nodes:
        walls.check_node(node)
    folders = [node.folder for node in nodes]
    if parsed.board is not None:
        walls.check_board(parsed.board.resolve())
        folders.append(parsed.board.resolve())
    if walls.errors:
        errors = sorted(walls.errors, key=lambda error: error.mark)
        print("\n\n".join(error.text() for error in errors), file=sys.stderr)
        return ANSWER_IS_NO
    parsed.stamp.with_name(parsed.stamp.name + ".d").write_text(
        "".join(_dependencies(parsed.stamp, walls, folders)) + "\n", encoding="utf-8"
    )
    parsed.stamp.touch()
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
