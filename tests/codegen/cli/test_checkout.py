"""What a clone holds, whatever git is told about line ends."""

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]


def test_a_clone_with_automatic_line_ends_has_none_of_windows(tmp_path: Path) -> None:
    if not (ROOT / ".git").exists():
        pytest.skip("NOT TESTED: this is no clone")
    git = ["git", "-c", "core.autocrlf=true", "-C", str(ROOT)]
    prefix = f"--prefix={tmp_path}/"
    subprocess.run([*git, "checkout-index", "--all", prefix], check=True)
    wrong = [
        path.relative_to(tmp_path)
        for path in sorted(tmp_path.rglob("*"))
        if path.suffix != ".png" and path.is_file() and b"\r\n" in path.read_bytes()
    ]
    assert wrong == [Path("tests/codegen/language/bad/line_ends_crlf.yaml")]
