"""Fuzzes transport and codecs; inputs that once broke them lie in found/ and are tried first."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from stator.build.dronecan_codecs import TYPES

ROOT = Path(__file__).resolve().parents[3]
HERE = Path(__file__).parent
BUILD = ROOT / "build" / "fuzz"
Counts = dict[str, Any]
LONGEST_INPUT = 2048  # 128 frames: two of the longest transfers
COMPILE = ["clang++", "-std=c++20", "-O1", "-g", "-Wall", "-Wextra", "-Werror"]
COMPILE += ["-fno-exceptions", "-fno-rtti", "-fno-sanitize-recover=all"]
COMPILE += ["-fsanitize=fuzzer,address,undefined", "-D_GLIBCXX_ASSERTIONS"]


@pytest.fixture(scope="module")
def fuzzer() -> Path:
    BUILD.mkdir(parents=True, exist_ok=True)
    python = [sys.executable, "-I", "-X", "utf8"]
    codecs = BUILD / "codecs"
    subprocess.run([*python, "-m", "stator.build.dronecan_codecs", str(codecs)], check=True)
    subprocess.run([*python, str(HERE / "make_seeds.py"), str(BUILD / "seeds")], check=True)
    program = BUILD / "fuzz_transfers"
    runtime = ROOT / "runtime" / "dronecan"
    sources = [*sorted(HERE.glob("fuzz_*.cpp")), *sorted(runtime.glob("*.cpp"))]
    folders = [f"-I{runtime}", f"-I{codecs}", f"-I{HERE}"]
    subprocess.run([*COMPILE, *folders, *map(str, sources), "-o", str(program)], check=True)
    return program


def run(fuzzer: Path, *arguments: str, **environment: str) -> Counts:
    """What the program says at its end that it has seen."""
    finished = subprocess.run(
        [str(fuzzer), f"-max_len={LONGEST_INPUT}", *arguments],
        cwd=BUILD,
        env=os.environ | {"STATOR_FUZZ_COUNTS": "1"} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    hint = f"the input is in {BUILD}; once mended, keep it in {HERE / 'found'}"
    assert finished.returncode == 0, f"{finished.stderr[-4000:]}\n{hint}"
    line = next(line for line in finished.stderr.splitlines() if line.startswith('{"starts"'))
    counts: Counts = json.loads(line)
    return counts


def corpus() -> str:
    folder = BUILD / "corpus"
    folder.mkdir(exist_ok=True)
    return str(folder)


def test_what_was_once_found(fuzzer: Path) -> None:
    run(fuzzer, "-runs=0", str(HERE / "found"), str(BUILD / "seeds"))


def test_allocations_of_other_threads_do_not_count(fuzzer: Path) -> None:
    run(fuzzer, "-runs=0", str(BUILD / "seeds"), STATOR_FUZZ_NEIGHBOUR="1")


def test_fifty_thousand_inputs(fuzzer: Path) -> None:
    counts = run(fuzzer, "-seed=1", "-runs=50000", corpus(), str(BUILD / "seeds"))
    # Good transfers and such as are none, of each type but the one without any bits.
    assert len(counts["decoded"]) > len(TYPES)
    assert all(counts["decoded"]), counts
    assert counts["undecodable"].count(0) == 1, counts
    assert counts["kept"] > 0


@pytest.mark.long
def test_ten_million_mutated_transfers(fuzzer: Path) -> None:
    transfers = 0
    for seed in range(2, 100):
        counts = run(fuzzer, f"-seed={seed}", "-runs=500000", corpus(), str(BUILD / "seeds"))
        transfers += counts["starts"]
        if transfers >= 10_000_000:
            return
    raise AssertionError(transfers)
