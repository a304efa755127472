"""Names that a graph may use are not macros: the compilers are asked what macros there are."""

from __future__ import annotations

import re
import shutil
import subprocess

import pytest

from stator import HOME
from stator.language.shapes import NAME_PATTERN
from stator.macros import MACROS

CODE = ("runtime", "apps", "drivers", "boards", "codegen/stator/emit/templates")
COMPILERS = ("g++", "clang++", "arm-none-eabi-g++")


def headers(compiler: str) -> list[str]:
    """What the code includes in angle brackets, and this compiler has."""
    texts = [
        file.read_text(encoding="utf-8")
        for folder in CODE
        for file in (HOME / folder).rglob("*.[chj]*")
        if file.suffix in (".hpp", ".cpp", ".j2")
    ]
    names = {name for text in texts for name in re.findall(r"^#include <(.+)>", text, re.MULTILINE)}
    has = "".join(f"#if __has_include(<{name}>)\n{name}\n#endif\n" for name in sorted(names))
    return re.findall(r"^[\w/.]+$", preprocess(compiler, has, "-P"), re.MULTILINE)


def preprocess(compiler: str, text: str, *options: str) -> str:
    command = [compiler, "-std=c++20", "-E", "-x", "c++", "-isystem", "/usr/include/eigen3"]
    return subprocess.run(
        [*command, *options, "-"], input=text, check=True, capture_output=True, text=True
    ).stdout


@pytest.mark.parametrize("compiler", COMPILERS)
def test_no_macro_is_a_name(compiler: str) -> None:
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is missing")
    text = "".join(f"#include <{name}>\n" for name in headers(compiler))
    macros = re.findall(r"^#define (\w+)", preprocess(compiler, text, "-dM"), re.MULTILINE)
    names = {m for m in macros if re.fullmatch(rf"{NAME_PATTERN}|[A-Z][A-Za-z0-9]*", m)}
    assert "EOF" in names
    assert sorted(names - MACROS) == []
