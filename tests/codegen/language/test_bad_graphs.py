"""Every graph of bad/ gives exactly the errors of the .stderr file beside it.

A case is bad/NAME.yaml, with the apps, messages, drivers and boards of bad/, or a folder
bad/NAME/ with a graph.yaml and files of its own. A first line `# stator check ...` gives arguments.
STATOR_UPDATE=1 rewrites the expected output: read what changed, as a user would, before keeping it.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

import pytest

from stator.__main__ import main
from stator.rules import PROOF_RULES, RULES

BAD = Path(__file__).parent / "bad"
CODE = Path(__file__).parents[3] / "codegen" / "stator"
GRAPHS = sorted([*BAD.glob("*.yaml"), *BAD.glob("*/graph.yaml")])


def name_of(graph: Path) -> str:
    return graph.stem if graph.parent == BAD else graph.parent.name


def expected_file(graph: Path) -> Path:
    return BAD / f"{name_of(graph)}.stderr"


def arguments(graph: Path) -> list[str]:
    first = graph.read_bytes().split(b"\n", 1)[0].decode(errors="replace")
    match = re.fullmatch(r"# stator check \S+\.yaml (.*)", first)
    return match.group(1).split() if match else []


def place(graph: Path, folder: Path) -> Path:
    """The graph itself; or, where it says so, a copy that is as large as it says."""
    match = re.match(rb"# Padded to (\d+) bytes\.\n", graph.read_bytes())
    if match is None:
        return graph
    copy = folder / graph.name
    copy.write_bytes(graph.read_bytes().ljust(int(match.group(1)), b"\n"))
    return copy


@pytest.mark.parametrize("graph", GRAPHS, ids=name_of)
def test_says_what_is_wrong(
    graph: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    placed = place(graph, tmp_path)
    monkeypatch.chdir(placed.parent)
    status = main(["check", placed.name, *arguments(graph)])
    written = capsys.readouterr()
    assert status == 1
    assert written.out == ""
    if os.environ.get("STATOR_UPDATE"):
        expected_file(graph).write_text(written.err, encoding="utf-8")
    expected = expected_file(graph)
    assert expected.is_file(), "no expected output; write it with STATOR_UPDATE=1, then read it"
    assert written.err == expected.read_text(encoding="utf-8")


def test_every_expected_output_has_its_graph() -> None:
    assert {path.stem for path in BAD.glob("*.stderr")} == {name_of(graph) for graph in GRAPHS}


def test_there_are_a_hundred() -> None:
    assert len(GRAPHS) >= 100


def rules_shown(graph: Path, folder: Path) -> set[str]:
    from stator.diagnostics import Failed
    from stator.pipeline import make_plan

    given = arguments(graph)
    try:
        make_plan(str(place(graph, folder)), given[1] if given else None)
    except Failed as failed:
        return {error.rule for error in failed.errors}
    return set()


def test_every_rule_has_a_bad_graph(tmp_path: Path) -> None:
    shown: set[str] = set()
    for graph in GRAPHS:
        shown |= rules_shown(graph, tmp_path)
    assert sorted(set(RULES) - shown) == []


def test_every_rule_of_the_code_is_listed() -> None:
    """And every listed one is used: a rule is the second argument of `error`, or the first item of
    what a shape says is wrong."""
    code = "".join(
        path.read_text(encoding="utf-8")
        for path in sorted(CODE.rglob("*.py"))
        if path.name != "rules.py"
    )
    used = set(re.findall(r"\.error\([^\"]*?\"([a-z]+(?:-[a-z]+)+)\"", code))
    listed = RULES | PROOF_RULES
    assert sorted(used - set(listed)) == []
    assert [rule for rule in listed if f'"{rule}"' not in code] == []


def test_a_rule_that_is_not_listed_is_refused() -> None:
    from stator.diagnostics import Mark, Report

    with pytest.raises(AssertionError, match="not listed"):
        Report().error(Mark(BAD, 1, 1), "no-such-rule", "")
