"""The file of `./stator run` in which records outlive a run: where it is, what became of it."""

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
            f"error: {arguments.graph.stem} has no device {DEVICE}\nhint: leave out --nonvolatile"
        )
    return None


def told_of(file: Path | None, told: dict[str, Any] | None) -> dict[str, Any] | None:
    """What `--json` says of it; none of a graph without the device, or of a program that died."""
    if file is None or told is None:
        return None
    return {"file": str(file.resolve())} | told


def nonvolatile_rows(facts: dict[str, Any]) -> list[tuple[str, str]]:
    """For people: what is kept, and what is not as it should be."""
    memory = facts.get("nonvolatile")
    if memory is None:
        return []
    file = shown_path(Path(memory["file"]))
    if memory["state"] != "loaded":
        return [("records", f"{memory['state']}: nothing is kept in {file}")]
    texts = [f"{memory['records']} of at most {memory['most_records']}, in {file}"]
    if memory["mended"]:
        texts.append(f"mended, as one copy of two was bad: {memory['mended']}; none is gone")
    if memory["damaged"]:
        texts.append(
            f"damaged; gone: {memory['damaged']}; what they said is as the graph says, or asked "
            "for anew"
        )
    not_kept = memory["refused"] + memory["lost"]
    if not_kept:
        texts.append(
            f"not kept: {not_kept}; there was no room, the file cannot be written, or they came "
            "too fast"
        )
    return [("records", text) for text in texts]
