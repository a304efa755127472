"""What `./stator emulate` does: the firmware itself flies, in QEMU, in lockstep with the plant."""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

from stator.build import SLEEP, build_plant
from stator.cli import make_plan, path
from stator.diagnostics import ANSWER_IS_NO, UserError
from stator.fault_record import in_words
from stator.firmware import build_image
from stator.flight_arguments import (
    add_flight_arguments,
    flight_options,
    is_judged,
    is_recorded,
    is_windy,
    rates_of,
    recording_of,
    speed_of,
)
from stator.flight_facts import default_log, facts_of, keep
from stator.flight_report import report
from stator.library import HOME
from stator.link_place import DEFAULT as LINK
from stator.link_place import socket_place
from stator.progress import progress

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


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_flight_arguments(parser, board="qemu_f405", what="a board that the emulator knows")
    parser.add_argument(
        "--sleep",
        action="store_true",
        help="sleep when idle, as on hardware; two flights may then differ (docs/emulation.md)",
    )
    parser.add_argument(
        "--link",
        nargs="?",
        type=path,
        const=LINK,
        metavar="PATH",
        help="offer the firmware's serial port as a socket, to ./stator top, listener and perf; "
        "two flights may then differ",
    )
    parser.add_argument(
        "--speed",
        type=speed_of,
        metavar="FACTOR",
        help="at most so many times real time; 1 is real time (default: as fast as it goes)",
    )


def main(arguments: argparse.Namespace) -> int:
    """The answer is yes if the flight was successful; no, too, if it could not be judged."""
    log = arguments.output or default_log(arguments.graph, arguments.seed, ".emulated")
    truth = log.with_name(f"{log.name.removesuffix('.ulg')}.truth")
    emulator = find_emulator()
    variant = (SLEEP if arguments.sleep else {}) | recording_of(arguments)
    image = build_image(arguments.graph, arguments.board, variant)
    plant = build_plant()
    link = None if arguments.link is None else socket_place(arguments.link)
    options = ["--truth", str(truth.resolve()), *flight_options(arguments)]
    if arguments.speed is not None:
        options += ["--speed", f"{arguments.speed:.6f}"]
    name = f"emulating {arguments.graph.stem}, seed {arguments.seed}"
    with progress(name, truth, arguments.duration):
        finished = fly(emulator, image, [str(plant), *options], log, link=link)
        if finished.returncode != 0:
            plan = make_plan(str(arguments.graph), arguments.board)
            raise UserError(in_words(finished.stderr, plan, image).rstrip())
        facts = facts_of(
            finished,
            log,
            truth,
            most_s=arguments.duration,
            judges=is_judged(arguments),
            is_recorded=is_recorded(arguments),
            in_wind=is_windy(arguments),
        )
    facts |= rates_of(arguments)
    facts |= {"graph": arguments.graph.stem, "board": arguments.board, "seed": arguments.seed}
    facts["emulator"] = emulator.version
    facts["missed_samples"] = json.loads(finished.stdout)["missed_samples"]
    keep(facts)
    if arguments.json:
        print(json.dumps(facts, indent=2))
    else:
        report(facts)
    return 0 if facts["success"] else ANSWER_IS_NO


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
