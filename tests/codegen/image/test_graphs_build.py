"""Each graph of graph/ builds for the board that it names: what people would fly."""

from __future__ import annotations

import pytest
from tests.emulation.firmware_tools import needs_toolchain

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import build
from stator.graph.check import check

# On hardware their deadlines are not proven: who lists no distance of its bus' events, and who does
# too much in one activation.
UNPROVEN = frozenset(("hexarotor", "octorotor", "plane", "quad_can", "quad_outdoor"))
# Those that differ from another one by their vehicle and fewer nodes build as it does; and one that
# the flights build for another board.
LIKE_OTHERS = ("hexarotor", "octorotor", "plane")
# Several machines fly in virtual time only.
ONE_MACHINE = [
    path.stem for path in sorted((HOME / "graph").glob("*.yaml")) if not check(path)[0].machines
]


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.long] if name in LIKE_OTHERS else [])
        for name in ONE_MACHINE
    ],
)
def test_a_graph_builds_for_its_own_board(name: str) -> None:
    graph = HOME / "graph" / f"{name}.yaml"
    if check(graph)[0].board.executor == "cortex_m":
        needs_toolchain()
        options = ["--unproven"] if name in UNPROVEN else []
        assert cli.main(["build", str(graph), *options]) == 0
    else:
        assert build(graph, None).is_file()


@pytest.mark.parametrize("name", sorted(UNPROVEN))
def test_a_graph_that_is_not_proven_is_refused_before_anything_is_built(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    graph = HOME / "graph" / f"{name}.yaml"
    assert cli.main(["build", str(graph)]) == 2
    error = capsys.readouterr().err
    assert f"error: the deadlines of {name} on fmu_v2 are not proven\n" in error
    assert "--unproven builds the image all the same" in error
