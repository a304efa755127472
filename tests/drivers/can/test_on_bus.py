"""The drivers and nodes of CAN on a bus of a real kernel: on_bus.py, inside tests/with-can."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from tests.drivers.can.kernel_bus import on_bus
from tests.host_program import host_program

from stator.build.cmake import build

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def link() -> Path:
    return build(HERE / "graphs" / "link.yaml", "linux", executor="pthread")


def test_on_the_bus(link: Path) -> None:
    pytest_ = [sys.executable, "-I", "-X", "utf8", "-m", "pytest", "-q", "--no-header"]
    options = ["-p", "no:cacheprovider", "-o", "addopts=--import-mode=importlib"]
    finished = on_bus(
        1800, *pytest_, *options, HERE / "on_bus.py", options=["-p"], STATOR_LINK=str(link)
    )
    print(finished.stdout)
    assert finished.returncode == 0, finished.stdout[-6000:] + finished.stderr[-2000:]


@pytest.mark.long
def test_five_thousand_frames_a_second_both_ways_are_there_or_counted() -> None:
    """For 20 s. What is missing from the numbers is what the driver says it lost, but for what the
    kernel dropped between the interface and any socket, which it counts itself."""
    flood = host_program("tests/drivers/can/can_flood")
    rate, seconds = 5000, 20
    script = (
        f"{flood} vcan0 0x1000 0x2000 {rate} {seconds} & "
        f"{flood} vcan0 0x2000 0x1000 {rate} {seconds}; wait; "
        "cat /proc/net/softnet_stat"
    )
    finished = on_bus(200, "bash", "-c", script, options=["-p"])
    assert finished.returncode == 0, finished.stderr
    lines = finished.stdout.splitlines()
    ends = [json.loads(line) for line in lines if line.startswith("{")]
    dropped = sum(int(line.split()[1], 16) for line in lines if not line.startswith("{"))
    assert len(ends) == 2
    for end, other in (ends, ends[::-1]):
        print(end)
        assert end["sent"] == rate * seconds
        assert end["disordered"] == 0
        assert end["received"] + end["before"] + end["missing"] == other["sent"]
        assert 0 <= end["missing"] - end["rx_lost"] <= dropped
