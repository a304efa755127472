"""`stator score attitude`: the metric, the recordings it refuses, and the estimator's score."""

from __future__ import annotations

import csv
import gzip
import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from stator import __main__ as cli
from stator.build.cmake import build
from stator.score import attitude as score

DATA = Path(os.environ.get("STATOR_DATA", "/nonexistent")) / "broad"
IDENTITY = np.array([1.0, 0.0, 0.0, 0.0])


def turn(axis: str, degrees: float) -> score.Array:
    """The quaternion of a turn about an axis."""
    result = np.zeros(4)
    result[0] = np.cos(np.radians(degrees) / 2)
    result[1 + "xyz".index(axis)] = np.sin(np.radians(degrees) / 2)
    return result


def figures(error: score.Array) -> tuple[float, float, float]:
    """The score of an estimate whose error is the same in 10 samples of a vehicle on its side."""
    truth = np.tile(turn("x", 70), (10, 1))
    estimate = score.product(np.tile(score.conjugate(error), (10, 1)), truth)
    found = score.rmse("", truth, estimate, np.ones(10, dtype=bool))
    return found.total_deg, found.heading_deg, found.inclination_deg


def run(folder: Path, *, as_json: bool = False) -> int:
    return cli.main(["score", "attitude", str(folder), *(["--json"] * as_json)])


def recording(samples: int = 3000) -> score.Array:
    """A sensor that lies level for a third of the time, and then turns by 30 deg/s about the
    vertical. At rest it points east: the field is along its y axis, as is north."""
    planes = np.zeros((score.PLANES, samples))
    rest = samples // 3
    rate = np.radians(30)
    time = np.maximum(np.arange(samples) + 1 - rest, 0) * score.PERIOD_US * 1e-6
    planes[2, rest:] = rate
    planes[5] = 9.81
    planes[6] = 20 * np.sin(rate * time)
    planes[7] = 20 * np.cos(rate * time)
    planes[8] = -40
    planes[9] = np.cos(rate * time / 2)
    planes[12] = np.sin(rate * time / 2)
    planes[score.MOVING, rest:] = 1
    return planes


def write(folder: Path, name: str, planes: score.Array) -> Path:
    path = folder / f"{name}{score.SUFFIX}"
    path.write_bytes(gzip.compress(planes.astype("<f4").tobytes()))
    return path


# --- the metric ---


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("axis", ["x", "y"])
def test_a_turn_about_a_level_axis_is_inclination(axis: str, sign: int) -> None:
    assert figures(turn(axis, sign * 12)) == pytest.approx((12, 0, 12), abs=1e-5)


@pytest.mark.parametrize("degrees", [25, -25, 335])
def test_a_turn_about_the_vertical_is_heading(degrees: float) -> None:
    assert figures(turn("z", degrees)) == pytest.approx((25, 25, 0), abs=1e-5)


def test_heading_and_inclination_are_apart() -> None:
    error = score.product(turn("x", 10), turn("z", 40))
    total, heading, inclination = figures(error)
    assert (heading, inclination) == pytest.approx((40, 10), abs=1e-5)
    assert total == pytest.approx(np.degrees(2 * np.arccos(error[0])))


def test_it_is_a_root_mean_square() -> None:
    truth = np.tile(IDENTITY, (4, 1))
    estimate = np.stack([turn("z", degrees) for degrees in (0, 0, 0, 20)])
    found = score.rmse("", truth, estimate, np.ones(4, dtype=bool))
    assert found.total_deg == pytest.approx(10)


def test_only_motion_with_truth_counts() -> None:
    truth = np.tile(IDENTITY, (4, 1))
    truth[1] = np.nan
    estimate = np.stack([turn("z", degrees) for degrees in (5, 100, 100, 5)])
    found = score.rmse("", truth, estimate, np.array([True, True, False, True]))
    assert found.total_deg == pytest.approx(5)


def test_north_east_down_becomes_east_north_up() -> None:
    def turned(v: list[float]) -> score.Array:
        q = score.ENU_FROM_NED
        return score.product(score.product(q, np.array([0.0, *v])), score.conjugate(q))[1:]

    assert turned([1, 0, 0]) == pytest.approx([0, 1, 0])
    assert turned([0, 1, 0]) == pytest.approx([1, 0, 0])
    assert turned([0, 0, 1]) == pytest.approx([0, 0, -1])


# --- what it refuses ---


def make_missing(folder: Path) -> Path:
    return folder / "nowhere"


def make_empty(folder: Path) -> Path:
    return folder


def make_corrupt(folder: Path) -> Path:
    path = write(folder, "a", recording())
    packed = bytearray(path.read_bytes())
    packed[len(packed) // 2] ^= 0xFF
    path.write_bytes(packed)
    return folder


def make_not_gzip(folder: Path) -> Path:
    (folder / "a.f32.gz").write_bytes(b"text")
    return folder


def make_truncated(folder: Path) -> Path:
    path = write(folder, "a", recording())
    path.write_bytes(path.read_bytes()[:-100])
    return folder


def make_wrong_size(folder: Path) -> Path:
    write(folder, "a", recording().reshape(-1)[:-5])
    return folder


def make_of_nothing(folder: Path) -> Path:
    write(folder, "a", np.zeros(0))
    return folder


def make_a_folder(folder: Path) -> Path:
    (folder / "a.f32.gz").mkdir()
    return folder


def make_without_truth(folder: Path) -> Path:
    planes = recording()
    planes[9:13] = np.nan
    write(folder, "a", planes)
    return folder


def make_without_motion(folder: Path) -> Path:
    planes = recording()
    planes[score.MOVING] = 0
    write(folder, "a", planes)
    return folder


def make_bad_peers(folder: Path) -> Path:
    write(folder, "a", recording())
    (folder / "peer_rmse.csv").write_text("trial,filter,total\na,b,1\n", encoding="utf-8")
    return folder


@pytest.mark.parametrize(
    ("make", "problem"),
    [
        (
            make_missing,
            "missing folder '{folder}/nowhere'\nhint: give a folder with files *.f32.gz",
        ),
        (make_empty, "expected recordings *.f32.gz in '{folder}', found none"),
        (make_corrupt, "'{folder}/a.f32.gz' is not a valid gzip file ("),
        (make_not_gzip, "'{folder}/a.f32.gz' is not a valid gzip file (Not a gzipped file"),
        (make_truncated, "'{folder}/a.f32.gz' is incomplete\nhint: fetch the file again"),
        (make_wrong_size, "expected 14 planes of float32 in '{folder}/a.f32.gz', found 167980"),
        (make_of_nothing, "expected 14 planes of float32 in '{folder}/a.f32.gz', found 0"),
        (make_a_folder, "cannot read '{folder}/a.f32.gz': Is a directory"),
        (make_without_truth, "missing truth in '{folder}/a.f32.gz'"),
        (make_without_motion, "missing truth in '{folder}/a.f32.gz'"),
        (
            make_bad_peers,
            "expected the columns trial,filter,total,heading,incl in '{folder}/peer_rmse.csv'",
        ),
    ],
)
def test_it_refuses(
    make: object, problem: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert callable(make)
    assert run(make(tmp_path), as_json=True) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.startswith("error: " + problem.format(folder=tmp_path))
    assert output.err.count("\n") == 2


# --- the estimator ---


def test_it_scores_the_same_node_on_recordings(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write(tmp_path, "b_level", recording())
    write(tmp_path, "a_level", recording(2000))
    with (tmp_path / "peer_rmse.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["trial", "filter", "total", "heading", "incl"])
        writer.writerow(["a_level", "Other", 3, 2, 1])
        writer.writerow(["b_level", "Other", 5, 4, 3])
        writer.writerow(["c_elsewhere", "Other", 100, 100, 100])
    assert run(tmp_path, as_json=True) == 0
    found = json.loads(capsys.readouterr().out)
    assert [row["name"] for row in found["recordings"]] == ["a_level", "b_level"]
    for row in [*found["recordings"], found["mean"]]:
        assert row["inclination_deg"] < 0.05
        assert row["heading_deg"] < 0.5
        assert row["total_deg"] < 0.5
    assert found["peers"]["Other"]["mean"] == {
        "total_deg": 4,
        "heading_deg": 3,
        "inclination_deg": 2,
    }

    assert run(tmp_path) == 0
    table = capsys.readouterr().out
    assert "a_level" in table
    assert "Other (2 of 2)" in table


@pytest.mark.skipif(not DATA.is_dir(), reason="NOT TESTED: STATOR_DATA names no folder with broad/")
def test_it_is_as_good_as_basic_vqf_on_real_recordings(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(DATA, as_json=True) == 0
    found = json.loads(capsys.readouterr().out)
    ours, peer = found["mean"], found["peers"]["BasicVQF9D"]["mean"]
    assert len(found["recordings"]) == 4
    assert ours["total_deg"] < 1.1 * peer["total_deg"]
    assert ours["inclination_deg"] < 1.1 * peer["inclination_deg"]


# --- the playback ---


@pytest.mark.parametrize(
    ("arguments", "problem"),
    [
        ([], "expected the options"),
        (["--log", "{folder}/log"], "expected the options"),
        (["--recording"], "expected the options"),
        (["--recording", "{folder}/nowhere"], "cannot read the recording '{folder}/nowhere'"),
        (["--recording", "{folder}/short"], "expected rows of 12 64-bit numbers"),
        (["--recording", "{folder}/mixed"], "expected rows in order of time"),
        (["--recording", "{folder}"], "cannot read the recording"),
        (["--recording", "{folder}/good", "--log", "{folder}/no/log"], "cannot open"),
    ],
)
def test_playback_says_what_is_wrong(arguments: list[str], problem: str, tmp_path: Path) -> None:
    rows = np.zeros((2, score.COLUMNS))
    (tmp_path / "short").write_bytes(rows.tobytes()[:-4])
    (tmp_path / "good").write_bytes(rows.tobytes())
    rows[0, 0] = 1000
    (tmp_path / "mixed").write_bytes(rows.tobytes())
    program = build(score.GRAPH, score.BOARD)
    command = [str(program), *(argument.format(folder=tmp_path) for argument in arguments)]
    result = subprocess.run(command, check=False, capture_output=True, text=True)
    assert result.returncode == 2
    assert result.stderr.startswith("error: ")
    assert problem.format(folder=tmp_path) in result.stderr
    assert result.stderr.count("\n") == 1
