"""Where logs lie, and that no flight overwrites the log of an earlier one without a word."""

from __future__ import annotations

import contextlib
import fcntl
import filecmp
import hashlib
import json
import re
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.build.cmake import short_name
from stator.diagnostics import shown_path

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator

    from stator.flight.params import Replaced

MAX_WORDS = 80  # characters
# Files that lie beside a log and belong to it; records that survive a restart belong to no log.
BESIDE = r"(\.\d+|\.topics)?\.(ulg|truth|json|png)"


def default_log(graph: Path, seed: int, kind: str = "") -> Path:
    folder = HOME / "build" / "flights"
    folder.mkdir(parents=True, exist_ok=True)
    return folder / f"{short_name(graph.resolve())}-seed{seed}{kind}.ulg"


def flights_of(graph: Path) -> list[Path]:
    """The default logs of a graph, the newest first."""
    usual = default_log(graph, 0)
    name = usual.name.removesuffix("0.ulg")
    logs = usual.parent.glob(f"{_escaped(name)}*.ulg")
    return sorted(logs, key=lambda log: log.stat().st_mtime, reverse=True)


def log_of(arguments: argparse.Namespace, params: list[Replaced], kind: str = "") -> Path:
    """The given log, or one whose name says how the flight differs from a plain one."""
    if arguments.output is not None:
        given: Path = arguments.output
        return given
    mission = f"-{short_name(arguments.mission.resolve())}" if arguments.mission else ""
    return default_log(
        arguments.graph, arguments.seed, f"{mission}{_words(arguments, params)}{kind}"
    )


def _words(arguments: argparse.Namespace, params: list[Replaced]) -> str:
    words = [f"wind{arguments.wind:g}"] if arguments.wind else []
    words += [f"from{arguments.wind_from:g}"] if arguments.wind and arguments.wind_from else []
    words += [f"gusts_{arguments.gusts}"] if arguments.gusts != "none" else []
    words += [arguments.launch] if arguments.launch != "ground" else []
    words += ["vary"] if arguments.vary else []
    words += [f"times_{arguments.times}"] if getattr(arguments, "times", "zero") != "zero" else []
    words += ["hil"] if getattr(arguments, "hil", None) else []
    words += [f"pilot_{arguments.pilot.stem}"] if arguments.pilot else []
    words += [*arguments.fail, *(row.option for row in params)]
    text = "".join(f"-{word}" for word in words)
    if len(text) > MAX_WORDS or not re.fullmatch(r"[\w.=@+-]*", text, re.ASCII):
        return f"-{hashlib.sha256(text.encode()).hexdigest()[:8]}"
    return text


@contextlib.contextmanager
def keeping(log: Path, arguments: argparse.Namespace) -> Iterator[list[Path]]:
    """Around a flight that writes a default log: the log of an earlier flight gets a number, and is
    in the list afterwards, unless both flights are the same byte for byte. A log that the user
    named is overwritten, as with any `-o`."""
    kept: list[Path] = []
    moved = _set_aside(log) if arguments.output is None else {}
    least_bytes = 0  # of a flight that ended, and perhaps crashed before the first block
    try:
        yield kept
    except BaseException:
        least_bytes = 1
        raise
    finally:
        if moved:
            kept += _settle(log, moved, least_bytes)


def kept_facts(kept: list[Path]) -> dict[str, object]:
    return {"kept_log": str(kept[0].resolve()) if kept else None}


def kept_rows(facts: dict[str, object]) -> list[tuple[str, str]]:
    kept = facts.get("kept_log")
    return [] if kept is None else [("kept", f"the earlier log is {shown_path(Path(str(kept)))}")]


def _set_aside(log: Path) -> dict[Path, Path]:
    """Gives what lies there the next number; new name -> name before."""
    if not log.is_file() or log.stat().st_size == 0:
        return {}
    with log.open("rb") as opened:
        try:
            fcntl.flock(opened, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return {}  # of a flight that is not over
    base = log.name.removesuffix(".ulg")
    belongs = re.compile(re.escape(base) + BESIDE)
    files = [file for file in log.parent.iterdir() if belongs.fullmatch(file.name)]
    number = next(n for n in count(1) if not list(log.parent.glob(f"{_escaped(base)}-{n}.*")))
    moved = {}
    for file in files:
        aside = file.with_name(f"{base}-{number}{file.name.removeprefix(base)}")
        moved[file.rename(aside)] = file
    return moved


def _escaped(text: str) -> str:
    return re.sub(r"([*?[])", r"[\1]", text)


def _settle(log: Path, moved: dict[Path, Path], least_bytes: int) -> list[Path]:
    """Puts the earlier files back if the new flight has no log, or if it is the same one."""
    aside = next(file for file, before in moved.items() if before == log)
    is_new = log.is_file() and log.stat().st_size >= least_bytes
    same = is_new and all(
        not before.is_file() or filecmp.cmp(file, before, shallow=False)
        for file, before in moved.items()
        if before.suffix in (".ulg", ".truth")
    )
    if is_new and not same:
        _name_again(aside, log)
        return [aside]
    for file, before in moved.items():
        if same and before.is_file():
            file.unlink()
        else:
            file.replace(before)
    return []


def _name_again(aside: Path, log: Path) -> None:
    """The report beside the log names it."""
    base = log.name.removesuffix(".ulg")
    report = aside.with_name(f"{aside.name.removesuffix('.ulg')}.json")
    with contextlib.suppress(OSError, ValueError):
        facts = json.loads(report.read_bytes())
        for key in ("log", "truth", "recording"):
            if facts.get(key) is not None:
                name = Path(facts[key]).name.removeprefix(base)
                facts[key] = str(aside.with_name(aside.name.removesuffix(".ulg") + name).resolve())
        report.write_text(json.dumps(facts, indent=2) + "\n", encoding="utf-8")
