"""What `prove` says of graphs that it cannot prove: bad/NAME.yaml gives bad/NAME.txt.

STATOR_UPDATE=1 rewrites the expected output: read what changed, as a user would, before keeping it.
"""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest
from tests.codegen.prove.graphs import PARTS

from stator.__main__ import main
from stator.rules import PROOF_RULES

BAD = Path(__file__).with_name("bad")
GRAPHS = sorted(BAD.glob("*.yaml"))


@pytest.mark.parametrize("graph", GRAPHS, ids=lambda graph: graph.stem)
def test_says_what_is_late(
    graph: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    shutil.copytree(PARTS, tmp_path, dirs_exist_ok=True)
    shutil.copy(graph, tmp_path)
    monkeypatch.chdir(tmp_path)
    status = main(["prove", graph.name])
    written = capsys.readouterr()
    assert status == (2 if "missing" in graph.stem else 1)
    text = written.out + written.err.replace(str(Path.home()), "~")
    expected = graph.with_suffix(".txt")
    if os.environ.get("STATOR_UPDATE"):
        expected.write_text(text, encoding="utf-8")
    assert text == expected.read_text(encoding="utf-8")


def test_each_rule_has_an_example() -> None:
    assert {graph.stem.replace("_", "-") for graph in GRAPHS} == set(PROOF_RULES)
