"""Runs firmware in QEMU, in lockstep with the plant."""

from __future__ import annotations

import contextlib
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from stator import HOME
from stator.diagnostics import UserError
from stator.flight.restarts import Endings
from stator.processes import start

# boards/qemu_f405/link.hpp
FIFOS = ("to_plant", "from_plant")
LINES = ("telem1", "telem2")
LOG = "flight.ulg"
MISSION = "mission"
RECORDS = "nonvolatile"
RECORDS_BYTES = 4096 + 16384  # the head, and the memory

# QEMU 7 has the same chip only under another name, without its priority bits and its memory.
MACHINE = "olimex-stm32-h405"
# 8 ns for every instruction; this is not the timing of the chip: docs/emulation.md
SHIFT = 3
TICK_HZ = 1_000_000_000  # of the clock that measures tasks there
END_S = 10.0  # the time in which one side must notice that the other has ended


class NoEmulator(UserError):
    """There is no QEMU that can emulate the chip; the message says what to do."""


@dataclass(frozen=True)
class Emulator:
    path: str
    version: str


def find_emulator() -> Emulator:
    """The QEMU in PATH, or the one in STATOR_QEMU, if it has the machine. The firmware itself
    checks the priority bits of the chip at its start."""
    path = os.environ.get("STATOR_QEMU") or shutil.which("qemu-system-arm")
    if path is None:
        raise NoEmulator("error: missing program 'qemu-system-arm'\n" + _hint())
    try:
        version = _output(path, "--version").splitlines()[0]
        machines = _output(path, "-machine", "help")
    except (OSError, subprocess.CalledProcessError, IndexError) as error:
        raise NoEmulator(f"error: cannot run '{path}': {error}\n" + _hint()) from None
    if not any(line.split()[:1] == [MACHINE] for line in machines.splitlines()):
        raise NoEmulator(
            f"error: expected QEMU with the machine {MACHINE}, found {version}\n" + _hint()
        )
    return Emulator(path, version)


def _hint() -> str:
    return (
        "hint: install QEMU 10 or newer; on Debian 12: apt-get install -t bookworm-backports "
        "qemu-system-arm\nhint: or give its path: STATOR_QEMU=/path/to/qemu-system-arm"
    )


def _output(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def qemu_command(
    emulator: Emulator,
    image: Path,
    shift: int = SHIFT,
    argument: str = "",
    link: Path | None = None,
    lines: int = 0,
) -> list[str]:
    """`shift`: an instruction takes 2^shift nanoseconds. `argument`: for the firmware. `link`: a
    socket that is its first serial port. `lines`: how many of the next ones are FIFOs."""
    serial = ["none" if link is None else f"unix:{link},server=on,wait=off"]
    serial += [f"pipe:{name}" for name in LINES[:lines]]
    option = f",arg={argument}" if argument else ""
    return [
        *(
            emulator.path,
            "-M",
            MACHINE,
            "-kernel",
            str(image),
            "-icount",
            f"shift={shift},align=off,sleep=off",
        ),
        *("-display", "none", "-monitor", "none", "-nic", "none"),
        *(word for place in serial for word in ("-serial", place)),
        *("-semihosting-config", f"enable=on,target=native{option}"),
    ]


def fly(
    emulator: Emulator,
    image: Path,
    plant: list[str],
    log: Path,
    shift: int = SHIFT,
    argument: str = "",
    link: Path | None = None,
    mission: Path | None = None,
    records: Path | None = None,
    lines: int = 0,
    endings: Endings | None = None,
) -> subprocess.CompletedProcess[str]:
    """Runs both sides to their end. Returns the plant's output, and as errors: after a failure the
    messages of both, else the text that the firmware printed. `mission`: the memory of the mission
    device. `records`: the memory that outlives the flight; None: an empty one, which does not.
    `lines`: how many serial lines the plant passes on. `endings`: of the signals that end the
    flight in order."""
    (HOME / "build").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="emulate-", dir=HOME / "build") as name:
        folder = Path(name)
        for fifo in (*FIFOS, *(f"{name}.{end}" for name in LINES[:lines] for end in ("in", "out"))):
            os.mkfifo(folder / fifo)
        if mission is not None:
            shutil.copy(mission, folder / MISSION)
        if records is not None:
            (folder / RECORDS).symlink_to(records.resolve())
        else:
            (folder / RECORDS).write_bytes(bytes(RECORDS_BYTES))
        if endings is None:
            endings = Endings()  # which hears none
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
        # SIGXFSZ stays ignored, as Python has it: a file at its size limit costs the log, not the
        # flight.
        world = endings.start(plant, cwd=folder, restore_signals=False)
        command = qemu_command(emulator, image.resolve(), shift, argument, link, lines)
        # In a group of its own, as Ctrl-C is for the plant, which ends the flight.
        options = {"cwd": folder, "restore_signals": False, "process_group": 0}
        machine = start(command, **options, **pipes)
        try:
            _wait(world, machine)
            facts, complaint = world.communicate()
            console, errors = machine.communicate()
        finally:
            for process in (world, machine):
                process.kill()
                process.wait()
            if link is not None:
                link.unlink(missing_ok=True)
        if (folder / LOG).is_file():
            log.parent.mkdir(parents=True, exist_ok=True)
            shutil.move(folder / LOG, log)
    status = 0 if world.returncode == 0 and machine.returncode == 0 else 2
    text = (
        f"{complaint}{console}{errors}error: the emulated flight ended early: exit status of plant "
    )
    text += f"{world.returncode}, emulator {machine.returncode}"
    return subprocess.CompletedProcess(plant, status, facts, text if status else console + errors)


def _wait(world: subprocess.Popen[str], machine: subprocess.Popen[str]) -> None:
    """Waits until both have ended. If one ends before the other has opened its FIFOs, the other
    would never end: kill it."""
    first, second = world, machine
    while True:
        with contextlib.suppress(subprocess.TimeoutExpired):
            first.wait(0.05)
            break
        first, second = second, first
    try:
        second.wait(END_S)
    except subprocess.TimeoutExpired:
        second.kill()
