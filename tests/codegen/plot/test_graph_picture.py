"""`./stator graph`: what is in the picture, and that it stays readable."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from stator import HOME
from stator import __main__ as cli
from stator.charts.graph import View, dot
from stator.pipeline import make_plan
from stator.plan.plan import Plan


@pytest.fixture(scope="module")
def plan() -> Plan:
    return make_plan(str(HOME / "graph" / "quad_outdoor.yaml"), None)


def arrows(text: str) -> list[tuple[str, str, str]]:
    """From, to, and how."""
    return re.findall(r"^  (\w+) -> (\w+) \[(.*)\];$", text, re.MULTILINE)


def boxes(text: str) -> dict[str, str]:
    return dict(re.findall(r"^  (\w+) \[(label=<.*)\];$", text, re.MULTILINE))


def test_each_pair_of_nodes_has_at_most_one_arrow(plan: Plan) -> None:
    text = dot(plan)
    pairs = [(begin, end) for begin, end, _ in arrows(text)]
    assert len(pairs) == len(set(pairs))
    assert boxes(text).keys() == plan.graph.nodes.keys()


def test_no_topic_is_left_out(plan: Plan) -> None:
    """It stands at an arrow that wakes, or in the box of its reader; values of parameters have an
    arrow without a name."""
    text = dot(plan)
    named = {(end, way) for _, end, way in arrows(text)}
    for topic in plan.topics.values():
        for reader, _ in topic.readers if topic.publishers else ():
            if plan.graph.nodes[reader].trigger_of(topic.name) is not None:
                assert any(end == reader and topic.name in way for end, way in named)
            elif topic.name.endswith("_params"):
                assert any(end == reader for _, end, _ in arrows(text))
            elif topic.publishers != (reader,):
                assert f"<I>{topic.name}</I>" in boxes(text)[reader]


def test_only_what_wakes(plan: Plan) -> None:
    text = dot(plan, View(wakes=True))
    shown = [way for _, _, way in arrows(text) if "style=invis" not in way]
    assert shown
    assert all("penwidth=1.6" in way for way in shown)
    assert "<I>" not in text
    assert boxes(text).keys() == plan.graph.nodes.keys()


def test_around_a_node(plan: Plan) -> None:
    text = dot(plan, View(around="allocation"))
    around = {"rate_control", "motors", "motor_loss", "commander", "navigation", "parameters"}
    assert boxes(text).keys() == {"allocation", *around}
    assert all("allocation" in (begin, end) for begin, end, _ in arrows(text))
    assert "peripheries=2" in boxes(text)["allocation"]
    text = dot(plan, View(around="allocation", wakes=True))
    assert boxes(text).keys() == {"rate_control", "commander", "allocation", "motors"}


def test_a_node_that_does_not_exist(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    graph = str(HOME / "graph" / "quad.yaml")
    assert cli.main(["graph", graph, "-o", str(tmp_path / "g.svg"), "--around", "motor"]) == 2
    assert "unknown node 'motor' of quad\nhint: did you mean 'motors'?" in capsys.readouterr().err


def test_light_and_dark(plan: Plan) -> None:
    assert 'bgcolor="white"' in dot(plan)
    assert 'bgcolor="#0d1117"' in dot(plan, View(dark=True))


def test_the_picture_of_the_readme_is_not_a_strip(tmp_path: Path) -> None:
    svg = tmp_path / "quad.svg"
    assert cli.main(["graph", str(HOME / "graph" / "quad.yaml"), "-o", str(svg)]) == 0
    found = re.search(r'width="(\d+)pt" height="(\d+)pt"', svg.read_text())
    assert found is not None
    assert int(found[1]) < 4 * int(found[2])
