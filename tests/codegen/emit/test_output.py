"""`gen` owns its output folder and nothing else."""

import errno
import os
from pathlib import Path

import pytest

from stator import HOME
from stator import __main__ as cli
from stator.emit.emit import MANIFEST

GRAPH = str(HOME / "graph" / "examples" / "timer.yaml")


def gen(folder: Path) -> int:
    return cli.main(["gen", GRAPH, "-o", str(folder)])


def test_a_folder_with_other_files_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "plan.txt").write_text("mine")
    assert gen(tmp_path) == 2
    assert "expected a new or empty folder" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["plan.txt"]
    assert (tmp_path / "plan.txt").read_text() == "mine"


@pytest.mark.parametrize("name", ["../victim.txt", "/victim.txt"])
def test_nothing_outside_the_folder_is_removed(tmp_path: Path, name: str) -> None:
    victim = tmp_path / "victim.txt"
    victim.write_text("mine")
    out = tmp_path / "out"
    assert gen(out) == 0
    with (out / MANIFEST).open("a") as manifest:
        manifest.write(name.replace("/victim", f"{tmp_path}/victim") if name[0] == "/" else name)
    assert gen(out) == 0
    assert victim.read_text() == "mine"


def test_a_file_in_the_way_gives_an_error_with_a_hint(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "out").write_text("mine")
    assert gen(tmp_path / "out") == 2
    assert "hint:" in capsys.readouterr().err


def test_a_full_disk_is_named_and_the_next_run_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    write_bytes = Path.write_bytes

    def until_full(path: Path, data: bytes) -> int:
        if path.suffix == ".hpp":
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write_bytes(path, data)

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_bytes", until_full)
        assert gen(tmp_path / "out") == 2
    error = capsys.readouterr().err
    assert f"cannot write '{tmp_path / 'out'}': No space left on device" in error
    assert gen(tmp_path / "out") == 0


def test_an_empty_name_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        cli.main(["gen", GRAPH, "-o", ""])
    assert "expected a path, found nothing" in capsys.readouterr().err
