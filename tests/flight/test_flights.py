"""Whole flights of the quad: the same bits however it is built, and the limits for many seeds."""

from __future__ import annotations

import json
import subprocess
from pathlib import Path

import pytest

from stator import HOME
from stator import __main__ as cli
from stator.build.cmake import PREEMPTION, RECORDING, build

QUAD = HOME / "graph" / "quad.yaml"


def run(program: Path, log: Path, *options: str) -> dict[str, object]:
    """The facts that the program prints of one flight."""
    command = [program, "--log", log, "--seed", "1", "--duration", "120", *options]
    result = subprocess.run(command, check=True, capture_output=True, text=True)
    facts: dict[str, object] = json.loads(result.stdout)
    return facts


@pytest.fixture(scope="module")
def reference(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The log of gcc at -O2, with a recording: a hash of every sample of every topic."""
    log = tmp_path_factory.mktemp("flight") / "reference.ulg"
    facts = run(build(QUAD, "sitl", RECORDING), log)
    assert facts["ended"] == "motors_stopped"
    return log.read_bytes()


def test_the_same_seed_flies_the_same_log(reference: bytes, tmp_path: Path) -> None:
    run(build(QUAD, "sitl", RECORDING), tmp_path / "again.ulg")
    assert (tmp_path / "again.ulg").read_bytes() == reference


def test_another_seed_flies_another_log(reference: bytes, tmp_path: Path) -> None:
    run(build(QUAD, "sitl", RECORDING), tmp_path / "other.ulg", "--seed", "2")
    assert (tmp_path / "other.ulg").read_bytes() != reference


def test_clang_flies_the_same_log(reference: bytes, tmp_path: Path) -> None:
    """At -O1, which compiles faster."""
    variant = {"CMAKE_CXX_COMPILER": "clang++", "STATOR_OPTIMIZE": "-O1", **RECORDING}
    run(build(QUAD, "sitl", variant), tmp_path / "clang.ulg")
    assert (tmp_path / "clang.ulg").read_bytes() == reference


def test_preemption_points_alone_change_nothing(reference: bytes, tmp_path: Path) -> None:
    run(build(QUAD, "sitl", {**PREEMPTION, **RECORDING}), tmp_path / "points.ulg")
    assert (tmp_path / "points.ulg").read_bytes() == reference


@pytest.mark.long
@pytest.mark.parametrize("optimisation", ["-O0", "-O3"])
@pytest.mark.parametrize("compiler", ["g++", "clang++"])
def test_optimisation_changes_no_bit(
    reference: bytes, tmp_path: Path, compiler: str, optimisation: str
) -> None:
    variant = {"CMAKE_CXX_COMPILER": compiler, "STATOR_OPTIMIZE": optimisation, **RECORDING}
    run(build(QUAD, "sitl", variant), tmp_path / "o.ulg")
    assert (tmp_path / "o.ulg").read_bytes() == reference


@pytest.mark.long
def test_the_sanitizers_find_nothing(reference: bytes, tmp_path: Path) -> None:
    sanitized = {"STATOR_SANITIZE": "address,undefined", **PREEMPTION, **RECORDING}
    program = build(QUAD, "sitl", sanitized)
    run(program, tmp_path / "zero.ulg")
    assert (tmp_path / "zero.ulg").read_bytes() == reference
    run(program, tmp_path / "random.ulg", "--times", "random")


def test_no_symbol_of_libm_in_the_program() -> None:
    """DESIGN 8: nodes, plant and noise use our own maths, so the whole program needs no other."""
    libm = subprocess.run(
        ["gcc", "-print-file-name=libm.so.6"], check=True, capture_output=True, text=True
    ).stdout.strip()
    assert not names(build(QUAD, "sitl"), "--undefined-only") & names(Path(libm), "--defined-only")


def names(file: Path, which: str) -> set[str]:
    """Dynamic symbols of a file, without their versions."""
    result = subprocess.run(
        ["nm", "-D", which, file], check=True, capture_output=True, text=True
    ).stdout
    return {line.split()[-1].split("@")[0] for line in result.splitlines()}


def fly(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, dict[str, object]]:
    status = cli.main(["fly", str(QUAD), "--json", *arguments])
    facts: dict[str, object] = json.loads(capsys.readouterr().out)
    return status, facts


@pytest.mark.parametrize(
    "seed", [*range(1, 3), *(pytest.param(n, marks=pytest.mark.long) for n in range(3, 21))]
)
def test_every_seed_keeps_the_limits(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, seed: int
) -> None:
    status, facts = fly(capsys, "--seed", str(seed), "-o", str(tmp_path / "flight.ulg"))
    assert (status, facts["success"]) == (0, True), facts
    assert facts["lost_samples"] == 0


@pytest.mark.parametrize(
    "seed",
    [
        *(2, 9),
        *(pytest.param(n, marks=pytest.mark.long) for n in range(1, 21) if n not in (2, 9)),
    ],
)
def test_it_holds_its_place_in_wind(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, seed: int
) -> None:
    """Seed 2 has the strongest gusts of the first ten; 9 ends in one that can turn it over."""
    wind = ["--wind", "8", "--gusts", "moderate"]
    status, facts = fly(capsys, *wind, "--seed", str(seed), "-o", str(tmp_path / "flight.ulg"))
    assert (status, facts["success"]) == (0, True), facts
    assert facts["lost_samples"] == 0


@pytest.mark.parametrize(
    "seed", [1, *(pytest.param(n, marks=pytest.mark.long) for n in range(2, 21))]
)
def test_flights_survive_preemption_at_any_access_of_a_topic(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, seed: int
) -> None:
    log = str(tmp_path / "flight.ulg")
    arguments = ["--times", "random", "--seed", str(seed), "-o", log]
    status, facts = fly(capsys, *arguments)
    assert (status, facts["success"]) == (0, True), facts
    _, again = fly(capsys, *arguments)
    assert again["log_sha256"] == facts["log_sha256"]
