"""Instructions that the runtime takes, counted in QEMU: the same each time, and a change is seen.

The golden counts are what gcc 12.2.1 makes at -O2. They are no times: docs/emulation.md.
STATOR_UPDATE=1 rewrites them: read what changed before keeping it.
"""

from __future__ import annotations

import os
from pathlib import Path

from tests.emulation.firmware_tools import needs_emulator

from stator.bench.counts import counts

GOLDEN = Path(__file__).with_name("golden") / "counts.txt"


def test_counts_are_as_expected() -> None:
    needs_emulator()
    found = counts()
    text = "".join(f"{most:4} {what}\n" for what, _, most, _ in found)
    if os.environ.get("STATOR_UPDATE"):
        GOLDEN.parent.mkdir(exist_ok=True)
        GOLDEN.write_text(text, encoding="utf-8")
    assert all(least == most for _, least, most, _ in found), found
    assert all(bound is None or most <= bound for _, _, most, bound in found), found
    assert text == GOLDEN.read_text(encoding="utf-8"), text


def test_what_is_noted_of_an_activation_costs_little() -> None:
    """18 for its time, 10 for the list in the record of a fault (activation.hpp of cortex_m), and
    one or two where a register more is needed."""
    needs_emulator()
    whole = (
        "publish, and the whole activation of the reader that it activates",
        "the same, and the reader reads the newest sample of another topic",
    )
    plain, noted = ({row[0]: row[2] for row in rows} for rows in (counts(), counts({})))
    assert all(28 <= noted[way] - plain[way] <= 30 for way in whole), (plain, noted)
