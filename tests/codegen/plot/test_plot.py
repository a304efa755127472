"""`./stator plot`: what is in the picture, and what is said about logs that cannot be drawn."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from stator import __main__ as cli


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    log = tmp_path_factory.mktemp("flight") / "flight.ulg"
    assert cli.main(["fly", "--json", "-o", str(log)]) == 0
    return log


def texts(svg: Path) -> set[str]:
    """What the picture says: the SVG has each text as a comment."""
    return set(re.findall(r"<!-- (.*?) -->", svg.read_text()))


def test_a_picture_shows_path_altitude_attitude_motors_and_modes(log: Path) -> None:
    svg = log.with_name("flight.svg")
    assert cli.main(["plot", str(log), "-o", str(svg)]) == 0
    shown = texts(svg)
    assert {"north (m)", "east (m)", "altitude (m)", "attitude (deg)", "motors (%)"} <= shown
    assert {"hold", "take-off", "landing"} <= shown
    assert {"truth", "estimate", "setpoint", "start", "end"} <= shown
    assert "quad, seed 1: landed and disarmed, within all limits" in shown


def test_the_same_flight_gives_the_same_bytes(log: Path) -> None:
    pictures = [log.with_name(f"{name}.svg") for name in "ab"]
    for picture in pictures:
        assert cli.main(["plot", str(log), "-o", str(picture)]) == 0
    assert pictures[0].read_bytes() == pictures[1].read_bytes()


def test_the_default_is_a_png_beside_the_log(log: Path) -> None:
    assert cli.main(["plot", str(log)]) == 0
    assert log.with_suffix(".png").read_bytes().startswith(b"\x89PNG")


def test_a_broken_limit_is_drawn_where_it_broke(log: Path, tmp_path: Path) -> None:
    failed = tmp_path / "failed.ulg"
    failed.write_bytes(log.read_bytes())
    problem = {"text": "hover: 1 m off", "time_s": 20.0, "position_m": [1.0, 0.0, -2.0]}
    facts = {"success": False, "reason": "hover: 1 m off", "seed": 3, "problems": [problem]}
    failed.with_suffix(".json").write_text(json.dumps(facts))
    assert cli.main(["plot", str(failed), "-o", str(tmp_path / "f.svg")]) == 0
    shown = texts(tmp_path / "f.svg")
    assert "limit broken" in shown
    assert "quad, seed 3: FAILED: hover: 1 m off" in shown
    assert "truth" not in shown  # there is no record of the truth beside this log


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("absent.ulg", None, "No such file or directory\nhint: ./stator fly writes a log"),
        (".", None, "Is a directory\nhint: ./stator fly writes a log"),
        ("text.ulg", b"not a log", "as ULog: "),
    ],
)
def test_a_log_that_cannot_be_read(
    name: str,
    content: bytes | None,
    message: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    if content is not None:
        (tmp_path / name).write_bytes(content)
    assert cli.main(["plot", str(tmp_path / name)]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / name).with_suffix(".png").exists()


def test_a_kind_of_picture_that_is_none(log: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["plot", str(log), "-o", str(log.with_name("flight.doc"))]) == 2
    assert (
        "expected a file name that ends in .png, .svg, .pdf, found 'flight.doc'\nhint: "
        in capsys.readouterr().err
    )
