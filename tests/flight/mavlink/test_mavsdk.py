"""MAVSDK flies the vehicle: all that it can ask for, and the script of the guide."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from tests.flight.mavlink.client import SOURCE, run_python
from tests.flight.mavlink.vehicle import flying, free_port, wait_until_it_talks

from stator import HOME

if TYPE_CHECKING:
    from pathlib import Path

SPEED = ("--speed", "5")
GUIDE = HOME / "docs" / "mavsdk.md"


def test_its_steps(tmp_path: Path) -> None:
    port = free_port()
    with flying(tmp_path / "mavsdk.ulg", "--mavlink", f"udp:{port}", *SPEED) as facts:
        wait_until_it_talks(port)
        run_python(SOURCE / "mavsdk_steps.py", str(port))
    assert facts["success"], facts["reason"]
    assert facts["refused_publications"] == 0


def test_the_script_of_the_guide(tmp_path: Path) -> None:
    text = GUIDE.read_text(encoding="utf-8")
    blocks = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    assert len(blocks) == 1
    port = free_port()
    assert "127.0.0.1:14540" in blocks[0]
    script = tmp_path / "fly.py"
    script.write_text(blocks[0].replace("14540", str(port)), encoding="utf-8")
    with flying(tmp_path / "guide.ulg", "--mavlink", f"udp:{port}", *SPEED) as facts:
        wait_until_it_talks(port)
        assert "landed" in run_python(script)
    assert facts["success"], facts["reason"]
