"""Shows the progress of a flight on a terminal, from the file of the true flight: it has 100 rows
for each second."""

from __future__ import annotations

import contextlib
import sys
import threading
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from rich.progress import Progress, TaskID

# boards/world/world/truth.hpp
ROWS_A_SECOND = 100
NUMBER_BYTES = 8
PERIOD_S = 0.1


@contextlib.contextmanager
def progress(text: str, truth: Path | None = None, most_s: float = 0.0) -> Iterator[None]:
    """`most_s`: the latest end of the flight."""
    if not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    console = Console(stderr=True)
    if truth is None:
        with console.status(text):
            yield
        return
    from rich.progress import BarColumn, Progress, TextColumn

    columns = (TextColumn("{task.description}"), BarColumn(), TextColumn("{task.fields[at]}"))
    with Progress(*columns, console=console, transient=True) as bar:
        task = bar.add_task(text, total=most_s, at="")
        ends = threading.Event()
        watcher = threading.Thread(target=_watch, args=(bar, task, truth, ends), daemon=True)
        watcher.start()
        try:
            yield
        finally:
            ends.set()
            watcher.join()


def _watch(bar: Progress, task: TaskID, truth: Path, ends: threading.Event) -> None:
    while not ends.wait(PERIOD_S):
        flown_s = seconds_flown(truth)
        bar.update(task, completed=flown_s, at=f"{flown_s:.0f} s flown")


def seconds_flown(truth: Path) -> float:
    try:
        with truth.open("rb") as file:
            head = file.readline()
        rows_bytes = truth.stat().st_size - len(head)
    except OSError:
        return 0.0
    row_bytes = NUMBER_BYTES * max(len(head.split()), 1)
    return rows_bytes / row_bytes / ROWS_A_SECOND
