"""Each graph of graph/ builds for the board that it names: what people would fly."""

from __future__ import annotations

import pytest
from tests.emulation.firmware_tools import needs_toolchain

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import build
from stator.graph.check import check


@pytest.mark.parametrize("name", sorted(path.stem for path in (HOME / "graph").glob("*.yaml")))
def test_a_graph_builds_for_its_own_board(name: str) -> None:
    graph = HOME / "graph" / f"{name}.yaml"
    if check(graph)[0].board.executor == "cortex_m":
        needs_toolchain()
        assert cli.main(["build", str(graph)]) == 0
    else:
        assert build(graph, None).is_file()
