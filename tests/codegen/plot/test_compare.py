"""`./stator compare` and `plot --topic`: what differs between flights, and any topic drawn."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest

from stator import __main__ as cli


@pytest.fixture(scope="module")
def flights(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("flights")
    logs = folder / "a.ulg", folder / "b.ulg"
    ways = [], ["--param", "rate_control.roll_p=0.1", "--wind", "3"]
    for log, way in zip(logs, ways, strict=True):
        cli.main(["fly", "--json", "--duration", "12", "-o", str(log), *way])
    return logs


def compared(capsys: pytest.CaptureFixture[str], *arguments: object) -> dict[str, Any]:
    capsys.readouterr()
    assert cli.main(["compare", *map(str, arguments), "--json"]) == 0
    facts: dict[str, Any] = json.loads(capsys.readouterr().out)
    return facts


def texts(svg: Path) -> set[str]:
    return set(re.findall(r"<!-- (.*?) -->", svg.read_text()))


def test_figures_settings_and_parameters_that_differ(
    flights: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    facts = compared(capsys, *flights)
    assert not facts["identical"]
    (row,) = facts["params"]
    assert row["name"] == "rate_control.roll_p"
    assert row["values"] == pytest.approx([0.22, 0.1])
    assert facts["settings"] == [{"name": "wind (m/s)", "values": [0.0, 3.0]}]
    assert facts["graph_hash"][0] == facts["graph_hash"][1]
    assert facts["graph_differences"] == []
    figures = {row["key"]: row for row in facts["figures"]}
    first, second = figures["take_off_s"]["values"]
    assert figures["take_off_s"]["difference"] == pytest.approx(second - first)
    picture = flights[1].with_name("a-vs-b.png")
    assert facts["picture"] == str(picture)
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_a_flight_and_itself(
    flights: tuple[Path, Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    facts = compared(capsys, flights[0], flights[0], "-o", tmp_path / "p.png")
    assert facts["identical"]
    assert facts["params"] == facts["settings"] == facts["graph_differences"] == []


def test_nodes_and_topics_that_differ_are_named(
    flights: tuple[Path, Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    graph = tmp_path / "more.yaml"
    graph.write_text(
        "board: fmu_v2\ninclude: [{file: quad.yaml}]\n"
        "nodes: {attitude_control: {trigger: {topic: vehicle_attitude, min_interval: 8 ms}}, "
        "baro0: {device: baro0, trigger: {every: 20 ms}, priority: 7, "
        "outputs: {pressure: sensor_baro}}}\n"
    )
    log = tmp_path / "more.ulg"
    cli.main(["fly", str(graph), "--json", "--duration", "1", "-o", str(log)])
    facts = compared(capsys, flights[0], log)
    assert facts["graph"] == ["quad", "more"]
    assert facts["graph_hash"][0] != facts["graph_hash"][1]
    assert {"what": "topic sensor_baro", "how": "only in B"} in facts["graph_differences"]
    assert {"what": "node baro0", "how": "only in B"} in facts["graph_differences"]
    cli.main(["compare", str(flights[0]), str(log)])
    output = capsys.readouterr().out
    assert "  name: quad -> more\n" in output
    assert "  node baro0: only in B\n" in output


def test_the_report_for_people(
    flights: tuple[Path, Path], capsys: pytest.CaptureFixture[str]
) -> None:
    assert cli.main(["compare", *map(str, flights)]) == 0
    output = capsys.readouterr().out
    assert re.search(r"^  take-off at +\d.* \+?-?\d\S* s$", output, re.MULTILINE)
    assert "parameters that differ\n  rate_control.roll_p: 0.22 -> 0.1\n" in output
    assert "graph: equal" in output


def test_a_sweep(
    flights: tuple[Path, Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    """Three flights: a column and a line of the picture for each."""
    logs = [flights[0], flights[1], flights[0]]
    facts = compared(capsys, *logs, "-o", tmp_path / "p.svg")
    assert not facts["identical"]
    (row,) = facts["params"]
    assert row["values"] == pytest.approx([0.22, 0.1, 0.22])
    assert all(row["difference"] is None for row in facts["figures"])
    assert {"A: quad", "B: quad", "C: quad"} <= texts(tmp_path / "p.svg")
    topic = ["--topic", "vehicle_local_position.z"]
    assert cli.main(["compare", *map(str, logs), *topic, "-o", str(tmp_path / "t.svg")]) == 0
    output = capsys.readouterr().out
    take_off = next(line for line in output.splitlines() if line.startswith("  take-off at"))
    assert take_off.split()[2] == take_off.split()[4]
    assert "  rate_control.roll_p: 0.22 -> 0.1 -> 0.22\n" in output
    assert {"A", "B", "C"} <= texts(tmp_path / "t.svg")
    assert cli.main(["compare", *[str(logs[0])] * 9]) == 2
    assert "error: expected at most 8 logs, found 9\n" in capsys.readouterr().err


def test_the_picture_has_both(
    flights: tuple[Path, Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    compared(capsys, *flights, "-o", tmp_path / "p.svg")
    shown = texts(tmp_path / "p.svg")
    assert {"A: quad", "B: quad", "altitude (m)", "tilt (deg)", "error (m)"} <= shown
    assert "rate_control.roll_p 0.22 -&gt; 0.1" in shown or any("0.22" in t for t in shown)


def test_topics_of_both(
    flights: tuple[Path, Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    way = ["--topic", "vehicle_local_position.z", "--topic", "vehicle_attitude.q"]
    compared(capsys, *flights, *way, "-o", tmp_path / "p.svg")
    assert {"A", "B", "A q[0]", "B q[3]", "a and b"} <= texts(tmp_path / "p.svg")


def test_topics_of_one_log_with_units_and_modes(flights: tuple[Path, Path], tmp_path: Path) -> None:
    svg = tmp_path / "t.svg"
    way = ["--topic", "vehicle_local_position.z", "--topic", "actuator_motors.control"]
    assert cli.main(["plot", str(flights[0]), *way, "-o", str(svg)]) == 0
    shown = texts(svg)
    assert {"z (m)", "control", "control[0]", "control[3]", "disarmed", "take-off"} <= shown
    assert "control[4]" not in shown  # not a number: the vehicle has four
    assert cli.main(["plot", str(flights[0]), "--topic", "vehicle_attitude.q[1]"]) == 0
    assert flights[0].with_name("a.topics.png").is_file()


@pytest.mark.parametrize(
    ("topic", "message"),
    [
        ("vehicle_atitude.q", "unknown topic 'vehicle_atitude'"),
        ("log_block", "topic 'log_block' has no sample in the log"),
        ("vehicle_attitude.p", "unknown field 'p' of topic 'vehicle_attitude'\nhint: known: q"),
        ("vehicle_attitude.q[7]", "unknown field 'q[7]'"),
        ("vehicle_local_position", "expected at most 12 quantities, found"),
    ],
)
def test_what_the_log_does_not_have(
    topic: str,
    message: str,
    flights: tuple[Path, Path],
    capsys: pytest.CaptureFixture[str],
) -> None:
    capsys.readouterr()
    assert cli.main(["plot", str(flights[0]), "--topic", topic]) == 2
    assert message in capsys.readouterr().err
    assert cli.main(["compare", str(flights[0]), str(flights[1]), "--topic", topic]) == 2


def test_a_log_that_cannot_be_read(
    flights: tuple[Path, Path], capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    assert cli.main(["compare", str(flights[0]), str(tmp_path / "none.ulg")]) == 2
    assert "cannot read" in capsys.readouterr().err
