"""The guide's first node: its files are taken from the text, built, flown, and found in the log."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from pyulog import ULog

from stator import HOME
from stator import __main__ as cli

# A fence that names the file it shows: ```yaml messages/Tilt.yaml
FENCE = re.compile(r"^```(?:yaml|cpp) (\S+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def files() -> dict[str, str]:
    return dict(FENCE.findall((HOME / "docs" / "guide.md").read_text(encoding="utf-8")))


def test_a_new_node_takes_under_25_lines() -> None:
    texts = [text for name, text in files().items() if not name.startswith("tests/")]
    lines = [line for text in texts for line in text.splitlines() if line.strip()]
    assert 0 < len(lines) < 25


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A folder with the guide's files."""
    for name, text in files().items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return tmp_path


def test_the_guides_tests_pass(
    project: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(project)
    assert cli.main(["test"]) == 0
    assert capfd.readouterr().out.splitlines()[-1] == "2 passed, 0 failed, 0 skipped"


def test_the_guides_node_flies(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status = cli.main(["fly", str(project / "tilt_quad.yaml"), "--json"])
    facts = json.loads(capsys.readouterr().out)
    assert (status, facts["success"]) == (0, True)
    tilt = ULog(facts["log"], ["tilt"]).get_dataset("tilt").data
    # Woken at most every 10 ms and logged by default: published at up to 100 Hz, so each sample.
    assert len(tilt["timestamp"]) == pytest.approx(facts["duration_s"] * 100, rel=0.02)
    assert tilt["angle"].min() >= 0.0
    assert tilt["angle"].max() < 0.5


def test_the_readme_shows_the_graph_as_it_is() -> None:
    """Each line of the README's graph stands in graph/quad.yaml."""
    readme = (HOME / "README.md").read_text(encoding="utf-8")
    snippet = readme.split("```yaml\n")[1].split("```")[0]
    quad = (HOME / "graph" / "quad.yaml").read_text(encoding="utf-8").splitlines()
    for line in snippet.splitlines():
        assert line in quad


def test_the_picture_shows_every_node_and_topic(tmp_path: Path) -> None:
    """docs/quad.svg was drawn from the graph as it is now."""
    drawn = tmp_path / "quad.svg"
    assert cli.main(["graph", str(HOME / "graph" / "quad.yaml"), "-o", str(drawn)]) == 0
    assert words(drawn) == words(HOME / "docs" / "quad.svg"), (
        "draw it again: ./stator graph graph/quad.yaml -o docs/quad.svg"
    )


def words(picture: Path) -> list[str]:
    """Texts of a picture; their places depend on Graphviz's version."""
    return sorted(re.findall(r"<text[^>]*>([^<]+)</text>", picture.read_text(encoding="utf-8")))
