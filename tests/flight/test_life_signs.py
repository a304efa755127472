"""A task that stays away for longer than its graph allows is counted, and the log names it."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from pyulog import ULog

from stator import __main__ as cli

if TYPE_CHECKING:
    from pathlib import Path

    import pytest

# Motion capture comes every 10 ms, a gyro sample each millisecond: boards/world/world/sensors.hpp.
GRAPH = """
include: [{file: quad.yaml}]
board: fmu_v2
nodes:
  mocap0: {trigger: {irq: received, min_interarrival: 4 ms, max_interval: 5 ms}}
  imu0: {trigger: {irq: data_ready, min_interarrival: 900 us, max_interval: 5 ms}}
"""


def test_a_missed_life_sign_is_counted_and_logged(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    graph, log = tmp_path / "watched_quad.yaml", tmp_path / "flight.ulg"
    graph.write_text(GRAPH)
    cli.main(["fly", str(graph), "--json", "--duration", "1", "-o", str(log)])
    facts = json.loads(capsys.readouterr().out)
    assert facts["missed_life_signs"] >= 90  # one in each of 100 intervals, but for the first
    messages = {row.message for row in ULog(str(log)).logged_messages}
    assert messages == {"no life sign of mocap0"}
