"""`./stator bench counts`: instructions of each path through the runtime, counted in QEMU."""

from __future__ import annotations

import subprocess
from typing import TYPE_CHECKING

from stator import HOME
from stator.build.cmake import NO_WALLS, PLAIN, RECORDING, build
from stator.emulator.qemu import find_emulator, qemu_command
from stator.image.checks import sections_of

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

GRAPHS = HOME / "tests" / "emulation" / "graphs"
LIMIT_S = 60  # the program needs half a second
# In the order in which the program prints them (tests/emulation/graphs/apps/meter), each with its
# bound, if it has one.
WAYS: tuple[tuple[str, int | None], ...] = (
    ("publish 32 bytes, until the step of the more urgent task that it activates", 22),
    ("the same, and a lower level reads the topic", 26),
    ("publish 32 bytes without subscriber, with 5 stores of the fields", 14 + 5),
    ("the first, written by hand, until the handler that it activates", None),
    ("the third, written by hand", None),
    ("entry of a line's interrupt, until the step of its driver", 15),
    ("publish, and the whole activation of the reader that it activates", None),
    ("the same, and the reader reads the newest sample of another topic", None),
)
# The same paths in an image that counts and records each activation; keys: indexes of WAYS.
RECORDED_WAYS = {0: 56, 1: 56, 5: 45}
READERS_OWN = 2  # instructions of the reader itself: a load of a field, and a sum
MAX_MASKED = 30


def counts(variant: Mapping[str, str] = PLAIN) -> list[tuple[str, int, int, int | None]]:
    """Text, minimum, maximum, bound. Raises `NoEmulator` if there is no emulator."""
    image = build(GRAPHS / "counts.yaml", None, {**variant, **NO_WALLS}, executor="cortex_m")
    rows = _run(image)
    found = [
        (what, least, most, bound) for (what, bound), (least, most) in zip(WAYS, rows, strict=True)
    ]
    (_, *plain, _), (_, *reading, _) = found[-2:]
    least, most = (b - a - READERS_OWN for a, b in zip(plain, reading, strict=True))
    found.append(("of this, taking and releasing the newest sample", least, most, 10))
    recorded = _run(
        build(GRAPHS / "counts_recorded.yaml", None, {**RECORDING, **NO_WALLS}, executor="cortex_m")
    )
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
