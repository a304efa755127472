"""MAVProxy's own words fly the vehicle."""

from __future__ import annotations

from typing import TYPE_CHECKING

from tests.flight.mavlink.client import SOURCE, run_python
from tests.flight.mavlink.vehicle import Station, flying, free_port, wait_until_it_talks

if TYPE_CHECKING:
    from pathlib import Path

SPEED = ("--speed", "5")


def test_its_steps(tmp_path: Path) -> None:
    port = free_port()
    with flying(tmp_path / "mavproxy.ulg", "--mavlink", f"udp:{port}", *SPEED) as facts:
        wait_until_it_talks(port)
        station = Station(f"udpin:127.0.0.1:{port}")  # MAVProxy does not wait for good health
        station.connect()
        station.wait_until_armable()
        home = (station.home.latitude * 1e-7, station.home.longitude * 1e-7)
        station.close()
        run_python(SOURCE / "mavproxy_steps.py", str(port), *map(str, home), cwd=tmp_path)
    assert facts["success"], facts["reason"]
    assert facts["refused_publications"] == 0
