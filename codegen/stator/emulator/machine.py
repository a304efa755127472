"""The emulator of the Pixhawk's chip: QEMU with a machine file of ours, built from the
distribution's source package when it is first needed."""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import signal
import subprocess
import sys
from pathlib import Path
from typing import IO, TYPE_CHECKING

from stator import HOME
from stator.diagnostics import shown_path
from stator.emulator.qemu import Emulator, NoEmulator
from stator.lock import Held, Line, held
from stator.processes import environment, start

if TYPE_CHECKING:
    from collections.abc import Sequence

MACHINE = "stm32f427"
MACHINE_FILE = HOME / "boards" / "qemu_machine" / f"{MACHINE}.c"
VERSION = "10.0.2"
# The original tarball of Debian's source package qemu, the same for each of its revisions.
PACKAGE_VERSION = f"1:{VERSION}+ds-"
SOURCE = f"qemu_{VERSION}+ds.orig.tar.xz"
SHA256 = "0901da33844a331bf8b3602b9c1fbd178e60b737c8e3ade678255bd090c9b9f1"
# One kind of processor, and nothing of what a graphical machine has.
OPTIONS = (
    *("--target-list=arm-softmmu", "--without-default-features", "--without-default-devices"),
    *("--enable-system", "--enable-tcg", "--enable-fdt=system", "--disable-docs"),
    *("--disable-tools", "--disable-install-blobs", "--disable-download", "--disable-werror"),
    # Less to wait for: a run waits for the model of the peripherals, not for what QEMU computes.
    *("--disable-debug-info", "-Doptimization=1"),
)
# What its build needs of Python, besides what each environment has.
TOOLS = ("meson==1.12.1", "pycotap==1.3.1")
PROGRAM = "qemu-system-arm"
FOLDER = HOME / "build" / "emulator"
STEP = re.compile(r"\[(\d+)/(\d+)\] ")  # ninja's progress
# Where the user's packages come from, and the compiler's cache, as in CMakeLists.txt.
_SETTINGS = {
    name: value
    for name, value in os.environ.items()
    if name.startswith("PIP_") and name not in ("PIP_TARGET", "PIP_PREFIX", "PIP_USER")
} | {
    "CCACHE_DIR": str(HOME / "build" / "ccache"),
    "CCACHE_BASEDIR": str(HOME),
    "CCACHE_NOHASHDIR": "1",
}


def chip_emulator() -> Emulator:
    """The emulator of the chip; builds it if this version has not been built yet. Raises
    `NoEmulator`."""
    key = hashlib.sha256("\n".join([SHA256, *OPTIONS]).encode() + MACHINE_FILE.read_bytes())
    program = FOLDER / key.hexdigest()[:16] / PROGRAM
    if not program.is_file():
        FOLDER.mkdir(parents=True, exist_ok=True)
        with held(FOLDER / "lock", "builds the emulator") as lock:
            if not program.is_file():
                _build(program, lock)
    return Emulator(str(program), f"QEMU emulator version {VERSION}, machine {MACHINE}")


def _build(program: Path, lock: Held) -> None:
    """Leaves nothing but the program, and the log if it fails."""
    log = FOLDER / "build.log"
    folder = FOLDER / "source"  # the same each time, for the compiler's cache
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir()
    try:
        with log.open("w", encoding="utf-8") as text:
            _build_in(folder, program, _Steps(folder, lock, text))
    finally:
        shutil.rmtree(folder, ignore_errors=True)
    log.unlink()


def _build_in(folder: Path, program: Path, steps: _Steps) -> None:
    _unpack(_source(steps), steps)
    _add_machine(folder)
    python = folder / "tools" / "bin" / "python"
    steps.run("making an environment", [sys.executable, "-m", "venv", folder / "tools"], folder)
    pip: list[str | Path] = [python, "-I", "-m", "pip", "install", "--only-binary", ":all:"]
    steps.run("installing Meson", [*pip, *TOOLS], folder)
    build = folder / "build"
    build.mkdir()
    compiler = "ccache cc" if shutil.which("ccache") else "cc"
    configure: list[str | Path] = [folder / "configure", f"--python={python}"]
    steps.run("configuring the emulator", [*configure, f"--cc={compiler}", *OPTIONS], build)
    steps.run("building the emulator", ["ninja", *_jobs(), PROGRAM], build)
    steps.run("stripping the emulator", ["strip", PROGRAM], build)
    for old in FOLDER.glob(f"*/{PROGRAM}"):
        shutil.rmtree(old.parent)
    program.parent.mkdir(parents=True, exist_ok=True)
    (build / PROGRAM).replace(program)


def _jobs() -> list[str]:
    number = os.environ.get("CMAKE_BUILD_PARALLEL_LEVEL")
    return ["-j", number] if number else []


def _add_machine(folder: Path) -> None:
    shutil.copy(MACHINE_FILE, folder / "hw" / "arm")
    listed = folder / "hw" / "arm" / "meson.build"
    first = "arm_ss.add(files('boot.c'))"
    text = listed.read_text(encoding="utf-8")
    assert first in text
    added = f"{first}\narm_ss.add(files('{MACHINE_FILE.name}'))"
    listed.write_text(text.replace(first, added), encoding="utf-8")
    # Firmware of other machines, which the tarball lacks.
    (folder / "pc-bios" / "meson.build").write_text("roms = []\nblobs = []\n", encoding="utf-8")


class _Steps:
    """Runs the programs that build the emulator, one after the other, with their output in the
    log."""

    def __init__(self, folder: Path, lock: Held, log: IO[str]) -> None:
        self.folder = folder
        self._lock = lock
        self._log = log
        self._line = Line(quiet_s=0.0)

    def run(self, what: str, command: Sequence[str | Path], folder: Path) -> None:
        """Raises `NoEmulator`."""
        said = f"{what} (once, some minutes)"
        self._line.show(f"stator: {said}")
        self._lock.tell(what)
        lines: list[str] = []
        with start(
            command,
            cwd=folder,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            errors="replace",
            env=environment() | _SETTINGS,
            pass_fds=(self._lock.fileno(),),
            process_group=0,
        ) as process:
            try:
                for text in process.stdout or ():
                    self._log.write(text)
                    step = STEP.match(text)
                    if step is None:
                        lines.append(text.rstrip())
                        continue
                    self._line.show(f"stator: {said}: step {step[1]} of {step[2]}")
                    self._lock.tell(f"step {step[1]} of {step[2]}")
            except BaseException:
                os.killpg(process.pid, signal.SIGTERM)
                raise
        self._line.clear()
        if process.returncode != 0:
            end = "\n".join(f"    {line}" for line in lines[-12:])
            raise NoEmulator(
                f"{end}\nerror: cannot build the emulator: {what} failed\n"
                f"hint: read {shown_path(FOLDER / 'build.log')}; ./stator setup installs the "
                "programs that it needs"
            )


def _unpack(source: Path, steps: _Steps) -> None:
    command: list[str | Path] = [
        "tar",
        "-x",
        "--strip-components=1",
        "--exclude=*/roms/*",
        "-f",
        source,
    ]
    steps.run("unpacking the source of the emulator", command, steps.folder)


def _source(steps: _Steps) -> Path:
    """The tarball. Raises `NoEmulator` if it cannot be had or has other content."""
    given = os.environ.get("STATOR_QEMU_SOURCE")
    source = Path(given) if given else _downloaded(steps)
    if not source.is_file():
        raise _no_source(f"there is no file '{source}'")
    with source.open("rb") as file:
        found = hashlib.file_digest(file, "sha256").hexdigest()
    if found != SHA256:
        raise _no_source(f"expected SHA-256 {SHA256}, found {found} in '{source}'")
    return source


def _no_source(reason: str) -> NoEmulator:
    return NoEmulator(
        f"error: cannot get the source of QEMU {VERSION}: {reason}\n"
        f"hint: it is the file {SOURCE} of Debian's source package qemu; download it, and name it: "
        f"STATOR_QEMU_SOURCE=/path/to/{SOURCE}"
    )


def _downloaded(steps: _Steps) -> Path:
    """By apt, from the server and suite that have the packages of this version; with lists of its
    own, so it needs no rights, and the user's stay as they are."""
    folder = steps.folder / "apt"
    (folder / "lists" / "partial").mkdir(parents=True)
    try:
        known = subprocess.run(
            ["apt-cache", "madison", PROGRAM],
            env=environment(),
            check=True,
            capture_output=True,
            text=True,
        ).stdout
    except (OSError, subprocess.CalledProcessError) as error:
        raise _no_source(f"cannot run apt-cache: {error}") from None
    # package | version | server suite/component architecture Packages
    rows = [[cell.strip() for cell in line.split("|")] for line in known.splitlines()]
    row = next((row for row in rows if row[1].startswith(PACKAGE_VERSION)), None)
    if row is None:
        found = ", ".join(dict.fromkeys(row[1] for row in rows)) or "none"
        raise _no_source(f"expected version {PACKAGE_VERSION}* among apt's packages, found {found}")
    server, place = row[2].split()[:2]
    suite, _, component = place.partition("/")
    # Trusted, because the content is compared with its SHA-256.
    entry = f"deb-src [trusted=yes] {server} {suite} {component}\n"
    (folder / "sources.list").write_text(entry, encoding="utf-8")
    options = {
        "Dir::Etc::sourcelist": folder / "sources.list",
        "Dir::Etc::sourceparts": "/dev/null",
        "Dir::State::lists": folder / "lists",
        "Dir::Cache": folder,
        "APT::Sandbox::User": "",
    }
    apt = [
        "apt-get",
        "-q",
        *(w for key, value in options.items() for w in ("-o", f"{key}={value}")),
    ]
    what = "downloading the source of the emulator, 39 MB"
    try:
        steps.run(what, [*apt, "update"], folder)
        steps.run(what, [*apt, "source", "--tar-only", f"qemu={row[1]}"], folder)
    except NoEmulator as failed:
        raise _no_source(
            f"apt-get failed\n{str(failed).partition(chr(10) + 'error:')[0]}"
        ) from None
    return folder / SOURCE
