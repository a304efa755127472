"""Paths for the socket of a link: given ones, and the default ones."""

from __future__ import annotations

import contextlib
import fcntl
import socket
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from stator import HOME
from stator.diagnostics import UserError

if TYPE_CHECKING:
    from collections.abc import Iterator

DEFAULT = HOME / "build" / "link"
MAX_SOCKET_PATH = 100  # bytes; the system takes 107


def socket_place(path: Path) -> Path:
    """The path, if a socket can be made there. Raises `UserError` if not."""
    place = path.resolve()
    if len(str(place).encode()) > MAX_SOCKET_PATH or "," in str(place):
        raise UserError(
            f"error: expected a path of at most {MAX_SOCKET_PATH} bytes without a comma, found "
            f"'{place}'\nhint: use a shorter path, for example --link /tmp/link"
        )
    if place.exists() and not place.is_socket():
        raise UserError(
            f"error: expected a socket, found another file '{place}'\nhint: use another path"
        )
    if is_served(place):
        raise UserError(
            f"error: another run uses '{place}'\n"
            f"hint: use another path, for example --link {place}2"
        )
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise UserError(f"error: cannot make a link at '{place}': {error.strerror}") from None
    return place


@contextlib.contextmanager
def free_place() -> Iterator[Path | None]:
    """The first default path that no other run uses, reserved until the end, even while there is
    no socket. None if the path of the checkout is too long for a socket."""
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


@contextlib.contextmanager
def with_graph(link: Path | None, graph: Path) -> Iterator[None]:
    """Leaves the graph's path beside the socket while it is served, for those who look."""
    if link is None:
        yield
        return
    note = _note(link)
    note.write_text(f"{graph.resolve()}\n", encoding="utf-8")
    try:
        yield
    finally:
        note.unlink(missing_ok=True)


def graph_of(link: Path) -> Path | None:
    """The graph that runs there, if the link says so. A serial port does not."""
    try:
        text = _note(link.resolve()).read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None
    return Path(text.removesuffix("\n"))


def _note(link: Path) -> Path:
    return link.with_name(f"{link.name}.graph")


def served_places() -> list[Path]:
    """The default paths that a run uses."""
    places = sorted(DEFAULT.parent.glob(f"{DEFAULT.name}*"))
    return [place for place in places if place.is_socket() and is_served(place)]


def is_served(path: Path) -> bool:
    """Whether a run listens there: a socket that an ended run left refuses."""
    with socket.socket(socket.AF_UNIX) as probe:
        probe.setblocking(False)
        try:
            probe.connect(str(path))
        except BlockingIOError:  # it listens, and its queue is full
            return True
        except OSError:
            return False
    return True
