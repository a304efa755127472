"""The bare-metal executor in QEMU: order, sections, time, releases, and each kind of fault."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from tests.emulation.firmware_tools import needs_emulator

from stator import HOME
from stator.emit.emit import emit
from stator.emulator.qemu import qemu_command
from stator.pipeline import make_plan

FLAGS = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-O2"]
FLAGS += ["-std=c++20", "-Wall", "-Wextra", "-Werror", "-fno-exceptions", "-fno-rtti"]
FLAGS += ["-ffunction-sections", "-fdata-sections", "-nostartfiles", "--specs=nano.specs"]
ROOMS = ["core", "recording/off", "watch", "link", "bytes", "cortex_m"]
INCLUDES = [f"runtime/{room}" for room in ROOMS] + ["boards/qemu_f405"]
LIMIT_S = 600  # of a program that takes milliseconds; on a hang


def run(folder: Path, scenario: str) -> tuple[int, str]:
    """Exit status, and what the scenario printed."""
    emulator = needs_emulator()
    script = folder / "image.ld"
    script.write_text(emit(make_plan(str(HOME / "graph" / "quad.yaml"), "qemu_f405"))["image.ld"])
    sources = [Path(__file__).with_name("scenarios.cpp"), HOME / "boards/qemu_f405/semihosting.cpp"]
    sources += sorted((HOME / "runtime" / "cortex_m").glob("*.cpp"))
    image = folder / "image.elf"
    command: list[str | Path] = ["arm-none-eabi-g++", *FLAGS, f"-DSCENARIO={scenario}"]
    command += [f"-I{HOME / path}" for path in INCLUDES]
    subprocess.run(
        [*command, f"-T{script}", "-Wl,--gc-sections", *sources, "-o", image], check=True
    )
    finished = subprocess.run(
        qemu_command(emulator, image), capture_output=True, text=True, timeout=LIMIT_S, check=False
    )
    return finished.returncode, finished.stdout + finished.stderr


@pytest.mark.parametrize(
    ("scenario", "printed"),
    [
        # More urgent ones run at once, inside; those of one level in the order of their vectors.
        ("order", "low( high middle other )low"),
        # The ceiling's own level waits for the end of the section, a higher one does not.
        ("section", "low( high held middle )low"),
        ("nested_section", "low( held high )low"),
        ("cleared", "low( held )low"),
        ("clock", "low( ran )low"),
    ],
)
def test_tasks_nest_as_levels_say(tmp_path: Path, scenario: str, printed: str) -> None:
    status, text = run(tmp_path, scenario)
    assert (status, text) == (0, printed)


def test_releases_do_not_drift(tmp_path: Path) -> None:
    """Of every 2.5 ms + 100 us, 20 are due at 50 ms."""
    status, text = run(tmp_path, "releases")
    assert status == 0
    assert text == "0x00000014"


@pytest.mark.parametrize(
    ("scenario", "printed"),
    [
        # ARMv7-M B3.2.15: BFARVALID and PRECISERR.
        ("unmapped", "exception 0x00000005 status 0x00008200"),
        ("divide", "exception 0x00000006 status 0x02000000"),  # DIVBYZERO
        ("undefined", "exception 0x00000006 status 0x00010000"),  # UNDEFINSTR
        # HardFault, as no configurable fault preempts another one.
        ("nested", "exception 0x00000006 status 0x02000000 nested 0x00000003"),
        ("nobody", "exception 0x00000024 status 0x00000000"),  # 16 + vector 20
    ],
)
def test_each_fault_is_told(tmp_path: Path, scenario: str, printed: str) -> None:
    status, text = run(tmp_path, scenario)
    assert status == 3
    assert text.endswith(printed), text


def test_a_full_stack_faults_and_is_told(tmp_path: Path) -> None:
    status, text = run(tmp_path, "overflow")
    assert status == 3
    assert "exception 0x00000004" in text  # below the stack lies a guard
    assert text.endswith(" no stack")


def test_what_cannot_be_ends_in_the_safe_state(tmp_path: Path) -> None:
    status, text = run(tmp_path, "impossible")
    assert status == 2
    assert text.endswith("this cannot be")
