"""Reads a mission from YAML or from a ground station's file, and checks it."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from stator.diagnostics import MAX_BYTES, UserError
from stator.mission.check import check
from stator.mission.plan_file import read_json
from stator.mission.problems import Problems
from stator.mission.text_file import read_text
from stator.mission.vehicle import Vehicle
from stator.mission.yaml import read_yaml

if TYPE_CHECKING:
    from pathlib import Path

    from stator.mission.model import Mission


def read_mission(path: Path, vehicle: Vehicle | None = None) -> Mission:
    """Checked against this vehicle. Raises `UserError` or `Failed`, with every error."""
    try:
        with path.open("rb") as file:
            content = file.read(MAX_BYTES + 1)
    except OSError as error:
        raise UserError(
            f"error: cannot read the mission '{path}': {error.strerror}\n"
            "hint: give a mission, for example graph/missions/square.yaml or a ground station's "
            ".plan"
        ) from error
    problems = Problems(path)
    if len(content) > MAX_BYTES:
        problems.add(0, f"expected at most {MAX_BYTES} bytes, found more", "give a mission")
        problems.stop()
    start = content[:64].removeprefix(b"\xef\xbb\xbf").lstrip()
    if start.startswith((b"{", b"QGC WPL")):
        mission = _read_ground_station(content, problems)
    else:
        mission = read_yaml(path, problems)
    notes = check(mission, vehicle or Vehicle(), problems)
    problems.stop()
    return replace(mission, notes=(*mission.notes, *notes))


def _read_ground_station(content: bytes, problems: Problems) -> Mission:
    try:
        text = content.decode("utf-8-sig").lstrip()
    except UnicodeDecodeError as error:
        problems.add(0, f"expected UTF-8, found another encoding: {error}", "save it as UTF-8")
        problems.stop()
        raise
    return read_text(text, problems) if text.startswith("QGC WPL") else read_json(text, problems)
