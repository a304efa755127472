"""The facts of a flight, which `--json` prints and which are stored beside the log."""

from __future__ import annotations

import contextlib
import fcntl
import functools
import hashlib
import json
import signal
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator.diagnostics import UserError, shown_path
from stator.flight.crash import crash_of
from stator.flight.invariants import Setting, first_broken
from stator.flight.log import UnreadableFlight, open_log, read_truth_columns, topic
from stator.mission.route import walk
from stator.mission.vehicle import Vehicle

if TYPE_CHECKING:
    import argparse
    import subprocess
    from collections.abc import Callable, Iterator

    from pyulog import ULog

    from stator.flight.judge import Judgement, Problem
    from stator.mission.model import Mission


NOT_WHOLE = 1  # exit status of a flight program without a whole log, or without an end in order
RESTART = "an authorised restart request"


def keep(facts: dict[str, object]) -> None:
    """Writes the facts beside the log, for `./stator plot`."""
    log = Path(str(facts["log"]))
    report = json.dumps(facts, indent=2) + "\n"
    log.with_name(f"{log.name.removesuffix('.ulg')}.json").write_text(report, encoding="utf-8")


@contextlib.contextmanager
def alone(log: Path) -> Iterator[None]:
    """Raises `UserError` while another flight writes the log: each would report the other's."""
    is_new = not log.exists()
    if not log.is_file() and not (is_new and log.parent.is_dir()):
        yield  # such as /dev/null; what flies says what is wrong with it, if anything
        return
    with log.open("ab") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise UserError(
                f"error: another flight is writing '{shown_path(log)}'\n"
                "hint: wait for it, or name another log: -o LOG"
            ) from None
        try:
            yield
        except BaseException:
            if is_new and log.stat().st_size == 0:
                log.unlink()
            raise


def facts_of(
    finished: subprocess.CompletedProcess[str],
    log: Path,
    truth: Path,
    mission: Mission | None = None,
    *,
    cut: str,
    program: Path | None = None,
    judges: bool = True,
    is_guided: bool = False,
    in_wind: bool = False,
    is_recorded: bool = False,
    setting: Setting | None = None,
) -> dict[str, object]:
    """The facts that `--json` prints. None: unknown. `cut`: why a flight that reaches
    its time limit ends. `is_guided`: others decide what is flown, so only the invariants count."""
    facts: dict[str, object] = {
        "success": False,
        "reason": "",
        "problems": [],
        "broken_invariant": None,
        "crash": None,
        "log": str(log.resolve()),
        "log_sha256": _sha256(log) if log.is_file() else None,  # a pipe is read once
        "truth": str(truth.resolve()),
        "recording": str(log.resolve()) if is_recorded else None,
        "speed_vs_real_time": None,
        "lost_samples": None,
        "refused_publications": None,
        "refused_output": None,
        "activations": None,
        "preemptions": None,
        "unrecorded_activations": None,
        "missed_life_signs": None,
        "duration_s": None,
        "max_error_m": None,
        "rms_error_m": None,
        "hover_horizontal_rms_m": None,
        "hover_vertical_rms_m": None,
        "hover_s": None,
        "hover_height_m": None,
        "attitude_error_deg": None,
        "take_off_s": None,
        "touchdown_s": None,
        "touchdown_m_s": None,
    }
    if finished.returncode < 0:
        name = signal.Signals(-finished.returncode).name
        crash = None if program is None else crash_of(program, finished.stderr)
        if crash is None:
            facts["reason"] = f"the flight program ended with {name}: {finished.stderr.strip()}"
            return facts
        return facts | {"reason": crash.in_words(), "crash": crash.as_json()}
    run = json.loads(finished.stdout)
    facts["speed_vs_real_time"] = run["simulated_s"] / run["wall_s"]
    facts["duration_s"] = run["simulated_s"]
    facts |= {key: value for key, value in run.items() if key in facts}
    if not is_recorded:
        facts |= {"preemptions": None, "unrecorded_activations": None}
    if finished.returncode == NOT_WHOLE:
        return facts | {"reason": f"cannot judge the flight: {complaint_of(finished)}"}
    opened = functools.cache(functools.partial(open_log, log))  # reading takes most of the time
    knows_plan = judges and not is_guided
    facts |= _ending(opened, truth, run, mission, cut=cut, judges=knows_plan, in_wind=in_wind)
    if judges:
        facts |= _invariants(opened, truth, run, setting or Setting(), str(facts["reason"]))
    if facts["missed_life_signs"]:
        silent = f"{facts['missed_life_signs']} missed life signs: a task did not run in time"
        facts |= {"success": False, "reason": f"{silent}; {facts['reason']}"}
    return facts


def mission_facts(arguments: argparse.Namespace, mission: Mission | None) -> dict[str, object]:
    if mission is None:
        return {"mission": None}
    return {"mission": arguments.mission.stem, "mission_notes": list(mission.notes)}


def _ending(
    opened: Callable[[], ULog],
    truth: Path,
    run: dict[str, Any],
    mission: Mission | None,
    *,
    cut: str,
    judges: bool,
    in_wind: bool,
) -> dict[str, object]:
    """How it ended, and what the flight was like."""
    restarts = run["ended"] == "restart"
    if not judges:
        return {"success": True, "reason": f"ended by {RESTART}" if restarts else "ran to its end"}
    facts = _judged(opened, truth, run, mission, in_wind=in_wind)
    if not facts.get("success") and run.get("ended") == "time_limit":
        if mission is not None and walk(mission, Vehicle()).is_endless:
            cut += " (the mission itself has no end)"
        facts["reason"] = f"{cut}; {facts['reason']}"
    if restarts:
        facts["reason"] = f"ended by {RESTART} at {run['simulated_s']:.2f} s; {facts['reason']}"
    return facts


def complaint_of(finished: subprocess.CompletedProcess[str]) -> str:
    """What the program wrote on standard error, as parts of a reason."""
    return finished.stderr.strip().removeprefix("error: ").replace("\nerror: ", "; ")


def _judged(
    opened: Callable[[], ULog],
    truth: Path,
    run: dict[str, object],
    mission: Mission | None,
    *,
    in_wind: bool,
) -> dict[str, object]:
    from stator.flight.judge import CALM, IN_WIND, judge
    from stator.flight.log import read_flight, read_truth
    from stator.flight.mission import judge_mission, modes_of

    try:
        ulog = opened()
        flight = read_flight(ulog, read_truth(truth), run)
        if mission is not None:
            flown = judge_mission(ulog, flight, mission)
            return flown.facts | _verdict(flown.problems)
        limits = IN_WIND if in_wind else CALM
        judgement = judge(flight, limits)
    except UnreadableFlight as unreadable:
        return {"reason": str(unreadable)}
    modes = modes_of(topic(ulog, "vehicle_status"))
    return _judgement_facts(judgement) | {"limits": limits.as_json(), "modes": modes}


def _invariants(
    opened: Callable[[], ULog], truth: Path, run: dict[str, Any], setting: Setting, reason: str
) -> dict[str, object]:
    """What changes in the facts of a flight that broke an invariant."""
    try:
        columns = read_truth_columns(truth)
        broken = first_broken(opened(), columns, str(run["ended"]), setting)
    except UnreadableFlight:
        return {}  # the judgement says so
    if broken is None:
        return {}
    reason = f"broken invariant: {broken.in_words()}; {reason}"
    return {"success": False, "reason": reason, "broken_invariant": broken.as_json()}


def _verdict(problems: list[Problem]) -> dict[str, object]:
    texts = [problem.text for problem in problems]
    return {
        "success": not problems,
        "reason": "; ".join(texts) or "landed and disarmed, within all limits",
        "problems": [problem.as_json() for problem in problems],
    }


def _judgement_facts(judgement: Judgement) -> dict[str, object]:
    facts = _verdict(judgement.problems)
    if judgement.hover is not None:
        facts |= {
            "max_error_m": judgement.hover.max_error_m,
            "rms_error_m": judgement.hover.rms_error_m,
            "hover_horizontal_rms_m": judgement.hover.horizontal_rms_m,
            "hover_vertical_rms_m": judgement.hover.vertical_rms_m,
            "hover_s": judgement.hover.seconds,
            "hover_height_m": judgement.hover.height_m,
        }
    if judgement.tilt is not None:
        facts["attitude_error_deg"] = judgement.tilt.rms_deg
    return facts


def _sha256(log: Path) -> str:
    with log.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
