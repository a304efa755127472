"""Runs in real time replay equal: levels that truly run at once are an order of events like any
other, and nodes, topics, triggers and modes mean the same on threads as in the replay's one thread.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from stator import HOME
from stator import __main__ as cli

QUAD = HOME / "graph" / "quad.yaml"
MIXED = HOME / "tests" / "codegen" / "replay" / "graph" / "mixed.yaml"


def run_and_replay(
    graph: Path, seconds: str, log: Path, capsys: pytest.CaptureFixture[str]
) -> dict[str, Any]:
    words = ["--duration", seconds, "-o", str(log), "--link", str(log.with_suffix(".link"))]
    assert cli.main(["run", str(graph), *words, "--json"]) in (0, 1)
    capsys.readouterr()
    status = cli.main(["replay", str(log), "--json"])
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert status == (0 if facts["equal"] else 1)
    return facts


def test_a_flight_in_real_time_replays_equal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = run_and_replay(QUAD, "4", tmp_path / "quad.ulg", capsys)
    assert facts["equal"], facts
    assert {"vehicle_attitude", "rate_control_params"} <= set(facts["topics"])
    assert facts["replayed_until_s"] > 1.0


def test_modes_queues_and_several_publishers_replay_equal(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = run_and_replay(MIXED, "3", tmp_path / "mixed.ulg", capsys)
    assert facts["equal"], facts
    assert {"count", "sum", "smooth", "mode"} <= set(facts["topics"])
    assert all(facts["topics"].values())
