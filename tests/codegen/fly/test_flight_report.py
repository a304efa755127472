"""What a report says of a mission, row by row."""

from __future__ import annotations

import argparse
import dataclasses
import json
import subprocess
from typing import TYPE_CHECKING, Any

import pytest

from stator.commands import run
from stator.flight.arguments import cut_of
from stator.flight.facts import facts_of
from stator.flight.judge import CALM, IN_WIND
from stator.flight.log import UnreadableFlight, open_log
from stator.flight.report import flight_rows, log_rows, report

if TYPE_CHECKING:
    from pathlib import Path


FACTS: dict[str, Any] = {
    "mission": "square",
    "items_reached": 1,
    "items_total": 2,
    "items": [{"kind": "takeoff", "reached_s": 9.71}, {"kind": "waypoint", "reached_s": None}],
    "modes": [
        {"armed": True, "mode": "mission", "time_s": 3.64, "failsafe": ""},
        {"armed": True, "mode": "return", "time_s": 12.0, "failsafe": "rc_lost"},
    ],
    "limits": {"corridor": 2.0, "touchdown_speed": 1.0},
    "corridor_m": 1.3,
    "tracking_rms_m": 0.48,
    "truth_off_setpoint_rms_m": 0.68,
    "truth_off_setpoint_max_m": 1.4,
    "take_off_s": 5.78,
    "max_error_m": None,
    "attitude_error_deg": None,
    "touchdown_s": 49.67,
    "touchdown_m_s": 0.45,
}


HOVER: dict[str, Any] = {
    "take_off_s": 2.9,
    "hover_s": 33.0,
    "hover_height_m": 2.0,
    "max_error_m": 0.5,
    "rms_error_m": 0.24,
    "hover_horizontal_rms_m": 0.22,
    "hover_vertical_rms_m": 0.08,
    "attitude_error_deg": 0.56,
    "touchdown_s": 46.2,
    "touchdown_m_s": 0.29,
}


def test_a_hovers_rows_name_the_limits_of_wind() -> None:
    rows = flight_rows(HOVER | {"limits": dataclasses.asdict(IN_WIND)})
    assert rows == [
        ("take-off", "at 2.90 s"),
        ("hover", "33.0 s at 2.00 m: error at most 0.500 m, RMS 0.240 m"),
        ("hover", "horizontal RMS error 0.220 m (limit 1 m)"),
        ("hover", "vertical RMS error 0.080 m (limit 0.5 m)"),
        ("tilt", "RMS error of the estimate in flight 0.56 deg (limit 1.5 deg)"),
        ("touchdown", "at 46.20 s, 0.29 m/s (limit 1 m/s)"),
    ]


def test_a_hovers_rows_in_calm_air() -> None:
    rows = flight_rows(HOVER | {"limits": dataclasses.asdict(CALM)})
    assert rows[1:3] == [
        ("hover", "33.0 s at 2.00 m: error at most 0.500 m (limit 0.15 m), RMS 0.240 m"),
        ("tilt", "RMS error of the estimate in flight 0.56 deg (limit 0.5 deg)"),
    ]


def test_a_missions_rows() -> None:
    assert [f"{label:<10}{text}" for label, text in flight_rows(FACTS)] == [
        "mission   1 of 2 items reached",
        "items      1 takeoff           9.71 s",
        "items      2 waypoint        not reached",
        "modes        mission           3.64 s",
        "modes        return           12.00 s  failsafe rc_lost",
        "measured    1.30 m  greatest distance from the straight path (limit 2 m)",
        "measured    0.48 m  horizontal RMS distance of estimate and setpoint while moving",
        "in flight   0.68 m  RMS distance of truth and setpoint; at most 1.40 m",
        "take-off  at 5.78 s",
        "touchdown at 49.67 s, 0.45 m/s (limit 1 m/s)",
    ]


def test_items_without_a_place_are_named_apart() -> None:
    rows = flight_rows(FACTS | {"items_uncounted": ["delay", "change_speed", "delay"]})
    assert rows[0][1] == (
        "1 of 2 items reached; 3 more without a place to reach: delay, change_speed"
    )


def test_a_time_limit_that_nobody_gave_is_not_called_given() -> None:
    usual = argparse.Namespace(duration=120.0, is_limited=False)
    assert "the limit of 120 s, as --duration was not given, ended" in cut_of(usual)
    given = argparse.Namespace(duration=10.0, is_limited=True)
    assert cut_of(given) == "--duration 10 s ended the flight early"


def test_a_storage_that_may_not_take_the_recording_is_told(tmp_path: Path) -> None:
    log = tmp_path / "flight.ulg"
    log.write_bytes(bytes(1_200_000))
    facts: dict[str, Any] = {"log": str(log)}
    assert log_rows(facts) == [("log", f"{log} (1.2 MB)")]
    facts |= {"recording_bytes_per_s": 461_000, "storage_bytes_per_s": None, "storage_board": "x"}
    at_most = ("log", f"{log} (1.2 MB); highest rate 461 kB/s, recording included")
    assert log_rows(facts) == [at_most]
    facts["storage_bytes_per_s"] = 461_000
    assert log_rows(facts) == [at_most, ("storage", "x stores 461 kB/s")]
    facts["storage_bytes_per_s"] = 460_000
    too_little = (
        "x stores 460 kB/s: LESS than the highest rate; hint: --no-record writes no recording"
    )
    assert log_rows(facts) == [at_most, ("storage", too_little)]


# What may be wrong with a flight that ended well, each with a number that is found in a text.
BAD = {
    "lost_samples": 701,
    "missed_samples": 702,
    "missed_releases": 703,
    "missed_life_signs": 704,
    "unrecorded_activations": 705,
    "refused_publications": 706,
}
ENDED: dict[str, Any] = {
    "graph": "quad",
    "board": "linux",
    "seed": 1,
    "success": True,
    "reason": "ran to its end",
    "take_off_s": None,
    "max_error_m": None,
    "attitude_error_deg": None,
    "touchdown_m_s": None,
    "duration_s": 6.0,
    "speed_vs_real_time": 1.0,
    "speed": 1.0,
    "activations": 100,
    "levels": [{"level": 5, "load": 0.5, "worst_release_us": 0.0}],
    "not_allowed": [],
    "nonvolatile": None,
    "refused_output": "node.output",
}


def test_a_person_gets_each_bad_fact_that_a_program_gets(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log = tmp_path / "flight.ulg"
    log.write_bytes(b"ULog")
    facts = ENDED | BAD | {"log": str(log), "recording": str(log)}
    run._report(facts, [], as_json=False)
    text = capsys.readouterr().out
    assert [key for key, number in BAD.items() if str(number) not in text] == []
    report(facts)  # of fly and emulate; releases are counted of threads alone
    text = capsys.readouterr().out
    missing = [key for key, number in BAD.items() if str(number) not in text]
    assert missing == ["missed_releases"]
    assert "replay" in text
    assert "bit for bit" not in text, "a recording with a gap does not replay as a whole"


def test_a_missed_life_sign_is_no_success(tmp_path: Path) -> None:
    log = tmp_path / "flight.ulg"
    log.write_bytes(b"ULog")
    run = {"simulated_s": 6.0, "wall_s": 6.0, "ended": "time_limit", "missed_life_signs": 57}
    finished = subprocess.CompletedProcess([], 0, json.dumps(run), "")
    facts = facts_of(
        finished, log, tmp_path / "truth", cut="--duration 6 s ended the flight early", judges=False
    )
    assert facts["success"] is False
    assert facts["reason"] == "57 missed life signs: a task did not run in time; ran to its end"


@pytest.mark.parametrize("content", [b"", b"\x00" * 4096])
def test_a_log_without_its_beginning_is_said_to_be_so(tmp_path: Path, content: bytes) -> None:
    log = tmp_path / "busy.ulg"
    log.write_bytes(content)
    with pytest.raises(UnreadableFlight, match=r"the log is empty|the beginning .* was lost"):
        open_log(log)
