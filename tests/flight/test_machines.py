"""The quad whose position control runs on a companion computer, in virtual time: the same bits, and
a safe flight whatever happens to the link and to the companion."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import pytest
from pyulog import ULog

from stator import HOME
from stator import __main__ as cli
from stator.machines.links import directions
from stator.pipeline import make_plan

if TYPE_CHECKING:
    from pathlib import Path

COMPANION = HOME / "graph" / "quad_companion.yaml"
MAX_AGE_S = 0.05  # of the standby, and the longest period of its position control
PERIOD_S = 0.012


def fly(log: Path, capsys: pytest.CaptureFixture[str], *options: str) -> dict[str, Any]:
    cli.main(["fly", str(COMPANION), "--json", "-o", str(log), *options])
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    return facts


def topic(log: Path, name: str) -> dict[str, Any]:
    (data,) = (d.data for d in ULog(str(log), [name]).data_list if d.name == name)
    return dict(data)


def link(facts: dict[str, Any], end: str) -> dict[str, Any]:
    return next(row for row in facts["links"] if row["end"] == end)


def test_it_flies_by_the_companion_and_two_flights_are_the_same(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    logs = [tmp_path / name for name in ("one.ulg", "two.ulg")]
    facts = fly(logs[0], capsys)
    assert facts["success"], facts["reason"]
    fly(logs[1], capsys)
    assert logs[0].read_bytes() == logs[1].read_bytes()
    (standby,) = facts["standbys"]
    assert standby == {"node": "position_control", "fallbacks": 0, "fallback_s": []}
    # It acts before the vehicle arms.
    selection = topic(logs[0], "position_control_selection")
    assert selection["is_remote"][0] == 1
    assert selection["timestamp"][0] < 200_000
    for end in ("fmu_companion", "companion_fmu"):
        counts = link(facts, end)
        assert counts["received"] > 4000
        bad = ("lost", "damaged", "repeated", "too_old", "refused", "replaced")
        assert [counts[key] for key in bad] == [0] * len(bad)


def test_no_sample_is_longer_on_the_way_than_its_bound(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = fly(tmp_path / "flight.ulg", capsys)
    there, back = directions(make_plan(str(COMPANION), "sitl").graph)
    bounds = [max(c.bound_us or 0 for c in d.topics) for d in (there, back)]
    oldest = link(facts, "companion_fmu")["oldest_us"]
    assert bounds[0] / 2 < oldest <= bounds[0]
    # A setpoint has the time of the position that it follows from.
    assert link(facts, "fmu_companion")["oldest_us"] <= sum(bounds)


@pytest.mark.parametrize(
    ("fault", "lasts_s", "fallbacks"),
    [
        ("companion.kill@20", None, 1),
        ("companion.kill@20+3", 3.0, 1),
        ("companion.freeze@20+0.5", 0.5, 1),
        ("link.cut@20", None, 1),
        ("link.cut@20+0.1", 0.1, 1),
        ("link.cut@20+0.002", 0.002, 0),  # a frame
        ("position_control.stuck@20+1", 1.0, 1),
    ],
)
def test_the_standby_takes_over_in_time_and_keeps_the_controls(
    fault: str,
    lasts_s: float | None,
    fallbacks: int,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    log = tmp_path / "flight.ulg"
    facts = fly(log, capsys, "--fail", fault)
    judged = facts["reason"].removesuffix("landed and disarmed, within all limits")
    assert not judged or "missed life signs" in judged, facts["reason"]
    (standby,) = facts["standbys"]
    assert standby["fallbacks"] == fallbacks
    selection = topic(log, "position_control_selection")
    times, fresh = selection["timestamp"] * 1e-6, selection["remote_is_fresh"]
    if not fallbacks:
        return
    assert 20.0 < standby["fallback_s"][0] <= 20.0 + MAX_AGE_S + PERIOD_S
    status = topic(log, "vehicle_status")
    status_s = status["timestamp"] * 1e-6
    disarmed_s = status_s[(status_s > 20.0) & (status["arming_state"] == 1)][0]
    after = (times > 20.07) & (times < disarmed_s)
    assert not selection["is_remote"][after].any()
    if lasts_s is not None:  # it is back within a second, and waits for its turn
        back = times[(times > 20.07) & (fresh == 1)]
        assert back[0] <= 20.0 + lasts_s + 1.0


def test_what_a_frozen_companion_says_late_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = fly(tmp_path / "flight.ulg", capsys, "--fail", "companion.freeze@20+0.5")
    assert facts["success"], facts["reason"]
    assert link(facts, "companion_fmu")["too_old"] + link(facts, "companion_fmu")["damaged"] > 0


def test_damaged_frames_are_counted_and_none_is_taken(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    facts = fly(tmp_path / "flight.ulg", capsys, "--fail", "link.noise=1e-3@5")
    assert facts["success"], facts["reason"]
    for end in ("fmu_companion", "companion_fmu"):
        counts = link(facts, end)
        assert counts["damaged"] > 50
        assert 0.5 < counts["lost"] / counts["damaged"] < 1.5


@pytest.mark.long
def test_a_companion_that_is_killed_again_and_again_is_back_each_time(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """100 times, 14 in a flight."""
    for seed in range(1, 9):
        log = tmp_path / f"{seed}.ulg"
        kills = [f"companion.kill@{5 + 2.5 * i + 0.013 * seed}+0.7" for i in range(14)]
        options = [word for kill in kills for word in ("--fail", kill)]
        facts = fly(log, capsys, "--seed", str(seed), *options)
        assert facts["success"], facts["reason"]
        selection = topic(log, "position_control_selection")
        times, fresh = selection["timestamp"] * 1e-6, selection["remote_is_fresh"]
        for i in range(14):
            end = 5 + 2.5 * i + 0.013 * seed + 0.7
            assert fresh[(times > end) & (times < end + 1.0)].any(), (seed, i)
