"""Damaged graphs give clean errors: never a traceback, never a hang; and what passes the check is
generated without letting any text of the user out of its comment.

STATOR_SEED=N tries other cases; each case is a function of the seed and its number.
"""

from __future__ import annotations

import os
import shutil
import signal
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from random import Random

import pytest
from tests.codegen.language.mutate import MARKER, mutate_text, mutate_tree

from stator.diagnostics import Failed
from stator.emit.emit import emit
from stator.graph.check import check
from stator.plan.plan import plan
from stator.rules import RULES

EXAMPLES = Path(__file__).resolve().parents[3] / "graph" / "examples"
SEED = os.environ.get("STATOR_SEED", "1")
LONGEST_S = 600  # a case that hangs ends here; a usual one takes milliseconds
GRAPHS = ("modes", "include", "chain", "params", "several_triggers", "publishers", "queue", "log")
PARTS = (
    "parts/counting.yaml", "apps/counter/counter.yaml", "apps/adder/adder.yaml",
    "messages/Count.yaml", "boards/desk/board.yaml", "budgets/desk.yaml",
)  # fmt: skip


class Hung(BaseException):
    """Not an Exception, so that nothing on the way catches it."""


@contextmanager
def bounded() -> Iterator[None]:
    def stop(*_: object) -> None:
        raise Hung

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(LONGEST_S)
    try:
        yield
    finally:
        signal.alarm(0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("mutations") / "examples"
    shutil.copytree(EXAMPLES, place)
    return place


def damage(text: str, random: Random) -> str:
    for _ in range(random.choice([1, 1, 2, 3])):
        if random.random() < 0.5:
            text = mutate_text(text, random)
            continue
        try:
            text = mutate_tree(text, random)
        except Exception:  # the text is no YAML any more: damage it as text
            text = mutate_text(text, random)
    return text


def check_clean(graph: Path, board: str | None) -> bool:
    """Whether the graph is good. Whatever is wrong with it is an error that can be shown."""
    try:
        checked, target = check(graph, board)
        files = emit(plan(checked, target))
    except Failed as failed:
        assert failed.errors
        for error in failed.errors:
            assert error.rule in RULES
            assert error.message
            assert "\n" not in error.message + error.hint
            assert MARKER not in error.text() or "error: " in error.text()
            assert all(part.isprintable() for part in error.text().split("\n"))
        marks = [error.mark for error in failed.errors]
        assert marks == sorted(marks)
        return False
    check_generated(files)
    return True


def check_generated(files: dict[str, str]) -> None:
    for name, text in files.items():
        for line in text.split("\n"):
            code, _, _ = line.partition("//")
            assert MARKER not in code, f"{name}: {line}"
            assert not line.endswith("\\"), f"{name}: {line}"
            if name.endswith((".hpp", ".cpp")):
                assert "{%" not in code
                assert "7*7" not in code
            assert line.isprintable(), f"{name}: {line!r}"


def run_case(number: int, folder: Path) -> bool:
    random = Random(f"{SEED} {number}")
    graph = folder / f"{random.choice(GRAPHS)}.yaml"
    victim = graph if random.random() < 0.65 else folder / random.choice(PARTS)
    board = random.choice([None, None, None, "sitl", "fmu_v2"])
    whole = victim.read_bytes()
    text = damage(whole.decode(), random)
    victim.write_text(text, encoding="utf-8", errors="surrogatepass", newline="")
    try:
        with bounded():
            return check_clean(graph, board)
    except (Exception, Hung) as error:
        raise AssertionError(
            f"case {number} of STATOR_SEED={SEED} ({victim.name} of {graph.name}, board {board}): "
            f"{error!r}\n{text}"
        ) from error
    finally:
        victim.write_bytes(whole)


@pytest.mark.parametrize("block", range(20))
def test_two_thousand(block: int, folder: Path) -> None:
    print(f"STATOR_SEED={SEED}")
    for number in range(100 * block, 100 * block + 100):
        run_case(number, folder)


@pytest.mark.long
@pytest.mark.parametrize("block", range(100))
def test_a_hundred_thousand(block: int, folder: Path) -> None:
    print(f"STATOR_SEED={SEED}")
    for number in range(1000 * block, 1000 * block + 1000):
        run_case(number, folder)


def test_some_pass_and_some_fail(folder: Path) -> None:
    """Else the cases above would show little."""
    good = sum(run_case(number, folder) for number in range(200))
    assert 10 <= good <= 190
