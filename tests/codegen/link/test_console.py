"""What a console shows of what the vehicle prints."""

import pytest

from stator.live.console import _Echo

PRINTED = "> top\nlev task\n12  rate_control\n> \n> help\nhelp\n> "


@pytest.mark.parametrize("piece", [1, 2, 3, 7, 70])
def test_a_terminal_does_not_show_twice_what_was_typed(piece: int) -> None:
    echo = _Echo(is_terminal=True)
    echo.typed = ["top\n", "\n", "help\n"]
    pieces = [PRINTED[i : i + piece] for i in range(0, len(PRINTED), piece)]
    shown = "".join(echo.shown(text) for text in pieces)
    assert shown == "> lev task\n12  rate_control\n> > help\n> "
    assert echo.prompts == 4


def test_a_pipe_shows_all() -> None:
    echo = _Echo(is_terminal=False)
    echo.typed = ["top\n"]
    assert echo.shown(PRINTED) == PRINTED
    assert echo.prompts == 4


def test_a_prompt_is_one_at_the_begin_of_a_line() -> None:
    echo = _Echo(is_terminal=False)
    echo.shown("> a > b\n> ")
    assert echo.prompts == 2
