"""`./stator flash`: builds the image of a graph and writes it to a board."""

from __future__ import annotations

import argparse
import hashlib
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import serial

from stator.arguments import add_verbose_argument, path
from stator.build.image import add_record_argument, build_image, image_files, recording_of
from stator.build.px4_bootloader import Bootloader
from stator.build.px4_file import padded
from stator.diagnostics import NOT_DONE, UserError, shown_path
from stator.pipeline import make_buildable_plan
from stator.plan.text import unbound_devices
from stator.prove.gate import add_unproven_argument, require_proof

if TYPE_CHECKING:
    from stator.plan.plan import Plan

METHODS = {
    "bootloader": "the bootloader of the board, over USB or a serial line",
    "dfu": "the ROM bootloader of the chip, with dfu-util",
    "probe": "a debug probe, with pyOCD",
}
PORT = "/dev/serial/by-id/*PX4*"
BAUD = 115200
WAIT_S = 30.0
ANSWER_S = 0.5


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("graph", type=path, help="graph file, for example graph/quad.yaml")
    parser.add_argument("--board", help="build for this board instead of the graph's own")
    methods = "; ".join(f"{name}: {text}" for name, text in METHODS.items())
    parser.add_argument("--method", choices=METHODS, default="bootloader", help=methods)
    parser.add_argument("--port", help=f"serial port of the bootloader (default: {PORT})")
    add_record_argument(parser)
    add_unproven_argument(parser)
    add_verbose_argument(parser)
    parser.add_argument("--dry-run", action="store_true", help="show the steps without doing them")


def main(arguments: argparse.Namespace) -> int:
    plan = make_buildable_plan(str(arguments.graph), arguments.board)
    if plan.board.upload is None or plan.board.chip is None:
        raise UserError(
            f"error: cannot flash board '{plan.board.name}': its board.yaml has no key `upload`"
            "\nhint: add --board fmu_v2"
        )
    is_proven = require_proof(plan, unproven=arguments.unproven or arguments.dry_run)
    variant = recording_of(plan) if arguments.record else {}
    image = build_image(arguments.graph, arguments.board, variant)
    file = image_files(plan, image, is_proven=is_proven)["bin"]
    refusal = _refusal(plan)
    if arguments.dry_run:
        print("\n".join(_steps(plan, file, arguments)))
        if refusal:
            print(f"note: without --dry-run, flash refuses this image: {refusal}")
        if not is_proven and not arguments.unproven:
            print("NOT PROVEN: without --dry-run, flash needs --unproven; ./stator prove says why")
        return 0
    if refusal:
        raise UserError(
            f"error: cannot flash this image: {refusal}\n"
            "hint: add --dry-run to see the steps, or use ./stator build to build the image only"
        )
    if arguments.method == "bootloader":
        _upload(plan, padded(file.read_bytes()), arguments.port)
        return 0
    command = _command(plan, file, arguments.method)
    if shutil.which(command[0]) is None:
        raise UserError(f"error: missing program '{command[0]}'\nhint: {INSTALL[command[0]]}")
    print(shlex.join(command), flush=True)
    return 0 if subprocess.run(command, check=False).returncode == 0 else NOT_DONE


INSTALL = {
    "dfu-util": "apt-get install dfu-util",
    "pyocd": "pipx install pyocd, then pyocd pack install CHIP",
}


def _refusal(plan: Plan) -> str:
    """Why this image must not be written to a vehicle; empty if it may."""
    unbound = unbound_devices(plan)
    if not unbound:
        return ""
    return f"board {plan.board.name} has no driver for {', '.join(unbound)}"


def _command(plan: Plan, file: Path, method: str) -> list[str]:
    assert plan.board.upload is not None
    assert plan.board.chip is not None
    at = f"{plan.board.chip.memory['flash'].at:#010x}"
    if method == "dfu":
        start = f"{at}:leave"
        return ["dfu-util", "--alt", "0", "--dfuse-address", start, "--download", str(file)]
    target = plan.board.upload.pyocd_target or plan.board.chip.name.split("/")[1]
    return ["pyocd", "flash", "--target", target, "--base-address", at, str(file)]


def _steps(plan: Plan, file: Path, arguments: argparse.Namespace) -> list[str]:
    assert plan.board.upload is not None
    steps = [
        f"built     {shown_path(file)}, {file.stat().st_size:,} bytes, passed all checks, "
        f"SHA-256 {hashlib.sha256(file.read_bytes()).hexdigest()}"
    ]
    if arguments.method != "bootloader":
        return [*steps, f"run       {shlex.join(_command(plan, file, arguments.method))}"]
    port = arguments.port or PORT
    return [
        *steps,
        f"wait      at most {WAIT_S:.0f} s for a bootloader on {port} at {BAUD} baud",
        f"identify  board id {plan.board.upload.board_id}, protocol, flash size",
        "erase     the application, not the bootloader",
        f"program   {len(padded(file.read_bytes())):,} bytes",
        "check     the CRC-32 of the whole flash",
        "start     the image",
    ]


def _upload(plan: Plan, image: bytes, port: str | None) -> None:
    assert plan.board.upload is not None
    try:
        with _find_bootloader(port) as found:
            bootloader = Bootloader(found)
            bootloader.identify(plan.board.upload.board_id, len(image))
            print("erase     ...", flush=True)
            bootloader.erase()
            bootloader.program(image, lambda done: _show_progress(done, len(image)))
            bootloader.verify(image)
            bootloader.start()
    except serial.SerialException as error:
        raise UserError(
            f"error: {error}\nhint: unplug the board, plug it in again, and repeat the command"
        ) from None
    print(f"check     passed: {len(image):,} bytes\nstart     {plan.graph.name} runs")


def _show_progress(done: int, total: int) -> None:
    end = "\n" if done == total else ""
    if sys.stdout.isatty() or end:
        print(f"\rprogram   {done:,} of {total:,} bytes", end=end, flush=True)


def _find_bootloader(port: str | None) -> serial.Serial:
    """An open port on which a bootloader answers."""
    pattern = Path(port or PORT)
    print(
        f"wait      for a bootloader on {pattern}: plug in the board, or press its reset button",
        flush=True,
    )
    end = time.monotonic() + WAIT_S
    while time.monotonic() < end:
        for name in sorted(pattern.parent.glob(pattern.name)):
            try:
                found = serial.Serial(str(name), BAUD, timeout=ANSWER_S)
            except serial.SerialException:
                continue
            if Bootloader(found).is_there():
                return found
            found.close()
        time.sleep(0.1)
    raise UserError(
        f"error: no answer from a bootloader on {pattern} within {WAIT_S:.0f} s\n"
        "hint: repeat the command, then power-cycle the board: its bootloader listens for some "
        "seconds after power-on; use --port for another port"
    )
