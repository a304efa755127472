"""The usual places of links, where several runs are at once."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stator import link_place
from stator.link_place import free_place

if TYPE_CHECKING:
    from pathlib import Path

    import pytest


def test_runs_that_start_at_once_have_a_place_each(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before any of them has made its socket."""
    monkeypatch.setattr(link_place, "DEFAULT", tmp_path / "link")
    with free_place() as first:
        assert first == tmp_path / "link"
        with free_place() as second, free_place() as third:
            assert (second, third) == (tmp_path / "link2", tmp_path / "link3")
        with free_place() as second:
            assert second == tmp_path / "link2"
    with free_place() as first:
        assert first == tmp_path / "link"


def test_a_place_that_is_too_deep_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link_place, "DEFAULT", tmp_path / ("deep" * 30) / "link")
    with free_place() as place:
        assert place is None
