"""Scores the attitude node of the quad on recorded sensor data with known attitude."""

from __future__ import annotations

import csv
import gzip
import tempfile
import zlib
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stator import HOME
from stator.processes import run
from stator.score.recordings import COLUMNS, IMU, MAG, RecordingError, write_rows

GRAPH = HOME / "graph" / "attitude_recording.yaml"
BOARD = "playback"
SUFFIX = ".f32.gz"
PLANES = 14  # gyro, accelerometer, magnetometer (xyz each), true attitude (wxyz), moving
PERIOD_US = 3500
TRUTH = slice(9, 13)
MOVING = 13

Array = npt.NDArray[np.float64]
# From north-east-down, the frame of the node's attitude, to east-north-up, the frame of the truth:
# half a turn about the line between north and east.
ENU_FROM_NED = np.array([0.0, np.sqrt(0.5), np.sqrt(0.5), 0.0])


@dataclass(frozen=True)
class Score:
    """Root mean square errors in degrees."""

    name: str
    total_deg: float
    heading_deg: float
    inclination_deg: float

    def figures(self) -> dict[str, float]:
        return {
            "total_deg": self.total_deg,
            "heading_deg": self.heading_deg,
            "inclination_deg": self.inclination_deg,
        }


def mean_of(name: str, scores: Iterable[Score]) -> Score:
    rows = [(s.total_deg, s.heading_deg, s.inclination_deg) for s in scores]
    return Score(name, *(float(value) for value in np.mean(rows, axis=0)))


# --- quaternions: rows of w x y z ---


def product(a: Array, b: Array) -> Array:
    w, x, y, z = np.moveaxis(a, -1, 0)
    s, i, j, k = np.moveaxis(b, -1, 0)
    rows = (
        w * s - x * i - y * j - z * k,
        w * i + x * s + y * k - z * j,
        w * j - x * k + y * s + z * i,
        w * k + x * j - y * i + z * s,
    )
    return np.stack(rows, axis=-1)


def conjugate(q: Array) -> Array:
    result: Array = q * np.array([1.0, -1.0, -1.0, -1.0])
    return result


def rmse(name: str, truth: Array, estimate: Array, moving: npt.NDArray[np.bool_]) -> Score:
    """Scores attitudes against the truth, both sensor to the same earth frame with z vertical,
    where the sensor moves and there is truth. The error's heading is its turn about the vertical,
    its inclination the smallest turn that is left (Laidig, Caruso, Cereatti, Seel, Data 6(7),
    2021)."""
    counted = moving & np.isfinite(truth).all(axis=1)
    error = product(truth[counted], conjugate(estimate[counted]))
    error /= np.linalg.norm(error, axis=1, keepdims=True)
    w, z = np.abs(error[:, 0]), np.abs(error[:, 3])
    total = 2 * np.arccos(np.minimum(w, 1.0))
    heading = 2 * np.arctan2(z, w)
    inclination = 2 * np.arccos(np.minimum(np.hypot(w, z), 1.0))
    return Score(
        name,
        *(float(np.degrees(np.sqrt(np.mean(angle**2)))) for angle in (total, heading, inclination)),
    )


# --- recordings ---


def recordings_in(folder: Path) -> list[Path]:
    if not folder.is_dir():
        raise RecordingError(f"missing folder '{folder}'", f"give a folder with files *{SUFFIX}")
    found = sorted(folder.glob(f"*{SUFFIX}"))
    if not found:
        raise RecordingError(
            f"expected recordings *{SUFFIX} in '{folder}', found none", "give another folder"
        )
    return found


def unpack(path: Path) -> bytes:
    try:
        data = gzip.decompress(path.read_bytes())
    except EOFError:
        raise RecordingError(f"'{path}' is incomplete", "fetch the file again") from None
    except (gzip.BadGzipFile, zlib.error) as error:
        raise RecordingError(
            f"'{path}' is not a valid gzip file ({error})", "fetch the file again"
        ) from None
    except OSError as error:
        raise RecordingError(
            f"cannot read '{path}': {error.strerror}", "check the permissions of the file"
        ) from None
    if not data or len(data) % (4 * PLANES):
        raise RecordingError(
            f"expected {PLANES} planes of float32 in '{path}', found {len(data)} bytes",
            "see `./stator score --help` for the format",
        )
    return data


def planes_of(path: Path, data: bytes) -> Array:
    planes = np.frombuffer(data, "<f4").reshape(PLANES, -1).astype(np.float64)
    if not np.isfinite(planes[TRUTH, planes[MOVING] > 0.5]).all(axis=0).any():
        raise RecordingError(
            f"missing truth in '{path}' while the sensor moves", "remove this file"
        )
    return planes


# --- the node ---


def estimate(program: Path, data: bytes, samples: int) -> Array:
    """The attitude in the truth's frame for each sample: the newest that the graph published."""
    with tempfile.TemporaryDirectory() as folder:
        recording, log = Path(folder) / "recording", Path(folder) / "attitude.ulg"
        write_rows(recording, rows_of(data))
        run([program, "--recording", recording, "--log", log], check=True)
        return product(ENU_FROM_NED, attitudes_in(log, samples))


def rows_of(data: bytes) -> Array:
    """Rows for the playback board: both devices have a sample in each period."""
    planes = np.frombuffer(data, "<f4").reshape(PLANES, -1)
    times_us = (np.arange(planes.shape[1]) + 1) * float(PERIOD_US)
    gauss = planes[6:9] * np.float32(0.01)
    imu = np.zeros((planes.shape[1], COLUMNS))
    imu[:, 0] = imu[:, 2] = times_us
    mag = imu.copy()
    imu[:, 1], imu[:, 3:9] = IMU, planes[:6].T
    mag[:, 1], mag[:, 3:6] = MAG, gauss.T
    result: Array = np.stack([imu, mag], axis=1).reshape(-1, COLUMNS)
    return result


def attitudes_in(log: Path, samples: int) -> Array:
    from pyulog import ULog

    logged = ULog(str(log), ["vehicle_attitude"]).get_dataset("vehicle_attitude").data
    result = np.tile([1.0, 0.0, 0.0, 0.0], (samples, 1))
    times = (np.arange(samples) + 1) * PERIOD_US
    newest = np.searchsorted(logged["timestamp_sample"], times, side="right") - 1
    known = newest >= 0
    for i in range(4):
        result[known, i] = logged[f"q[{i}]"][newest[known]]
    return result


# --- peers ---


def peers_in(folder: Path, names: set[str]) -> dict[str, list[Score]]:
    """For each filter: its scores in peer_rmse.csv on the named recordings."""
    path = folder / "peer_rmse.csv"
    result: dict[str, list[Score]] = {}
    if not path.is_file():
        return result
    try:
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                if row["trial"] in names:
                    figures = (float(row[key]) for key in ("total", "heading", "incl"))
                    result.setdefault(row["filter"], []).append(Score(row["trial"], *figures))
    except (OSError, KeyError, TypeError, ValueError):
        raise RecordingError(
            f"expected the columns trial,filter,total,heading,incl in '{path}'", "correct the file"
        ) from None
    return result


# --- the command ---


def score(folder: Path) -> tuple[list[Score], dict[str, list[Score]]]:
    from stator.build.cmake import build

    paths = recordings_in(folder)
    peers = peers_in(folder, {path.name.removesuffix(SUFFIX) for path in paths})
    data = {path: unpack(path) for path in paths}
    planes = {path: planes_of(path, data[path]) for path in paths}
    program = build(GRAPH, BOARD)
    scores = []
    for path in paths:
        truth, moving = planes[path][TRUTH].T, planes[path][MOVING] > 0.5
        name = path.name.removesuffix(SUFFIX)
        scores.append(rmse(name, truth, estimate(program, data[path], len(moving)), moving))
    return scores, peers
