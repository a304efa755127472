"""Building the emulator of the Pixhawk's chip: what it says where the source cannot be had."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from stator.emulator import machine
from stator.emulator.qemu import NoEmulator

if TYPE_CHECKING:
    from pathlib import Path


@pytest.fixture(autouse=True)
def empty_cache(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Path:
    monkeypatch.setattr(machine, "FOLDER", tmp_path / "emulator")
    return tmp_path / "emulator"


def test_a_missing_source_is_named(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("STATOR_QEMU_SOURCE", str(tmp_path / "none.tar.xz"))
    with pytest.raises(NoEmulator) as failed:
        machine.chip_emulator()
    assert "error: cannot get the source of QEMU 10.0.2: there is no file" in str(failed.value)
    assert "hint: it is the file qemu_10.0.2+ds.orig.tar.xz" in str(failed.value)


def test_another_source_is_refused(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path, empty_cache: Path
) -> None:
    source = tmp_path / "some.tar.xz"
    source.write_bytes(b"something else")
    monkeypatch.setenv("STATOR_QEMU_SOURCE", str(source))
    with pytest.raises(NoEmulator, match=f"expected SHA-256 {machine.SHA256}, found"):
        machine.chip_emulator()
    assert not (empty_cache / "source").exists()


def test_an_unknown_version_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("STATOR_QEMU_SOURCE", raising=False)
    monkeypatch.setattr(machine, "PACKAGE_VERSION", "1:0.0")
    with pytest.raises(NoEmulator, match=r"expected version 1:0\.0\* among apt's packages"):
        machine.chip_emulator()


def test_what_is_built_is_found_again(empty_cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    built: list[Path] = []

    def build(program: Path, _: object) -> None:
        built.append(program)
        program.parent.mkdir(parents=True)
        program.touch()

    monkeypatch.setattr(machine, "_build", build)
    first, second = machine.chip_emulator(), machine.chip_emulator()
    assert first == second
    assert built == [empty_cache / built[0].parent.name / "qemu-system-arm"]
