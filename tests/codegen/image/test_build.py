"""What `./stator build` says of a board that has no code."""

from pathlib import Path

import pytest

from stator import HOME
from stator import __main__ as cli


def test_a_board_without_code_is_refused_before_anything_is_built(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    board = tmp_path / "boards" / "described" / "board.yaml"
    board.parent.mkdir(parents=True)
    chip = tmp_path / "boards" / "stm32f4" / "stm32f427.yaml"
    chip.parent.mkdir()
    chip.write_text((HOME / "boards" / "stm32f4" / "stm32f427.yaml").read_text())
    board.write_text("executor: cortex_m\nchip: stm32f4/stm32f427\ndevices: {}\n")
    graph = tmp_path / "alone.yaml"
    graph.write_text("board: described\nnodes: {logger: {trigger: {every: 5 ms}}}\n")
    assert cli.main(["build", str(graph)]) != 0
    errors = capsys.readouterr().err
    assert errors.startswith(
        "error: missing file 'board.cpp' of board 'described'\nhint: write it in "
    )
    assert not list((HOME / "build").glob("alone-*"))
