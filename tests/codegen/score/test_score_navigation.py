"""`stator score navigation`: what it reads and refuses, its metrics, and the node's score."""

from __future__ import annotations

import gzip
import io
import json
import os
import re
import zipfile
from pathlib import Path

import numpy as np
import pytest

from stator import __main__ as cli
from stator.score import attitude as score
from stator.score import navigation_metrics, navigation_peer
from stator.score import recordings as flight_recordings

DATA = Path(os.environ.get("STATOR_DATA", "/nonexistent"))
SECONDS = 70
NAMES = ("IMU.txt", "GPS.txt", "MAG.txt", "NTUN.txt", "ATT.txt", "timing.txt")


def run(folder: Path, *, as_json: bool = True) -> int:
    return cli.main(["score", "navigation", str(folder), *(["--json"] * as_json)])


def rows(period_ms: float, *values: float) -> score.Array:
    times = np.arange(0, SECONDS * 1000, period_ms)
    return np.column_stack([times, times, *(np.full(len(times), value) for value in values)])


def tables() -> dict[str, score.Array]:
    """A vehicle that stands still, level, and looks east."""
    gps = np.zeros((SECONDS * 5, 14))
    gps[:, 0] = gps[:, 2] = np.arange(SECONDS * 5) * 200
    gps[:, 1], gps[:, 6], gps[:, 7], gps[:, 9] = 3, -37.85, 144.76, 20
    ntun = np.zeros((SECONDS * 10, 10))
    ntun[:, 0] = ntun[:, 1] = np.arange(SECONDS * 10) * 100
    ntun[:, 8] = 12.5
    return {
        "IMU.txt": rows(20, 0, 0, 0, 0, 0, -9.80665),
        "GPS.txt": gps,
        "MAG.txt": rows(100, 10, -190, 400, 10, 10, 0),
        "NTUN.txt": ntun,
        "ATT.txt": rows(100, 0, 0, 90, 0, 0),
        "timing.txt": np.array([[1.0], [0.0], [SECONDS], [230], [210], [350], [30], [210], [1]]),
    }


def write(folder: Path, name: str, content: dict[str, score.Array]) -> None:
    with zipfile.ZipFile(folder / f"{name}.zip", "w") as archive:
        for file, table in content.items():
            text = io.StringIO()
            np.savetxt(text, table, fmt="%.9g")
            archive.writestr(f"{name}/{file}", text.getvalue())


# --- what it reads ---


def test_tables_become_rows_in_order(tmp_path: Path) -> None:
    write(tmp_path, "still", tables())
    flight = flight_recordings.flights_in(tmp_path)[0]
    assert np.all(np.diff(flight.rows[:, 0]) >= 0)
    mag, fix, baro = (flight.of(device)[-1] for device in (1, 2, 3))
    assert mag[3:6] == pytest.approx([0, -0.2, 0.4])  # gauss, offsets taken off
    assert mag[0] - mag[2] == pytest.approx(30e3)
    assert fix[3:6] == pytest.approx([-37.85, 144.76, 20])
    assert fix[0] - fix[2] == pytest.approx(220e3)
    # ISO 2533 has 101175 Pa at 12.5 m: 12.013 Pa a metre at the sea.
    assert baro[3] == pytest.approx(101325 - 12.013 * 12.5, abs=0.5)
    assert flight.onboard[0, 1:] == pytest.approx([0, 0, np.pi / 2])


def test_what_is_not_newer_or_no_number_is_left_out() -> None:
    block = flight_recordings.block(0, np.array([0.0, 20, 20, 10, 40]), 0.0, 1.0)
    block[4, 3] = np.nan
    assert flight_recordings.merged([block])[:, 0] == pytest.approx([1e6, 1.02e6])


@pytest.mark.parametrize("missing", NAMES)
def test_a_missing_table_is_named(
    missing: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    content = tables()
    del content[missing]
    write(tmp_path, "still", content)
    assert run(tmp_path) == 2
    captured = capsys.readouterr()
    assert f"missing {missing} in" in captured.err
    assert captured.out == ""


@pytest.mark.parametrize(
    ("name", "data", "problem"),
    [
        ("a.zip", b"text", "is not a valid zip file"),
        ("a_replay.csv.gz", b"text", "expected rows of"),
        ("a_replay.csv.gz", gzip.compress(b"1,imu,x", mtime=0), "expected rows of"),
        ("a.txt", b"", "expected recorded flights"),
    ],
)
def test_other_files_are_refused(
    name: str, data: bytes, problem: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(data)
    assert run(tmp_path) == 2
    error = capsys.readouterr().err
    assert problem in error
    assert error.count("\n") == 2


# --- metrics ---


def test_tilt_is_between_the_verticals() -> None:
    ours = np.radians([[10.0, 0, 50], [0, 0, 0]])
    others = np.radians([[0.0, 0, -50], [0, 0, 0]])
    found = navigation_metrics.attitude_score(ours, others)
    half = np.sqrt(0.5)
    assert found.tilt_deg == pytest.approx(10 * half)
    assert found.roll_deg == pytest.approx(10 * half)
    assert found.pitch_deg == pytest.approx(0)
    assert found.yaw_deg == pytest.approx(100 * half)


def test_the_last_third_is_held_out(tmp_path: Path) -> None:
    write(tmp_path, "still", tables())
    flight = flight_recordings.flights_in(tmp_path)[0]
    kept = navigation_metrics.held_out(flight)
    fixes = (kept[kept[:, 1] == flight_recordings.GNSS, 0] - flight_recordings.START_US) * 1e-6
    assert not np.any((fixes >= 20) & (fixes < 30))
    assert np.any((fixes >= 30) & (fixes < 50))
    assert [fix[0] for fix in navigation_metrics.returning_fixes(flight)] == pytest.approx(
        [flight_recordings.START_US + 30e6, flight_recordings.START_US + 60e6]
    )


def test_a_filter_that_is_lost_in_a_window_misses_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of two windows the node answers the first, 5 m off, and says nothing at the second."""
    write(tmp_path, "still", tables())
    flight = flight_recordings.flights_in(tmp_path)[0]
    first = navigation_metrics.returning_fixes(flight)[0]
    said = {
        "timestamp_sample": np.array([first[2]]),
        "gps_hpos[0]": np.array([3.0]),
        "gps_hpos[1]": np.array([4.0]),
    }

    class Run:
        def topic(self, _: str) -> dict[str, score.Array]:
            return said

    monkeypatch.setattr(navigation_metrics, "play_back", lambda *_: Run())
    found = navigation_metrics.hold_out(flight, tmp_path)
    assert (found.windows, found.missed) == (2, 1)
    assert found.p50_m == found.p95_m == np.inf


def test_missed_windows_are_worse_than_all_others() -> None:
    one_in_four = navigation_metrics.summary([1.0, np.inf, 2.0, 3.0])
    assert (one_in_four.windows, one_in_four.missed) == (4, 1)
    assert one_in_four.p50_m == pytest.approx(2.5)
    assert one_in_four.p95_m == np.inf


def test_the_peer_coasts_by_its_own_biases() -> None:
    """One second at 1 m/s^2 north that its bias says, and 2 m/s east that it had."""
    imu = flight_recordings.block(0, np.arange(0, 2000, 20.0), 0.0, 0, 0, 0, 0, 0, -9.80665)
    imu[:, 6] = 1.0
    peer = {name: np.zeros(1) for name in ("vn", "vd", "pn", "pe", "pd", "dvbz", "q1", "q2", "q3")}
    peer |= {f"dangb{axis}": np.zeros(1) for axis in "xyz"}
    peer |= {"t_s": np.zeros(1), "q0": np.ones(1), "ve": np.array([2.0])}
    until = flight_recordings.START_US + 1e6
    assert navigation_peer.coast(peer, 0, imu, until) == pytest.approx([0.5, 2.0], abs=1e-6)


# --- the node ---


def test_a_vehicle_at_rest_scores_well(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    write(tmp_path, "still", tables())
    assert run(tmp_path) == 0
    (found,) = json.loads(capsys.readouterr().out)["recordings"]
    assert found["name"] == "still"
    assert found["peer"] is None
    assert found["attitude"]["tilt_deg"] < 0.05
    assert found["attitude"]["yaw_deg"] < 0.5
    assert all(value < 0.05 for value in found["innovations"].values())
    assert found["hold_out"]["windows"] == 2
    assert found["hold_out"]["missed"] == 0
    assert found["hold_out"]["p95_m"] < 0.5

    assert run(tmp_path, as_json=False) == 0
    out = capsys.readouterr().out
    assert "tilt against onboard" in out
    assert re.search(r"windows missed +0 of 2\n", out)


@pytest.mark.skipif(
    not DATA.is_dir(), reason="NOT TESTED: STATOR_DATA names no folder with inertialnav/"
)
def test_it_is_better_than_the_peer_on_real_flights(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(DATA / "inertialnav") == 0
    recordings = json.loads(capsys.readouterr().out)["recordings"]
    assert len(recordings) >= 2
    for found in recordings:
        peer = found["peer"]
        assert found["attitude"]["tilt_deg"] < min(1.0, peer["attitude"]["tilt_deg"])
        for key, value in found["innovations"].items():
            assert value < peer["innovations"][key], key
        for key in ("p50_m", "p95_m"):
            assert found["hold_out"][key] < peer["hold_out"][key]


@pytest.mark.skipif(
    not DATA.is_dir(), reason="NOT TESTED: STATOR_DATA names no folder with px4_ecl/"
)
def test_it_agrees_with_ekf2(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(DATA / "px4_ecl") == 0
    (found,) = json.loads(capsys.readouterr().out)["recordings"]
    assert found["reference"]["tilt_deg"] < 0.5
    assert found["reference"]["yaw_deg"] < 3
    assert found["reference"]["velocity_m_s"] < 0.3
    assert found["reference"]["height_change_m"] < 0.5
