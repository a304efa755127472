"""CSV: a folder with a table for each topic."""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pathlib import Path

    from stator.convert.topics import Topic


def write_csv(topics: list[Topic], output: Path) -> None:
    """A row for each sample. Numbers have as many digits as it takes to read the same number."""
    output.mkdir(parents=True, exist_ok=True)
    for topic in topics:
        names, columns = [], []
        for field in topic.fields:
            for i, column in enumerate(field.columns):
                names.append(f"{field.name}[{i}]" if field.is_array else field.name)
                columns.append(column.astype("u1" if column.dtype == bool else column.dtype))
        with (output / f"{topic.name}.csv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(names)
            writer.writerows(zip(*(column.astype(str) for column in columns), strict=True))
