"""Fuzzes transport and codecs; inputs that once broke them lie in found/ and are tried first."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
HERE = Path(__file__).parent
BUILD = ROOT / "build" / "fuzz"
LONGEST_INPUT = 2048  # 128 frames: two of the longest transfers
COMPILE = ["clang++", "-std=c++20", "-O1", "-g", "-Wall", "-Wextra", "-Werror"]
COMPILE += ["-fno-exceptions", "-fno-rtti", "-fno-sanitize-recover=all"]
COMPILE += ["-fsanitize=fuzzer,address,undefined"]


@pytest.fixture(scope="module")
def fuzzer() -> Path:
    BUILD.mkdir(parents=True, exist_ok=True)
    python = [sys.executable, "-I", "-X", "utf8"]
    codecs = BUILD / "codecs"
    command = [sys.executable, "-m", "stator.dronecan_codecs", str(codecs)]
    subprocess.run(command, cwd=ROOT / "codegen", check=True)
    subprocess.run([*python, str(HERE / "make_seeds.py"), str(BUILD / "seeds")], check=True)
    program = BUILD / "fuzz_transfers"
    runtime = ROOT / "runtime" / "dronecan"
    sources = [HERE / "fuzz_transfers.cpp", *sorted(runtime.glob("*.cpp"))]
    folders = [f"-I{runtime}", f"-I{codecs}", f"-I{HERE}"]
    subprocess.run([*COMPILE, *folders, *map(str, sources), "-o", str(program)], check=True)
    return program


def run(fuzzer: Path, *arguments: str) -> None:
    finished = subprocess.run(
        [str(fuzzer), *arguments], cwd=BUILD, capture_output=True, text=True, check=False
    )
    hint = f"the input is in {BUILD}; once mended, keep it in {HERE / 'found'}"
    assert finished.returncode == 0, f"{finished.stderr[-4000:]}\n{hint}"


def test_what_was_once_found(fuzzer: Path) -> None:
    run(fuzzer, "-runs=0", str(HERE / "found"), str(BUILD / "seeds"))


def test_ten_seconds_of_fuzzing(fuzzer: Path) -> None:
    corpus = BUILD / "corpus"
    corpus.mkdir(exist_ok=True)
    run(
        fuzzer,
        "-seed=1",
        "-max_total_time=10",
        f"-max_len={LONGEST_INPUT}",
        str(corpus),
        str(BUILD / "seeds"),
    )


@pytest.mark.long
def test_ten_million_mutated_inputs(fuzzer: Path) -> None:
    corpus = BUILD / "corpus"
    corpus.mkdir(exist_ok=True)
    run(
        fuzzer,
        "-seed=2",
        "-runs=10000000",
        f"-max_len={LONGEST_INPUT}",
        str(corpus),
        str(BUILD / "seeds"),
    )
