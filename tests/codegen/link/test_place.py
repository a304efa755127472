"""The usual places of links, where several runs are at once."""

from __future__ import annotations

import socket
from typing import TYPE_CHECKING

import pytest

from stator.live import place as link_place
from stator.live.link import Link, NoLink
from stator.live.place import free_place

if TYPE_CHECKING:
    from pathlib import Path


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


def test_what_runs_elsewhere_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As after the first of two runs has ended; not what a killed one has left behind."""
    monkeypatch.setattr(link_place, "DEFAULT", tmp_path / "link")
    with socket.socket(socket.AF_UNIX) as running, socket.socket(socket.AF_UNIX) as left:
        running.bind(str(tmp_path / "link2"))
        running.listen()
        left.bind(str(tmp_path / "link3"))
        with pytest.raises(NoLink) as failed:
            Link(tmp_path / "link")
    assert str(failed.value).splitlines()[1:] == [
        f"hint: running here: --link {tmp_path / 'link2'}"
    ]


def test_a_place_that_is_too_deep_is_none(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(link_place, "DEFAULT", tmp_path / ("deep" * 30) / "link")
    with free_place() as place:
        assert place is None
