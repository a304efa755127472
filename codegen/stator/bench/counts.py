"""`./stator bench counts`: instructions of each way through the runtime, counted in QEMU."""

from __future__ import annotations

import subprocess
from typing import TYPE_CHECKING

from stator import HOME
from stator.build.cmake import PLAIN, RECORDING, build
from stator.build.image_checks import sections_of
from stator.emulator.qemu import find_emulator, qemu_command

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

GRAPHS = HOME / "tests" / "emulation" / "graphs"
LIMIT_S = 60  # of a program that takes half a second
# In the order in which the program prints them (tests/emulation/graphs/apps/meter); the bound that
# a count is held to, if any.
WAYS: tuple[tuple[str, int | None], ...] = (
    ("publish 32 bytes, until the step of the more urgent task that it wakes", 40),
    ("publish 32 bytes, nobody woken, with 5 stores of the fields", 14 + 5),
    ("the first by hand, until the handler that it wakes", None),
    ("the second by hand", None),
    ("entry of a line's interrupt, until the step of its driver", 15),
    ("publish, and the whole activation of the reader that it wakes", None),
    ("the same, and the reader reads the newest of another topic", None),
)
# The same ways in an image that counts and records each activation, by their places above.
RECORDED_WAYS = {0: 90, 4: 60}
READERS_OWN = 2  # of those: the load of a field and a sum
MAX_MASKED = 30


def counts(variant: Mapping[str, str] = PLAIN) -> list[tuple[str, int, int, int | None]]:
    """What, least, most, bound. Raises `NoEmulator` where there is none."""
    image = build(GRAPHS / "counts.yaml", None, variant, executor="cortex_m")
    rows = _run(image)
    found = [
        (what, least, most, bound) for (what, bound), (least, most) in zip(WAYS, rows, strict=True)
    ]
    (_, *plain, _), (_, *reading, _) = found[-2:]
    least, most = (b - a - READERS_OWN for a, b in zip(plain, reading, strict=True))
    found.append(("of this, taking and letting go of the newest", least, most, 10))
    recorded = _run(build(GRAPHS / "counts_recorded.yaml", None, RECORDING, executor="cortex_m"))
    for way, bound in RECORDED_WAYS.items():
        found.append((f"{WAYS[way][0]}; counted and recorded", *recorded[way], bound))
    return found + _sections(image)


def _run(image: Path) -> list[tuple[int, int]]:
    command = qemu_command(find_emulator(), image, shift=0)
    finished = subprocess.run(command, capture_output=True, text=True, check=True, timeout=LIMIT_S)
    rows = (line.split() for line in _lines(finished))
    return [(int(least, 16), int(most, 16)) for least, most in rows]


def _lines(finished: subprocess.CompletedProcess[str]) -> list[str]:
    return [line for line in (finished.stdout + finished.stderr).splitlines() if "0x" in line]


def _sections(image: Path) -> list[tuple[str, int, int, int | None]]:
    return [
        (f"BASEPRI raised in {operation} of {topic}", count, count, MAX_MASKED)
        for topic, operations in sections_of(image).items()
        for operation, count in operations.items()
    ]
