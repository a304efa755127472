"""Small images of a few lines of C++, for what no image may do."""

from __future__ import annotations

import subprocess
from typing import TYPE_CHECKING

from tests.emulation.firmware_tools import needs_toolchain

if TYPE_CHECKING:
    from pathlib import Path

FLAGS = ["-mcpu=cortex-m4", "-mthumb", "-mfloat-abi=hard", "-mfpu=fpv4-sp-d16", "-O1", "-g"]
STRICT = ["-fno-exceptions", "-fno-rtti", "-fno-threadsafe-statics", "-fno-math-errno"]


def image(folder: Path, code: str, *flags: str) -> Path:
    needs_toolchain()
    source, result = folder / "planted.cpp", folder / "planted.elf"
    source.write_text(code)
    command = ["arm-none-eabi-g++", "-std=c++20", *FLAGS, *(flags or STRICT), "--specs=nosys.specs"]
    command += [
        "-nostartfiles",
        "-Wl,-emain",
        "-Wl,--defsym=__dso_handle=0",
        "-Wl,--gc-sections",
        "-ffunction-sections",
    ]
    subprocess.run([*command, source, "-o", result], check=True, capture_output=True)
    return result
