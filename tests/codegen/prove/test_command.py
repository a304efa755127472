"""`prove` as a command, on the quadrotor and on what it cannot prove; `budgets/BOARD.yaml`."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from tests.codegen.prove.graphs import written

from stator.__main__ import main
from stator.pipeline import make_plan
from stator.prove.budget_file import Row, counted, file_text, join, read_rows

ROOT = Path(__file__).resolve().parents[3]
QUAD = ROOT / "graph" / "quad.yaml"


def test_the_quad_is_proven_on_the_pixhawk(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["prove", str(QUAD), "--board", "fmu_v2", "--no-image", "--json"]) == 0
    facts = json.loads(capsys.readouterr().out)
    assert facts["proven"] is True
    assert facts["weakest_provenance"] == "guessed"
    assert facts["errors"] == []
    (chain,) = facts["chains"]
    assert chain["name"] == "gyro_to_motor"
    assert 50_000 < chain["reaction_ns"] < 500_000 == chain["deadline_ns"]
    for task in facts["tasks"]:
        assert task["budget_ns"] < task["response_ns"] <= task["deadline_ns"]
        assert task["slack_ns"] == task["deadline_ns"] - task["response_ns"]
    assert facts["memory"]["topic_bytes"]["sensor_gyro"] > 0
    assert facts["stack_bytes"] is None


def test_nobody_overlooks_a_guess(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["prove", str(QUAD), "--board", "fmu_v2", "--no-image"]) == 0
    last = capsys.readouterr().out.splitlines()[-1]
    assert last.startswith("PROVEN ONLY IF GUESSES HOLD. Nothing has measured: costs of fmu_v2")


@pytest.mark.parametrize(
    ("board", "text"),
    [
        ("sitl", "error: cannot prove a graph on board 'sitl': executor virtual\n"),
        ("linux", "error: cannot prove a graph on board 'linux': executor pthread\n"),
    ],
)
def test_boards_that_cannot_be_proven(
    board: str, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["prove", str(QUAD), "--board", board]) == 2
    assert capsys.readouterr().err.startswith(text)


def test_the_weakest_of_all(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    graph = written(
        tmp_path,
        """
        nodes:
          one: {app: stage, trigger: {every: 1 ms}, priority: 2}
          two: {app: stage, trigger: {every: 1 ms}, priority: 1}
        """,
    )
    (tmp_path / "budgets").mkdir()
    budgets = tmp_path / "budgets" / "bench.yaml"
    for sources, weakest, words in (
        (("hardware", "hardware"), "hardware", "proven; all times are measured on hardware"),
        (("hardware", "emulated"), "emulated", "PROVEN FOR THE EMULATOR'S INSTRUCTION COUNTS"),
        (("guessed", "emulated"), "guessed", "PROVEN ONLY IF GUESSES HOLD"),
    ):
        rows = zip(("one", "two"), sources, strict=True)
        budgets.write_text("".join(f"{n}: {{budget: 9 us, from: {s}}}\n" for n, s in rows))
        assert main(["prove", str(graph)]) == 0
        assert words in capsys.readouterr().out
        assert main(["prove", str(graph), "--json"]) == 0
        assert json.loads(capsys.readouterr().out)["weakest_provenance"] == weakest


def test_the_budgets_of_a_graph_count_before_those_of_all_graphs(tmp_path: Path) -> None:
    graph = written(
        tmp_path,
        """
        nodes:
          one: {app: stage, trigger: {every: 1 ms}, priority: 2}
          two: {app: stage, trigger: {every: 1 ms}, priority: 1}
        """,
    )
    (tmp_path / "budgets").mkdir()
    (tmp_path / "budgets" / "bench.yaml").write_text(
        f"{graph.stem}.one: 5 us\none: 9 us\nother.one: 7 us\ntwo: 8 us\nother.two: 6 us\n"
    )
    nodes = make_plan(str(graph), None).graph.nodes
    assert (nodes["one"].budget_us, nodes["two"].budget_us) == (5, 8)


def test_a_budget_of_counts() -> None:
    # 418 instructions of 12 ns, with a margin of 2, in whole microseconds.
    assert counted(418, 12) == Row(11, "emulated", 418)


def test_budgets_are_joined(tmp_path: Path) -> None:
    """The larger count of two flights holds; a guess gives way, and hardware stays."""
    small, large = counted(100, 12), counted(200, 12)
    guess, measured = Row(5, "guessed"), Row(7, "hardware")
    old = {"a": large, "b": small, "c": guess, "d": measured, "e": guess}
    joined = join(old, {"a": small, "b": large, "c": small, "d": large, "f": small})
    assert joined == {
        **{"a": large, "b": large, "c": small, "d": measured, "e": guess, "f": small},
    }
    file = tmp_path / "bench.yaml"
    file.write_text(file_text(joined, "bench", 12))
    assert read_rows(file) == joined
    assert read_rows(tmp_path / "absent.yaml") == {}
