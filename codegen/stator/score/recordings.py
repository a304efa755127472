"""Recordings of flights in the formats of other projects, as rows for the board `playback`."""

from __future__ import annotations

import csv
import gzip
import io
import zipfile
import zlib
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from stator.diagnostics import UserError

Array = npt.NDArray[np.float64]

IMU, MAG, GNSS, BARO = range(4)  # boards/playback/recording.hpp
COLUMNS = 12  # arrival_us, device, timestamp_sample, nine values
START_US = 1_000_000  # the time 0 of a recording
NO_HEIGHT = 1000.0  # m: an error so large that the height is not used
REPLAYS = ("_replay.csv.gz", "_replay.csv")


class RecordingError(UserError):
    """The recordings are missing or wrong; the message says what to do."""

    def __init__(self, problem: str, hint: str) -> None:
        super().__init__(f"error: {problem}\nhint: {hint}")


@dataclass(frozen=True)
class Flight:
    """A recorded flight, with the results of the onboard software and of other software."""

    name: str
    path: Path
    rows: Array
    # Columns t_us, roll, pitch, yaw [rad].
    onboard: Array = field(default_factory=lambda: np.zeros((0, 4)))
    peer: dict[str, Array] = field(default_factory=dict)
    # Columns t_us, quaternion wxyz, velocity N E D, position N E D.
    reference: Array = field(default_factory=lambda: np.zeros((0, 11)))

    def of(self, device: int) -> Array:
        result: Array = self.rows[self.rows[:, 1] == device]
        return result


def pressure_at(height_m: Array) -> Array:
    """Of the standard atmosphere (ISO 2533), Pa."""
    result: Array = 101325.0 * np.maximum(1.0 - height_m / 44330.8, 1e-3) ** (1 / 0.190263)
    return result


def block(device: int, arrival_ms: Array, delay_ms: float, *values: Array | float) -> Array:
    """Rows of a device whose samples arrive `delay_ms` after their measurement."""
    rows = np.zeros((len(arrival_ms), COLUMNS))
    rows[:, 0] = np.round(arrival_ms * 1e3) + START_US
    rows[:, 1] = device
    rows[:, 2] = np.maximum(rows[:, 0] - 1e3 * delay_ms, 1)
    for i, value in enumerate(values):
        rows[:, 3 + i] = value
    return rows


def write_rows(path: Path, rows: Array) -> None:
    path.write_bytes(rows.astype("<f8").tobytes())


def merged(blocks: list[Array]) -> Array:
    """In order of arrival, finite, and each device's samples newer than the one before."""
    kept = []
    for rows in blocks:
        good = rows[np.isfinite(rows).all(axis=1)]
        newest = np.maximum.accumulate(np.append(-1.0, good[:-1, 2])) if len(good) else good[:, 2]
        kept.append(good[good[:, 2] > newest])
    rows = np.concatenate(kept)
    result: Array = rows[np.argsort(rows[:, 0], kind="stable")]
    return result


# --- zip files of text tables, in the format of the InertialNav project ---


def member(archive: zipfile.ZipFile, name: str) -> str | None:
    """The table of this name, in any folder of the archive."""
    found = [entry for entry in archive.namelist() if entry.rsplit("/", 1)[-1] == name]
    return min(found, key=len, default=None)


def table(archive: zipfile.ZipFile, path: Path, name: str, columns: int) -> Array:
    try:
        text = archive.read(member(archive, name) or name).decode()
        rows = [line.split()[:columns] for line in text.splitlines() if line.strip()]
        result = np.array([row for row in rows if len(row) == columns], dtype=np.float64)
    except KeyError:
        raise RecordingError(
            f"missing {name} in '{path}'", "a flight needs IMU, GPS, MAG, NTUN, ATT and timing.txt"
        ) from None
    except (ValueError, zipfile.BadZipFile, zlib.error):
        raise RecordingError(f"cannot read {name} in '{path}'", "fetch the file again") from None
    if not len(result):
        raise RecordingError(
            f"expected rows of {columns} numbers in {name} of '{path}'", "see ./stator score --help"
        )
    return result


def read_tables(path: Path) -> Flight:
    """A zip of IMU.txt (ms twice, gyro, accelerometer), GPS.txt, MAG.txt (milligauss, offsets to
    take off), NTUN.txt (barometer's height in column 9), ATT.txt (degrees), timing.txt (delays)."""
    try:
        archive = zipfile.ZipFile(path)
    except (zipfile.BadZipFile, OSError):
        raise RecordingError(f"'{path}' is not a valid zip file", "fetch the file again") from None
    with archive:
        imu = table(archive, path, "IMU.txt", 8)
        gps = table(archive, path, "GPS.txt", 14)
        mag = table(archive, path, "MAG.txt", 8)
        ntun = table(archive, path, "NTUN.txt", 10)
        att = table(archive, path, "ATT.txt", 5)
        timing = table(archive, path, "timing.txt", 1)[:, 0]
        raw = table(archive, path, "GPSraw.txt", 7) if member(archive, "GPSraw.txt") else None
    if len(timing) < 8:
        raise RecordingError(
            f"expected nine numbers in timing.txt of '{path}', found fewer", "fetch the file again"
        )
    velocity_ms, position_ms, height_ms, mag_ms = timing[3:7]

    def arrival(stamps: Array) -> Array:
        """The time of the first IMU sample that is not earlier than the row."""
        at = np.searchsorted(imu[:, 0], stamps)
        result: Array = imu[np.minimum(at, len(imu) - 1), 1]
        return result

    course = np.radians(gps[:, 11])
    north, east, down = gps[:, 10] * np.cos(course), gps[:, 10] * np.sin(course), gps[:, 12]
    if raw is not None and len(raw) == len(gps):
        north, east, down = raw[:, 4], raw[:, 5], raw[:, 6]
    fixes = gps[:, 1] >= 3
    fix = block(
        GNSS,
        arrival(gps[:, 0]),
        (velocity_ms + position_ms) / 2,
        *(gps[:, 6], gps[:, 7], gps[:, 9], north, east, down, 0.0, NO_HEIGHT, 0.0),
    )
    field_gauss = 1e-3 * (mag[:, 2:5] - mag[:, 5:8])
    rows = merged(
        [
            block(IMU, imu[:, 1], 0.0, *imu[:, 2:8].T),
            block(MAG, arrival(mag[:, 0]), mag_ms, *field_gauss.T),
            fix[fixes],
            block(BARO, arrival(ntun[:, 0]), height_ms, pressure_at(ntun[:, 8])),
        ]
    )
    onboard = np.column_stack([arrival(att[:, 0]) * 1e3 + START_US, np.radians(att[:, 2:5])])
    name = path.name.removesuffix(".zip")
    return Flight(name, path, rows, onboard=onboard, peer=read_peer(path.parent, name))


def read_peer(folder: Path, name: str) -> dict[str, Array]:
    """Columns of NAME_peer_*.csv.gz by name; empty if there is no such file."""
    found = sorted(folder.glob(f"{name}_peer_*.csv.gz"))
    if not found:
        return {}
    try:
        with gzip.open(found[0], "rt", encoding="utf-8") as file:
            header = file.readline().strip().split(",")
            values = np.loadtxt(file, delimiter=",", ndmin=2)
        return {key: values[:, i] for i, key in enumerate(header)}
    except (OSError, EOFError, ValueError, IndexError, zlib.error):
        raise RecordingError(f"cannot read '{found[0]}'", "fetch the file again") from None


# --- replay files of PX4's estimator tests ---


def read_px4_replay(path: Path) -> Flight:
    """Rows t_us,type,values: imu (accelerometer, gyro), mag [gauss], baro [m], gps (height in mm,
    longitude and latitude in 1e-7 deg, velocity N, E, D)."""
    samples: dict[str, list[list[float]]] = {"imu": [], "mag": [], "baro": [], "gps": []}
    try:
        data = path.read_bytes()
        text = (gzip.decompress(data) if path.suffix == ".gz" else data).decode()
        for row in csv.reader(io.StringIO(text)):
            if len(row) > 2 and row[1] in samples:
                samples[row[1]].append([float(row[0]) * 1e-3, *map(float, row[2:])])
        imu, mag, baro, gps = (np.array(rows, ndmin=2) for rows in samples.values())
        rows = merged(
            [
                block(IMU, imu[:, 0], 0.0, *imu[:, 4:7].T, *imu[:, 1:4].T),
                block(MAG, mag[:, 0], 0.0, *mag[:, 1:4].T),
                block(
                    GNSS,
                    gps[:, 0],
                    110.0,  # the value that the reference uses
                    *(gps[:, 3] * 1e-7, gps[:, 2] * 1e-7, gps[:, 1] * 1e-3),
                    *(*gps[:, 4:7].T, 0.0, 0.0, 0.0),
                ),
                block(BARO, baro[:, 0], 0.0, pressure_at(baro[:, 1])),
            ]
        )
    except (OSError, EOFError, ValueError, IndexError, zlib.error):
        raise RecordingError(
            f"expected rows of t_us,type,values in '{path}'", "fetch the file again"
        ) from None
    name = path.name.removesuffix(".gz").removesuffix(REPLAYS[1])
    return Flight(name, path, rows, reference=read_reference(path.parent, name))


def read_reference(folder: Path, name: str) -> Array:
    found = sorted(folder.glob(f"{name}_reference*.csv"))
    if not found:
        return np.zeros((0, 11))
    try:
        values: Array = np.loadtxt(found[-1], delimiter=",", skiprows=1, ndmin=2)[:, :11]
    except (OSError, ValueError, IndexError):
        raise RecordingError(f"cannot read '{found[-1]}'", "fetch the file again") from None
    values[:, 0] += START_US
    return values


def flights_in(folder: Path) -> list[Flight]:
    if not folder.is_dir():
        raise RecordingError(f"missing folder '{folder}'", "give a folder with recorded flights")
    tables = [read_tables(path) for path in sorted(folder.glob("*.zip"))]
    named = [path for path in sorted(folder.iterdir()) if path.name.endswith(REPLAYS)]
    replays = [read_px4_replay(path) for path in named]
    if not tables and not replays:
        raise RecordingError(
            f"expected recorded flights in '{folder}', found none",
            f"give a folder with files *.zip or *{REPLAYS[0]}",
        )
    return tables + replays
