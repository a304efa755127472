"""What `./stator build` says of a board that has no code."""

import pytest

from stator import cli
from stator.library import HOME


def test_a_board_without_code_is_refused_before_anything_is_built(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(HOME)
    assert cli.main(["build", "graph/quad.yaml", "--board", "fmu_v2"]) != 0
    assert capsys.readouterr().err == (
        "error: board 'fmu_v2' has no code yet, only its description\n"
        "hint: build for another one, such as qemu_f405, or write its board.hpp in boards/fmu_v2\n"
    )
    assert not (HOME / "build" / "quad-fmu_v2").exists()
