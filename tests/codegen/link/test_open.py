"""What is named as the place of what runs, and is none."""

from __future__ import annotations

from pathlib import Path

import pytest

from stator.live.link import Link, NoLink


def test_a_device_that_is_no_serial_port_is_refused() -> None:
    with pytest.raises(
        NoLink, match=r"^error: cannot connect to /dev/null: it is not a serial port\n"
    ):
        Link(Path("/dev/null"))


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(NoLink, match="No such file or directory"):
        Link(tmp_path / "nothing")


def test_a_path_that_no_socket_has_is_refused(tmp_path: Path) -> None:
    long = tmp_path / ("long" * 30)
    long.touch()
    with pytest.raises(NoLink, match="AF_UNIX path too long\n"):
        Link(long)
