"""The quad flies with its motor controllers on a simulated CAN bus, in virtual time."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from pyulog import ULog

from stator import HOME

COMMAND = [sys.executable, "-I", "-X", "utf8", "-m", "stator", "fly"]


def test_it_flies_and_every_part_is_heard(tmp_path: Path) -> None:
    log = tmp_path / "can.ulg"
    graph = HOME / "graph" / "quad_can.yaml"
    command = [*COMMAND, str(graph), "--json", "-o", str(log)]
    finished = subprocess.run(command, capture_output=True, text=True, check=False)
    facts = json.loads(finished.stdout)
    assert facts["success"], facts
    assert facts["lost_samples"] == 0
    data = {topic.name: topic.data for topic in ULog(str(log)).data_list}
    escs = data["esc_status"]
    assert set(escs["esc_online_flags"][5:]) == {0b1111}
    assert max(escs["esc_rpm[0]"]) > 5000
    assert escs["rejected"][-1] == 0
    # Of 5 fixes a second, the receiver of the simulation loses some.
    fixes = data["sensor_gps"]
    assert len(fixes["timestamp"]) > 0.9 * 5 * facts["duration_s"]
    assert set(fixes["fix_type"]) == {3}
    bus = data["can_interface_status"]
    assert (bus["tx_lost"][-1], bus["rx_lost"][-1]) == (0, 0)
    # 400 commands a second, 10 words on arming and 1 on the node's state. Before the first command,
    # motors are told to stop.
    sent_hz = bus["frames_tx"][-1] / facts["duration_s"]
    assert 409 < sent_hz < 412
