"""The formats that a log can be written in."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from stator.convert.layouts import write_foxglove, write_plotjuggler
from stator.convert.mcap import write_mcap
from stator.convert.tables import write_csv, write_parquet

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from stator.convert.topics import Topic


class Format(NamedTuple):
    """`suffix` takes the place of `.ulg`; what is written is a file or a folder."""

    suffix: str
    write: Callable[[list[Topic], Path], None]


FORMATS = {
    "mcap": Format(".mcap", write_mcap),
    "csv": Format("-csv", write_csv),
    "parquet": Format("-parquet", write_parquet),
    "plotjuggler": Format("-plotjuggler.xml", write_plotjuggler),
    "foxglove": Format("-foxglove.json", write_foxglove),
}
