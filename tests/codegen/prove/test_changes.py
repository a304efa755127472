"""`whatif`, and the highest rate that is still proven."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from stator.__main__ import main
from stator.diagnostics import Failed
from stator.pipeline import make_plan
from stator.prove.changes import changed, shortest_period_us, with_period
from stator.prove.proof import prove

QUAD = str(Path(__file__).resolve().parents[3] / "graph" / "quad.yaml")


def whatif(capsys: pytest.CaptureFixture[str], *changes: str) -> tuple[int, str, str]:
    status = main(["whatif", QUAD, "--board", "fmu_v2", "--set", *changes])
    written = capsys.readouterr()
    return status, written.out, written.err


def test_what_is_less_urgent_moves(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = whatif(capsys, "attitude.budget=45us", "--json")
    facts = json.loads(out)
    assert (status, facts["proven_before"]) == (0 if facts["proven_after"] else 1, True)
    rows = facts["bounds"]
    assert not {"imu0", "rate_control", "allocation", "motors", "chain gyro_to_motor"} & set(rows)
    assert rows["attitude"]["after_ns"] - rows["attitude"]["before_ns"] == 10_000


def test_a_change_that_breaks_a_bound(capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = whatif(capsys, "rate_control.priority=1")
    assert status == 1
    assert re.search(r"^rate_control .* 200 us +LATE$", out, re.MULTILINE)
    assert out.endswith("NOT PROVEN\n")


def test_nothing_moves(capsys: pytest.CaptureFixture[str]) -> None:
    assert whatif(capsys, "logger.priority=1")[:2] == (0, "no bound moves\nproven\n")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("logger", "error: expected a change, found 'logger'\n"),
        ("loger.every=5ms", "error: unknown node 'loger' of quad\n"),
        ("logger.rate=5ms", "error: cannot change 'rate' of a node\n"),
        ("logger.every=5", "error: expected a time with its unit in 'logger.every=5'\n"),
        ("logger.priority=16", "error: expected a priority from 1 to 15, found '16'\n"),
        ("motors.every=5ms", "error: node 'motors' has no trigger with `every`\n"),
    ],
)
def test_wrong_changes(change: str, message: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, error = whatif(capsys, change)
    assert (status, out) == (2, "")
    assert error.startswith(message)
    assert "hint: " in error


def test_the_highest_rate_is_proven_and_a_higher_one_is_not() -> None:
    plan = changed(make_plan(QUAD, "fmu_v2"), ["logger.budget=2ms"])
    shortest = shortest_period_us(plan, "imu0")
    assert shortest is not None
    assert shortest < 900
    assert prove(with_period(plan, "imu0", shortest)).holds
    assert not prove(with_period(plan, "imu0", shortest - 1)).holds


def test_a_period_that_a_queue_cannot_hold_is_not_proven() -> None:
    """Nodes that take little leave time for rates at which 16 samples are not enough."""
    plan = make_plan(QUAD, "fmu_v2")
    shortest = shortest_period_us(plan, "imu0")
    assert shortest is not None
    assert prove(with_period(plan, "imu0", shortest)).holds
    with pytest.raises(Failed):
        with_period(plan, "imu0", shortest - 1)
