"""CSV and Parquet: a folder with a table for each topic, with a row for each sample."""

from __future__ import annotations

import csv
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from pathlib import Path

    from numpy.typing import NDArray

    from stator.convert.topics import Topic


def columns_of(topic: Topic) -> dict[str, NDArray[Any]]:
    """One for each number, named as pyulog names it."""
    return {
        f"{field.name}[{i}]" if field.is_array else field.name: column
        for field in topic.fields
        for i, column in enumerate(field.columns)
    }


def write_csv(topics: list[Topic], output: Path) -> None:
    """Numbers have as many digits as it takes to read the same number."""
    output.mkdir(parents=True, exist_ok=True)
    for topic in topics:
        columns = columns_of(topic)
        plain = [c.astype("u1" if c.dtype == bool else c.dtype) for c in columns.values()]
        with (output / f"{topic.name}.csv").open("w", encoding="utf-8", newline="") as file:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(columns)
            writer.writerows(zip(*(column.astype(str) for column in plain), strict=True))


def write_parquet(topics: list[Topic], output: Path) -> None:
    """Columns have the types of the fields."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    output.mkdir(parents=True, exist_ok=True)
    for topic in topics:
        table = pa.table(columns_of(topic))
        pq.write_table(table, output / f"{topic.name}.parquet", compression="zstd")
