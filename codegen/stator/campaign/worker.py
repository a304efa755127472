"""What a worker does: it gets the kit of a campaign once, and flies one row at a time.

A result depends on the kit and the row only. What depends on the machine (a full disk, a signal
from outside) is an error of the worker, and the flight is flown again elsewhere.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import pickle
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from distributed.diagnostics.plugin import WorkerPlugin

from stator import HOME
from stator.campaign.columns import RESULTS
from stator.flight.arguments import (
    add_flight_arguments,
    add_times_argument,
    complete,
    cut_of,
    flight_options,
    is_judged,
    is_windy,
    memory_of,
    place_options,
    setting_of,
)
from stator.flight.crash import crash_of
from stator.flight.facts import NOT_WHOLE, facts_of
from stator.flight.params import add_param_argument
from stator.processes import run

if TYPE_CHECKING:
    from stator.campaign.definition import Limit
    from stator.campaign.draw import Row

# Signals that come from outside: the flight has no result.
OUTSIDE = (signal.SIGKILL, signal.SIGTERM, signal.SIGINT, signal.SIGHUP)
# Rooms that have an influence on a result.
JUDGING = ("language", "graph", "plan", "emit", "mission", "params", "flight", "campaign")


class NotFlown(Exception):
    """The worker could not fly it."""


@dataclass(frozen=True)
class Kit:
    """All that the flights of a campaign have in common. `sources`: of the Stator that judges."""

    program: bytes
    plan: bytes  # pickled
    files: dict[str, bytes]  # missions and scripts, by name
    by: str
    limits: tuple[Limit, ...]
    sources: str

    @property
    def sha256(self) -> str:
        """Of all that has an influence on a result."""
        found = hashlib.sha256(self.program)
        for name, content in sorted(self.files.items()):
            found.update(f"\n{name} {len(content)}\n".encode() + content)
        found.update(f"{self.by} {self.limits} {self.sources}".encode())
        return found.hexdigest()


@lru_cache(maxsize=1)
def sources_sha256() -> str:
    """Of the Python code that flies and judges: a worker with another one could judge otherwise."""
    found = hashlib.sha256()
    folder = HOME / "codegen" / "stator"
    for file in sorted(file for room in JUDGING for file in (folder / room).rglob("*.py")):
        found.update(str(file.relative_to(HOME)).encode() + b"\n" + file.read_bytes())
    return found.hexdigest()


class Hangar:
    """A kit that is unpacked in a folder of this process."""

    def __init__(self, kit: Kit, folder: Path) -> None:
        self.kit, self.folder = kit, folder
        self.program = folder / "graph_program"
        self.program.write_bytes(kit.program)
        self.program.chmod(0o755)
        self.files = {}
        for i, (name, content) in enumerate(kit.files.items()):
            place = folder / str(i) / Path(name).name
            place.parent.mkdir()
            place.write_bytes(content)
            self.files[name] = place
        self.plan = pickle.loads(kit.plan)
        self.parser = argparse.ArgumentParser()
        add_flight_arguments(self.parser, board=self.plan.board.name, what="")
        add_param_argument(self.parser)
        add_times_argument(self.parser)

    def fly(self, row: Row) -> dict[str, Any]:
        """The columns of the results."""
        with tempfile.TemporaryDirectory(dir=self.folder) as folder:
            facts = self._facts(row, Path(folder))
        for limit in self.kit.limits:
            value = facts.get(limit.column)
            if (text := _broken(limit, value)) and not facts["crash"]:
                before = "" if facts["success"] else f"; {facts['reason']}"
                facts |= {"success": False, "reason": f"{text}{before}"}
        return row.columns | {name: facts.get(name) for name in RESULTS}

    def _facts(self, row: Row, folder: Path) -> dict[str, Any]:
        words = [*row.words, "--no-record"]
        for option, name in row.files.items():
            words += [f"--{option}", str(self.files[name])]
        arguments = self.parser.parse_args([str(self.plan.graph.file), *words])
        arguments.plan = self.plan
        mission = complete(arguments)
        log, truth = folder / "flight.ulg", folder / "flight.truth"
        command = [str(self.program), "--log", str(log), "--truth", str(truth)]
        command += flight_options(arguments)
        with memory_of(mission) as memory:
            if memory is not None:
                command += ["--mission", str(memory), *place_options(mission)]
            finished = run(command, capture_output=True, check=False, errors="replace")
        if finished.returncode > NOT_WHOLE or -finished.returncode in OUTSIDE:
            raise NotFlown(f"flight {row.flight}: {finished.stderr.strip()}")
        if finished.returncode < 0:
            return self._crash(finished)
        if finished.returncode == NOT_WHOLE:
            raise NotFlown(f"flight {row.flight}: {finished.stderr.strip()}")
        facts = facts_of(
            finished,
            log,
            truth,
            mission,
            cut=cut_of(arguments),
            judges=is_judged(arguments),
            in_wind=is_windy(arguments),
            setting=setting_of(arguments, mission),
        )
        broken = facts["broken_invariant"]
        assert broken is None or isinstance(broken, dict)
        facts["broken_invariant"] = None if broken is None else broken["name"]
        if self.kit.by == "invariants" and broken is None and not facts["missed_life_signs"]:
            facts |= {"success": True, "reason": "kept all invariants"}
        return facts

    def _crash(self, finished: subprocess.CompletedProcess[str]) -> dict[str, Any]:
        """Without the line of the code, which is found where the program was built."""
        name = signal.Signals(-finished.returncode).name
        crash = crash_of(self.program, finished.stderr)
        text = name if crash is None else replace(crash, file=None, line=None).in_words()
        return {"success": False, "reason": f"the program ended: {text}", "crash": text}


def _broken(limit: Limit, value: Any) -> str:
    if value is None:
        return f"no {limit.column}, which has a limit"
    if limit.most is not None and value > limit.most:
        return f"{limit.column} {value:.6g} (at most {limit.most:g})"
    if limit.least is not None and value < limit.least:
        return f"{limit.column} {value:.6g} (at least {limit.least:g})"
    return ""


class Delivery(WorkerPlugin):
    """Brings the kit to each worker, those that come later included."""

    def __init__(self, kit: Kit) -> None:
        self.kit = kit
        self.name = f"stator-{kit.sha256}"

    def setup(self, worker: Any) -> None:
        if sources_sha256() != self.kit.sources:
            raise RuntimeError(
                f"error: the worker at {worker.address} has another version of Stator\n"
                f"hint: install the same one there; its Python is {sys.executable}"
            )
        folder = tempfile.TemporaryDirectory(dir=worker.local_directory)
        _unpacked[self.kit.sha256] = (Hangar(self.kit, Path(folder.name)), folder)

    def teardown(self, worker: Any) -> None:
        with contextlib.suppress(KeyError, OSError):
            _unpacked.pop(self.kit.sha256)[1].cleanup()


_unpacked: dict[str, tuple[Hangar, tempfile.TemporaryDirectory[str]]] = {}


def fly_row(sha256: str, row: Row) -> str:
    """The result as JSON: floats keep all their digits."""
    return json.dumps(_unpacked[sha256][0].fly(row))
