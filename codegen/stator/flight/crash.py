"""How a program of this machine died: the node, when, and the line of its code."""

from __future__ import annotations

import os
import re
import subprocess
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import shown_path
from stator.processes import environment

if TYPE_CHECKING:
    from collections.abc import Iterator

# runtime/host/host.cpp prints it.
REPORT = re.compile(
    r"^stator: crash (?P<signal>\w+) node=(?P<node>\S+) input=(?P<input>\S+) at_us=(?P<at>\d+) "
    r"base=(?P<base>[0-9a-f]+) pc=(?P<pc>[0-9a-f]+) frames=(?P<frames>[0-9a-f,]*)$",
    re.MULTILINE,
)
ENDLESS = "ENDLESS"
ET_EXEC = 2  # an ELF file that lies where it was linked
# What is not the node's own code.
OTHERS = [HOME / "runtime", HOME / "boards", HOME / "build"]


@dataclass(frozen=True)
class Crash:
    """`node`: None outside of activations. `input`: the absent one that it read. `file`: None if
    it is not known."""

    signal: str
    node: str | None
    input: str | None
    at_s: float
    file: str | None
    line: int | None

    def in_words(self) -> str:
        who = f"node '{self.node}'" if self.node else "the program"
        if self.input:
            what = f"{who} read the absent input '{self.input}'"
        elif self.signal == ENDLESS:
            what = f"a step of {who} does not end"
        else:
            what = f"{who} crashed with {self.signal}"
        line = "" if self.line is None else f":{self.line}"
        where = f", in {shown_path(Path(self.file))}{line}" if self.file else ""
        return f"{what} at {self.at_s:.6f} s{where}"

    def as_json(self) -> dict[str, object]:
        return asdict(self)


def crash_of(program: Path, errors: str) -> Crash | None:
    """What the program wrote on standard error before it died; None if it did not."""
    found = REPORT.search(errors)
    if found is None:
        return None
    base = 0 if _is_fixed(program) else int(found["base"], 16)
    pc = int(found["pc"], 16)
    frames = [int(frame, 16) for frame in found["frames"].split(",") if frame]
    # A return address belongs to the call before it.
    addresses = [frame - base - (frame != pc) for frame in frames if frame > base]
    places = list(_places(program, addresses))
    own = [place for place in places if _is_own(place[0])]
    file, line = own[0] if own else (None, None)
    if file is not None and line is not None and found["input"] != "-":
        line = _line_of_read(file, line, found["input"])
    return Crash(
        signal=found["signal"],
        node=None if found["node"] == "-" else found["node"],
        input=None if found["input"] == "-" else found["input"],
        at_s=int(found["at"]) * 1e-6,
        file=None if file is None else str(file),
        line=line,
    )


def _line_of_read(file: Path, line: int, name: str) -> int | None:
    """The compiler may merge the ends of several checks, and then tells the line of one of them.
    None: several lines read the input."""
    lines = file.read_text(encoding="utf-8", errors="replace").splitlines()
    reads = re.compile(rf"\b{name}\s*->|\*\s*(\w+(\.|->))?{name}\b")
    found = [number for number, text in enumerate(lines, 1) if reads.search(text)]
    if line in found or not found:
        return line
    return found[0] if len(found) == 1 else None


def _is_fixed(program: Path) -> bool:
    with program.open("rb") as file:
        return int.from_bytes(file.read(18)[16:], "little") == ET_EXEC


def _is_own(file: Path) -> bool:
    return (
        file.is_file()
        and not any(file.is_relative_to(folder) for folder in OTHERS)
        and ({"apps", "drivers"} & {parent.name for parent in file.parents} != set())
    )


def _places(program: Path, addresses: list[int]) -> Iterator[tuple[Path, int]]:
    """File and line of each address; inlined functions first."""
    if not addresses:
        return
    command = ["addr2line", "-i", "-e", str(program), *(f"{address:#x}" for address in addresses)]
    finished = subprocess.run(
        command, env=environment(), check=False, capture_output=True, text=True
    )
    for line in finished.stdout.splitlines():
        file, _, number = line.partition(" (")[0].rpartition(":")
        if number.isdigit():
            # The compiler's cache makes names relative to the build folder.
            yield Path(os.path.normpath(program.parent / file)), int(number)
