"""The tutorial that replaces a node: its files fly outside the repository, and its hint is true."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from tests.docs.test_guide import FENCE

from stator import HOME
from stator import __main__ as cli

TEXT = (HOME / "docs" / "replace.md").read_text(encoding="utf-8")
NULLS = ", inputs: {status: null}"


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in FENCE.findall(TEXT):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_hint_is_the_one_of_the_text(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    graph = project / "my_quad.yaml"
    text = graph.read_text()
    assert NULLS in text
    graph.write_text(text.replace(NULLS, ""))
    assert cli.main(["check", "my_quad.yaml"]) == 1
    errors = capsys.readouterr().err.replace(f"{HOME}/", "")
    flat = re.sub(r"\s+", " ", TEXT)
    said = [line for line in errors.splitlines() if "error: " in line or line.startswith("hint: ")]
    assert len(said) == 2
    for line in said:
        assert line.removeprefix("my_quad.yaml:4:14: ") in flat
    written = said[1].split("`")[1]
    graph.write_text(text.replace("  attitude: {app: my_attitude" + NULLS + "}", f"  {written}"))
    assert cli.main(["check", "my_quad.yaml"]) == 0


def test_the_quad_flies_with_the_other_estimator_and_the_gains_that_were_found(
    project: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    gains = ["--param=attitude.tilt_gain=0.5", "--param=attitude.bias_gain=0.3"]
    results = {}
    for graph, way in (("my_quad", []), ("my_quad", gains), ("tuned_quad", [])):
        capsys.readouterr()
        cli.main(["fly", f"{graph}.yaml", "-o", "after.ulg", "--json", *way])
        facts = json.loads(capsys.readouterr().out)
        results[graph, bool(way)] = facts["success"], f"{facts['attitude_error_deg']:.2f} deg"
    assert results["my_quad", False] == (False, "1.73 deg")
    assert results["my_quad", True] == results["tuned_quad", False] == (True, "0.42 deg")
    assert all(error in TEXT for _, error in results.values())
    assert cli.main(["explain", "tuned_quad.yaml", "attitude"]) == 0
    assert re.search(r"app +apps/my_attitude\n", capsys.readouterr().out)
