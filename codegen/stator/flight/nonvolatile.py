"""The file of `./stator run` that keeps records after a run: its path and its state."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator.diagnostics import UserError, shown_path
from stator.pipeline import make_plan

if TYPE_CHECKING:
    import argparse

DEVICE = "nonvolatile0"


def nonvolatile_of(arguments: argparse.Namespace, log: Path) -> Path | None:
    """The file, if the graph has the device. Raises `UserError`."""
    tasks = make_plan(str(arguments.graph), arguments.board).tasks
    if any(task.node.device == DEVICE for task in tasks):
        beside = log.with_name(f"{log.name.removesuffix('.ulg')}.records")
        return Path(arguments.nonvolatile or beside)
    if arguments.nonvolatile is not None:
        raise UserError(
            f"error: unknown device {DEVICE} of {arguments.graph.stem}\nhint: remove --nonvolatile"
        )
    return None


def nonvolatile_facts(file: Path | None, state: dict[str, Any] | None) -> dict[str, Any] | None:
    """The facts for `--json`; None for a graph without the device, or a program that crashed."""
    if file is None or state is None:
        return None
    return {"file": str(file.resolve())} | state


def nonvolatile_rows(facts: dict[str, Any]) -> list[tuple[str, str]]:
    """The rows of a report: what is kept, and what is damaged or lost."""
    memory = facts.get("nonvolatile")
    if memory is None:
        return []
    file = shown_path(Path(memory["file"]))
    if memory["state"] != "loaded":
        return [("records", f"{memory['state']}: no record is kept in {file}")]
    texts = [f"{memory['records']} of at most {memory['most_records']}, in {file}"]
    if memory["mended"]:
        texts.append(f"repaired (one of two copies was damaged): {memory['mended']}; none is lost")
    if memory["damaged"]:
        texts.append(
            f"damaged and lost: {memory['damaged']}; the graph's defaults replace them, or they "
            "are requested again"
        )
    not_kept = memory["refused"] + memory["lost"]
    if not_kept:
        texts.append(
            f"not kept: {not_kept}; the file is full or cannot be written, or they came too fast"
        )
    return [("records", text) for text in texts]
