"""A name has one definition in the whole program: gcc checks it as one unit (STATOR_ODR). Images
for bare metal are linked in this way anyway, with the same error."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from stator import HOME
from stator.build.cmake import NO_WALLS, build, configure
from stator.diagnostics import BuildFailed

ODR = {"STATOR_ODR": "ON"}


def host_board(graph: Path) -> str | None:
    """None: the graph's own, which is not bare metal."""
    return "sitl" if "board: fmu_v2" in graph.read_text().splitlines() else None


# Between them all apps and all drivers of hosts.
HOSTS = [("graph/quad_outdoor.yaml", "sitl"), ("graph/quad_can.yaml", "linux")]
FILES = sorted([*(HOME / "graph").glob("*.yaml"), *(HOME / "graph" / "examples").glob("*.yaml")])
GRAPHS = [(str(file.relative_to(HOME)), host_board(file)) for file in FILES]
# Nodes of tests, on boards of tests.
OTHERS = [
    ("tests/codegen/replay/graph/mixed.yaml", "sitl"),
    ("tests/conformance/graphs/conformance.yaml", "virtual"),
    ("tests/conformance/graphs/conformance.yaml", "threads"),
]


@pytest.mark.parametrize(("graph", "board"), HOSTS)
def test_a_graph_has_one_definition_of_each_name(graph: str, board: str) -> None:
    assert build(HOME / graph, board, ODR).is_file()


@pytest.mark.long
@pytest.mark.parametrize(
    ("graph", "board"), [pair for pair in [*GRAPHS, *OTHERS] if pair not in HOSTS]
)
def test_another_graph_has_one_definition_of_each_name(graph: str, board: str | None) -> None:
    assert build(HOME / graph, board, ODR | NO_WALLS).is_file()


@pytest.mark.long
def test_the_programs_of_tests_have_one_definition_of_each_name() -> None:
    """With the graphs that only CMake knows."""
    configure(HOME / "build" / "host-odr", ["-DSTATOR_ODR=ON"], ["all"])


@pytest.mark.long
def test_two_definitions_do_not_link(tmp_path: Path) -> None:
    """Two apps with a struct of one name, other members, and no wall."""
    examples = Path(shutil.copytree(HOME / "graph" / "examples", tmp_path / "two_ways"))
    for app, count in (("adder", 1), ("counter", 2)):
        header = examples / "apps" / app / f"{app}.hpp"
        text = header.read_text()
        helper = f"namespace stator {{\nstruct Helper {{ int values[{count}]{{}}; }};\n}}\n"
        begin = text.index("namespace stator::apps")
        text = text[:begin] + helper + text[begin:]
        end = text.rindex("};")
        header.write_text(text[:end] + "    Helper helper_;\n" + text[end:])
    with pytest.raises(BuildFailed, match="One Definition Rule"):
        build(examples / "topic.yaml", None, ODR | NO_WALLS)
