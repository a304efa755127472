"""Composition: `include`, `with`, `prefix`; replacing key by key; lists whole; null removes."""

from __future__ import annotations

from pathlib import Path

import pytest

from stator.diagnostics import Failed
from stator.graph.check import check
from stator.graph.model import Graph

SOURCE = """
nodes:
  source:
    trigger: [{every: "${period}"}, {every: 1 s}]
    priority: 3
    outputs: {sample: raw}
  filter:
    trigger: {topic: raw}
    priority: 2
    inputs: {sample: raw}
    outputs: {smooth: smooth}
    params: {gain: 2, tilt: 10 deg}
topics: {raw: {log: none}}
chains: {way: {path: [source, filter], deadline: 1 ms}}
"""


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    bad = Path(__file__).parent / "bad"
    for name in ("apps", "messages", "drivers", "boards"):
        (tmp_path / name).symlink_to(bad / name)
    (tmp_path / "part.yaml").write_text(SOURCE)
    return tmp_path


def graph(folder: Path, text: str) -> Graph:
    (folder / "graph.yaml").write_text(text)
    return check(folder / "graph.yaml")[0]


def rules(folder: Path, text: str) -> list[str]:
    with pytest.raises(Failed) as failed:
        graph(folder, text)
    return [error.rule for error in failed.value.errors]


ONE = "board: bench\ninclude: [{file: part.yaml, with: {period: 10 ms}}]\n"


def test_what_a_file_writes_replaces_key_by_key(folder: Path) -> None:
    result = graph(folder, ONE + "nodes: {filter: {priority: 1, params: {gain: 3}}}\n")
    node = result.nodes["filter"]
    assert (node.priority, node.params["gain"]) == (1, 3)
    assert float(node.params["tilt"]) == pytest.approx(0.1745, abs=1e-4)


def test_lists_are_replaced_whole(folder: Path) -> None:
    assert len(graph(folder, ONE).nodes["source"].triggers) == 2
    result = graph(folder, ONE + "nodes: {source: {trigger: [{every: 5 ms}]}}\n")
    assert [trigger.period_us for trigger in result.nodes["source"].triggers] == [5_000]


@pytest.mark.parametrize("nothing", ["null", "~", ""])
def test_null_removes(folder: Path, nothing: str) -> None:
    result = graph(folder, ONE + f"nodes:\n  filter: {nothing}\nchains: {nothing}\n")
    assert list(result.nodes) == ["source"]
    assert result.chains == ()


def test_an_input_may_gain_an_age(folder: Path) -> None:
    text = ONE + "nodes: {filter: {inputs: {sample: {max_age: 5 ms}}}}\n"
    source = graph(folder, text).nodes["filter"].inputs["sample"]
    assert (source.topic, source.max_age_us) == ("raw", 5_000)


def test_a_prefix_renames_nodes_topics_chains_and_what_names_them(folder: Path) -> None:
    result = graph(folder, ONE.replace("}}]", "}, prefix: left_}]"))
    assert list(result.nodes) == ["left_source", "left_filter"]
    assert result.nodes["left_filter"].triggers[0].name == "left_raw"
    assert result.topics["left_raw"].config.log == "none"
    assert result.chains[0].path == ("left_source", "left_filter")


def test_a_prefix_leaves_topics_of_others_alone(folder: Path) -> None:
    (folder / "filter.yaml").write_text(
        "nodes:\n  filter:\n    trigger: {topic: raw}\n    inputs: {sample: raw}\n"
        "    outputs: {smooth: latest}\n"
        "  sink:\n    trigger: {every: 1 s}\n"
        "    inputs: {sample: {topic: latest, read: latest}}\n"
        "modes: {initial: filter, sets: {filter: [filter], rest: []}}\n"
    )
    result = graph(
        folder,
        "board: bench\ninclude: [{file: filter.yaml, prefix: my_}]\n"
        "nodes:\n  source: {trigger: {every: 1 s}, outputs: {sample: raw}}\n"
        "  selector: {trigger: {every: 1 s}, outputs: {mode: mode}}\n",
    )
    assert result.nodes["my_filter"].inputs["sample"].topic == "raw"
    assert result.nodes["my_sink"].inputs["sample"].topic == "my_latest"
    assert result.modes is not None
    assert result.modes.sets == {"filter": ("my_filter",), "rest": ()}


TWO = "board: bench\ninclude: [{file: part.yaml, with: {period: %s}}, {file: other.yaml}]\n"


def test_two_includes_may_agree(folder: Path) -> None:
    (folder / "other.yaml").write_text("nodes: {source: {priority: 3, deadline: 1 ms}}\n")
    assert graph(folder, TWO % "10 ms").nodes["source"].deadline_us == 1_000


def test_where_two_includes_differ_the_including_file_decides(folder: Path) -> None:
    (folder / "other.yaml").write_text("nodes: {source: {priority: 4}}\n")
    assert rules(folder, TWO % "10 ms") == ["include-conflict"]
    decided = TWO % "10 ms" + "nodes: {source: {priority: 5}}\n"
    assert graph(folder, decided).nodes["source"].priority == 5
    removed = TWO % "10 ms" + "nodes: {source: {priority: null}, filter: {priority: null}}\n"
    assert graph(folder, removed).nodes["source"].priority is None


def test_a_variable_goes_through_two_files(folder: Path) -> None:
    (folder / "middle.yaml").write_text('include: [{file: part.yaml, with: {period: "${rate}"}}]\n')
    text = "board: bench\ninclude: [{file: middle.yaml, with: {rate: 200 Hz}}]\n"
    assert graph(folder, text).nodes["source"].triggers[0].period_us == 5_000


def test_apps_beside_the_graph_come_first(folder: Path) -> None:
    (folder / "apps").unlink()
    own = folder / "apps" / "rate_control"
    own.mkdir(parents=True)
    (own / "rate_control.yaml").write_text(
        "doc: Another.\noutputs: {sample: {message: Sample, doc: It.}}\n"
    )
    result = graph(folder, "board: bench\nnodes: {rate_control: {trigger: {every: 1 s}}}\n")
    assert result.nodes["rate_control"].interface.file.is_relative_to(folder)
