"""Where calls through pointers go. Generated code and the runtime make few, and each is listed here
with the functions that it can reach; any other is refused, as the stack would have no bound."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stator.image.calls import short

if TYPE_CHECKING:
    from collections.abc import Sequence

    from stator.image.calls import Frame
    from stator.image.functions import Code


@dataclass(frozen=True)
class Row:
    """A call by `function` in `file` reaches functions with these names. All are patterns."""

    file: str
    function: str
    targets: str


# What a board hands to its drivers and to the link.
OF_BOARD = r"stator::(board|stm32f4)::(?!\w+_interrupt$).*|stator::restart"
ROWS = (
    # Topics that several levels publish have these in a table of their own.
    Row(
        r"runtime/core/stator/one_core_topic\.hpp$",
        r".*",
        r"stator::topics::\w+_parts::(loan|commit|is_due)_in_section",
    ),
    Row(r"/generated/\w+/modes\.cpp$", r".*", r"stator::tasks::\w+::(enable|disable)"),
    # Constructors of static objects, then the graph.
    Row(r"runtime/cortex_m/startup\.cpp$", r"(stator::)?construct", r"_(GLOBAL_)?_?sub_I_.*"),
    Row(r"runtime/cortex_m/startup\.cpp$", r"(stator::)?run", r"stator::start_graph"),
    Row(r"runtime/link/stator/link\.hpp$", r".*", rf"{OF_BOARD}|stator::answer"),
    Row(r"/drivers/\w+/\w+/\w+\.(cpp|hpp)$", r".*", OF_BOARD),
)


def targets_of(code: Code, frames: Sequence[Frame]) -> list[int] | None:
    """The functions that a call can reach: of the listed ones those whose address is somewhere in
    the image. None: it is not listed. `frames`: its place in the source, innermost first."""
    for frame in frames:
        for row in ROWS:
            if re.search(row.file, frame.file) and re.fullmatch(row.function, frame.function):
                return [
                    at
                    for at in code.addressed
                    if re.fullmatch(row.targets, short(code.functions[at].name))
                ]
    return None
