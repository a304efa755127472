"""node-mavlink reads what the vehicle says, and is understood."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.flight.mavlink.client import SOURCE, run_node
from tests.flight.mavlink.vehicle import flying, free_port, wait_until_it_talks

if TYPE_CHECKING:
    from pathlib import Path


def test_its_steps(tmp_path: Path) -> None:
    port = free_port()
    with flying(tmp_path / "node.ulg", "--mavlink", f"udp:{port}", "--speed", "5") as facts:
        wait_until_it_talks(port)
        run_node(SOURCE / "node_steps.mjs", str(port))
    assert facts["success"], facts["reason"]
