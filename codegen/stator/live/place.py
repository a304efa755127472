"""Places for the socket of a link: those that one asks for, and the usual ones."""

from __future__ import annotations

import contextlib
import fcntl
import socket
from itertools import count
from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import UserError

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

DEFAULT = HOME / "build" / "link"
MAX_SOCKET_PATH = 100  # bytes; the system takes 107


def socket_place(path: Path) -> Path:
    """Where a socket can be made. Raises `UserError` where it cannot."""
    place = path.resolve()
    if len(str(place).encode()) > MAX_SOCKET_PATH or "," in str(place):
        raise UserError(
            f"error: '{place}' is too long for a socket, or has a comma\n"
            "hint: name a shorter one: --link /tmp/link"
        )
    if place.exists() and not place.is_socket():
        raise UserError(f"error: '{place}' exists, and is no socket\nhint: name another one")
    if is_served(place):
        raise UserError(
            f"error: '{place}' is the link of something else that runs\n"
            f"hint: name another one: --link {place}2"
        )
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"error: no link at '{place}': {error.strerror}") from None
    return place


@contextlib.contextmanager
def free_place() -> Iterator[Path | None]:
    """The usual place; of several runs at once, the first one that is free. Nobody else gets it
    before this one has ended, also while there is no socket. None if Stator lies too deep for
    one."""
    for number in count(1):
        place = DEFAULT.with_name(f"{DEFAULT.name}{number if number > 1 else ''}")
        if len(str(place).encode()) > MAX_SOCKET_PATH:
            yield None
            return
        with place.with_name(f"{place.name}.lock").open("w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                continue
            if not is_served(place):
                yield place
                return


def served_places() -> list[Path]:
    """Those of the usual places where something runs."""
    places = sorted(DEFAULT.parent.glob(f"{DEFAULT.name}*"))
    return [place for place in places if place.is_socket() and is_served(place)]


def is_served(path: Path) -> bool:
    """Whether somebody listens there: a socket that was left behind refuses."""
    with socket.socket(socket.AF_UNIX) as probe:
        probe.setblocking(False)
        try:
            probe.connect(str(path))
        except BlockingIOError:  # many wait there already
            return True
        except OSError:
            return False
    return True
