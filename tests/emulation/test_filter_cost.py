"""Instructions that the navigation filter takes, counted in QEMU: within bounds, as expected.

The golden counts are what gcc 12.2.1 makes at -O2. They are no times: docs/emulation.md.
STATOR_UPDATE=1 rewrites them: read what changed before keeping it.
"""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

from tests.emulation.firmware_tools import needs_emulator

from stator.build.cmake import NO_WALLS, build
from stator.emulator.qemu import qemu_command

GRAPH = Path(__file__).parent / "graphs" / "filter_cost.yaml"
GOLDEN = Path(__file__).parent / "golden" / "filter_cost.txt"
# In the order in which the program prints them (graphs/apps/cost), with their bounds.
OPERATIONS = {
    "predict one step": 6000,
    "fuse a scalar that sees one state": 2500,
    "fuse one that sees two": 2500,
    "fuse a heading": 2500,
    "the output from the horizon to now": 1000,
    # In double precision, by libgcc.
    "a local frame from its origin": 10000,
    "latitude and longitude to the local frame": 10000,
    "the local frame to latitude and longitude": 30000,
}


def test_the_filter_stays_within_its_bounds() -> None:
    """The most of each operation over 300 runs."""
    emulator = needs_emulator()
    command = qemu_command(emulator, build(GRAPH, None, NO_WALLS, executor="cortex_m"), shift=0)
    finished = subprocess.run(command, capture_output=True, text=True, check=True, timeout=600)
    lines = (finished.stdout + finished.stderr).splitlines()
    counts = [int(line, 16) for line in lines if line.startswith("0x")]
    found = dict(zip(OPERATIONS, counts, strict=True))
    text = "".join(f"{count:5} {what}\n" for what, count in found.items())
    if os.environ.get("STATOR_UPDATE"):
        GOLDEN.write_text(text, encoding="utf-8")
    assert all(found[what] <= bound for what, bound in OPERATIONS.items()), found
    assert text == GOLDEN.read_text(encoding="utf-8"), text
