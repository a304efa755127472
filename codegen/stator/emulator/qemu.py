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

# boards/qemu_f405/link.hpp
FIFOS = ("to_plant", "from_plant")
LOG = "flight.ulg"

# QEMU 7 models the same chip under another name only, without its priority bits and its memory.
MACHINE = "olimex-stm32-h405"
# 8 ns an instruction, whatever it is: no claim about the chip's timing. docs/emulation.md
SHIFT = 3
END_S = 10.0  # how long the one side may take to see that the other one has ended


class NoEmulator(UserError):
    """No QEMU here that emulates the chip well enough; the message says what to do."""


@dataclass(frozen=True)
class Emulator:
    path: str
    version: str


def find_emulator() -> Emulator:
    """The QEMU in PATH, or the one that STATOR_QEMU names, if it knows the machine. That its chip
    has the right priority bits is what the firmware itself checks when it starts."""
    path = os.environ.get("STATOR_QEMU") or shutil.which("qemu-system-arm")
    if path is None:
        raise NoEmulator("error: qemu-system-arm is not installed\n" + _hint())
    try:
        version = _output(path, "--version").splitlines()[0]
        machines = _output(path, "-machine", "help")
    except (OSError, subprocess.CalledProcessError, IndexError) as error:
        raise NoEmulator(f"error: '{path}' does not run: {error}\n" + _hint()) from None
    if not any(line.split()[:1] == [MACHINE] for line in machines.splitlines()):
        raise NoEmulator(f"error: {version} has no machine {MACHINE}: it is too old\n" + _hint())
    return Emulator(path, version)


def _hint() -> str:
    return (
        "hint: QEMU 10 or newer is needed; on Debian 12: apt-get install -t bookworm-backports "
        "qemu-system-arm\nhint: one that is elsewhere: STATOR_QEMU=/path/to/qemu-system-arm"
    )


def _output(*command: str) -> str:
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def qemu_command(
    emulator: Emulator, image: Path, shift: int = SHIFT, told: str = "", link: Path | None = None
) -> list[str]:
    """`shift`: an instruction takes 2^shift nanoseconds. `told`: words for the firmware. `link`: a
    socket that is its serial port."""
    serial = "none" if link is None else f"unix:{link},server=on,wait=off"
    argument = f",arg={told}" if told else ""
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
        *("-display", "none", "-monitor", "none", "-serial", serial, "-nic", "none"),
        *("-semihosting-config", f"enable=on,target=native{argument}"),
    ]


def fly(
    emulator: Emulator,
    image: Path,
    plant: list[str],
    log: Path,
    shift: int = SHIFT,
    told: str = "",
    link: Path | None = None,
) -> subprocess.CompletedProcess[str]:
    """Runs both sides to their end. The result is the plant's, with the complaints of both; of a
    flight that went well, what the firmware printed."""
    (HOME / "build").mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="emulate-", dir=HOME / "build") as name:
        folder = Path(name)
        for fifo in FIFOS:
            os.mkfifo(folder / fifo)
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        world = subprocess.Popen(plant, cwd=folder, **pipes)  # type: ignore[call-overload]
        machine = subprocess.Popen(
            qemu_command(emulator, image.resolve(), shift, told, link),
            cwd=folder,
            **pipes,  # type: ignore[call-overload]
        )
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
    text = f"{complaint}{console}{errors}error: the emulated flight ended early: plant "
    text += f"{world.returncode}, emulator {machine.returncode}"
    return subprocess.CompletedProcess(plant, status, facts, text if status else console + errors)


def _wait(world: subprocess.Popen[str], machine: subprocess.Popen[str]) -> None:
    """Until both have ended. One that ends before the other has opened its FIFOs would leave it
    waiting for ever."""
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
