"""The file that keeps records after a run: its path, its form, and its state."""

from __future__ import annotations

import contextlib
import fcntl
import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator.arguments import path
from stator.diagnostics import UserError, shown_path
from stator.pipeline import make_plan

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator

DEVICE = "nonvolatile0"
# boards/linux/nonvolatile.cpp, drivers/nonvolatile
HEAD = b"stator nonvolatile records 1\n"
HEAD_BYTES = 4096
FILE_BYTES = HEAD_BYTES + 16384


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


def add_nonvolatile_argument(parser: argparse._ActionsContainer, default: str) -> None:
    parser.add_argument(
        "--nonvolatile",
        type=path,
        metavar="FILE",
        help="file of the records that survive a restart, for example parameters and the ids of "
        f"parts on a CAN bus (default: {default}); a new file is empty",
    )


@contextlib.contextmanager
def opened(file: Path) -> Iterator[Path]:
    """The file, whole, as `./stator run` has it too; nobody else uses it meanwhile. Raises
    `UserError`."""
    with contextlib.ExitStack() as stack:
        try:
            descriptor = os.open(file, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
            stack.callback(os.close, descriptor)
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise _refused(
                file, "another run uses it", "end that run, or use another file"
            ) from None
        except OSError as problem:
            reason = os.strerror(problem.errno or 0)
            raise _refused(file, reason, "use a file that you may write") from None
        has_head = os.pread(descriptor, len(HEAD), 0) == HEAD
        if not has_head and os.fstat(descriptor).st_size not in (0, FILE_BYTES):
            raise _refused(
                file,
                "expected a file of records, found another file",
                "use another file, or move this one away to begin with an empty one",
            )
        os.truncate(descriptor, FILE_BYTES)
        os.pwrite(descriptor, HEAD, 0)
        yield file


def _refused(file: Path, why: str, hint: str) -> UserError:
    return UserError(f"error: --nonvolatile '{file}': {why}\nhint: {hint}")


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
