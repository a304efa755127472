"""The committed tables are what their scripts write."""

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent
MATH = Path(__file__).parents[3] / "runtime" / "math"

PAIRS = [
    (HERE / "make_reference.py", HERE / "reference.inc"),
    (MATH / "detail" / "fit_coefficients.py", MATH / "detail" / "coefficients.hpp"),
]


@pytest.mark.long
@pytest.mark.parametrize(("script", "table"), PAIRS, ids=lambda path: path.name)
def test_table_is_what_its_script_writes(script: Path, table: Path) -> None:
    """Compares without white space, of which clang-format makes more or less."""
    run = subprocess.run([sys.executable, script], capture_output=True, text=True, check=True)
    assert run.stdout.split() and "".join(run.stdout.split()) == "".join(table.read_text().split())
