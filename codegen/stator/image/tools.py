"""Programs of the toolchain that read images."""

from __future__ import annotations

import subprocess
from typing import TYPE_CHECKING

from stator.processes import environment

if TYPE_CHECKING:
    from pathlib import Path

TOOLS = "arm-none-eabi-"


def run(tool: str, *arguments: str, text: str = "") -> str:
    """What the program prints; `text`: its input."""
    return subprocess.run(
        [TOOLS + tool, *arguments],
        input=text,
        env=environment(),
        check=True,
        capture_output=True,
        text=True,
    ).stdout


def addresses(image: Path) -> dict[str, int]:
    """Of all symbols; of functions without the bit that means Thumb."""
    rows = (line.split() for line in run("nm", str(image)).splitlines())
    return {row[-1]: int(row[0], 16) for row in rows if len(row) == 3}


def sizes(image: Path) -> dict[str, int]:
    """Bytes of the symbols that have a size."""
    rows = (line.split() for line in run("nm", "-S", str(image)).splitlines())
    return {row[-1]: int(row[1], 16) for row in rows if len(row) == 4}
