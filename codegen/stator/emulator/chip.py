"""Runs the image of a Pixhawk on the emulated chip: the bytes that an upload writes."""

from __future__ import annotations

import json
import subprocess
import tempfile
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stator.diagnostics import UserError
from stator.emulator.machine import MACHINE
from stator.emulator.qemu import END_S, SHIFT
from stator.flight.restarts import Endings
from stator.image.tools import addresses
from stator.plan.text import unbound_devices
from stator.processes import start

if TYPE_CHECKING:
    import argparse
    from collections.abc import Mapping, Sequence

    from stator.emulator.qemu import Emulator
    from stator.plan.plan import Plan

BOARD = "fmu_v2"  # what boards/fmu_v2/plant has around the chip
CLOCK_HZ = 168_000_000  # of the core, which counts its cycles
# What a flight on this chip cannot have yet, and why.
REFUSED = {
    "link": "its link has no driver",
    "mavlink": "the simulated world has no end for its serial lines",
    "nonvolatile": "its memory of records has no driver",
    "pilot": "its receiver has no driver",
    "sleep": "the image that is flashed does not sleep",
    "speed": "it is not paced",
}
IMAGE_AT = 0x08004000  # the bootloader, which starts the image there, has the first 16 KB
WAIT_S = 60.0  # until the model listens


def run_image(
    emulator: Emulator,
    server: Path,
    image: bytes,
    seconds: float,
    lines: Mapping[str, Path] | None = None,
) -> dict[str, Any]:
    """Runs the image for emulated `seconds`, with the vehicle on the ground if it does not take
    off. `lines`: for serial lines by their name in the manual, the file for what they send. Returns
    what was counted. Raises `UserError` with the rule of the chip that the firmware broke."""
    words = [w for line, file in (lines or {}).items() for w in ("--line", line, str(file))]
    finished = fly_image(emulator, [str(server), *words, "--duration", f"{seconds:.6f}"], image)
    if finished.returncode != 0:
        raise UserError(finished.stderr)
    found: dict[str, Any] = json.loads(finished.stdout)
    return found


def fly_image(
    emulator: Emulator, pixhawk: Sequence[str], image: bytes, endings: Endings | None = None
) -> subprocess.CompletedProcess[str]:
    """Runs both sides to their end. `pixhawk`: the program around the chip, with its options.
    `endings`: of the signals that end the flight in order. Returns the output of that program, and
    as errors, after a failure, what both said."""
    pipe = subprocess.PIPE
    if endings is None:
        endings = Endings()  # which hears none
    with tempfile.TemporaryDirectory(prefix="stator-") as name:
        socket, file = Path(name) / "model", Path(name) / "image.bin"
        file.write_bytes(image)
        program, *options = pixhawk
        model = endings.start([program, str(socket), *options], restore_signals=False)
        try:
            _await(socket, model)
            command = machine_command(emulator, socket, file)
            with start(command, stdout=pipe, stderr=subprocess.STDOUT, process_group=0) as machine:
                try:
                    facts, errors = model.communicate()
                    said = machine.communicate(timeout=END_S)[0]
                finally:
                    machine.kill()
        finally:
            model.kill()
            model.wait()
    status = 0 if machine.returncode == 0 and model.returncode == 0 else 2
    early = "error: the emulated run ended early" if machine.returncode != 0 else ""
    text = f"{errors}{said}{early}" if status else errors
    return subprocess.CompletedProcess(pixhawk, status, facts, text)


def refuse_unsupported(arguments: argparse.Namespace, plan: Plan) -> None:
    """Raises `UserError` for what a flight on this chip cannot have."""
    for name, reason in REFUSED.items():
        if getattr(arguments, name):
            raise UserError(
                f"error: --{name}: not on board {BOARD}: {reason}\n"
                f"hint: omit --{name}, or use --board qemu_f405"
            )
    unbound = unbound_devices(plan)
    if unbound:
        raise UserError(
            f"error: cannot fly this image: board {BOARD} has no driver for {', '.join(unbound)}\n"
            "hint: use --board qemu_f405"
        )


def counter_options(plan: Plan, image: Path) -> list[str]:
    """Where the firmware counts what its tasks do, and what was lost of the log."""
    at = addresses(image)
    names = [task.node.name for task in plan.tasks]
    places = [at[f"_ZN6stator5tasks{len(name)}{name}5stateE"] for name in names]
    words = [word for place in places for word in ("--task", f"{place:x}")]
    log = at.get("_ZN6stator5board11log_storageE")
    return words if log is None else [*words, "--log-errors", f"{log:x}"]


def machine_command(emulator: Emulator, socket: Path, image: Path) -> list[str]:
    return [
        *(emulator.path, "-M", f"{MACHINE},model={socket},vectors={IMAGE_AT}"),
        *("-kernel", str(image), "-icount", f"shift={SHIFT},align=off,sleep=off"),
        *("-display", "none", "-monitor", "none", "-serial", "none", "-nic", "none"),
    ]


def _await(socket: Path, model: subprocess.Popen[str]) -> None:
    end_s = time.monotonic() + WAIT_S
    while not socket.exists() and model.poll() is None and time.monotonic() < end_s:
        time.sleep(0.01)
