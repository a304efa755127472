"""Instructions that the runtime takes, counted in QEMU: the same each time, and a change is seen.

The expected counts are what gcc 12.2.1 makes at -O2. They are no times: docs/emulation.md.
"""

from __future__ import annotations

from pathlib import Path

from tests.emulation.firmware_tools import needs_emulator

from stator.build import build, build_plant
from stator.emulate import fly
from stator.library import HOME

FOLDER = HOME / "tests" / "emulation" / "counts"
COUNTED = "COUNT"


def test_counts_are_as_expected(tmp_path: Path) -> None:
    """To renew tests/emulation/counts/expected.txt, write what this test prints into it."""
    emulator = needs_emulator()
    image = build(FOLDER / "counts.yaml", None, executor="cortex_m")
    plant = [str(build_plant()), "--duration", "0.6"]
    finished = fly(emulator, image, plant, tmp_path / "flight.ulg", shift=0)
    assert finished.returncode == 0, finished.stderr
    lines = [line.split()[1:] for line in finished.stderr.splitlines() if COUNTED in line]
    found = {name: (int(least), int(most)) for name, least, most in lines}
    assert all(least == most for least, most in found.values()), found
    text = "".join(f"{name} {count}\n" for name, (count, _) in found.items())
    assert text == (FOLDER / "expected.txt").read_text(encoding="utf-8"), text
