"""`./stator view`: a page in the browser that shows what runs, or a log."""

from __future__ import annotations

import argparse
import asyncio
import contextlib
import signal
import sys
from typing import TYPE_CHECKING

from stator.arguments import path
from stator.live.arguments import add_link_arguments
from stator.live.link import Link

if TYPE_CHECKING:
    from collections.abc import Callable

    from stator.view.source import LiveSource, LogSource

USUAL_PORT = 8765  # Foxglove's own default
MAX_PORT = 65535


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "log", nargs="?", type=path, help="ULog file to look at (default: the running vehicle)"
    )
    parser.add_argument(
        "--port", type=_port, default=USUAL_PORT, help=f"port of the page (default: {USUAL_PORT})"
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to listen on (default: 127.0.0.1, which only this machine reaches)",
    )
    add_link_arguments(parser, has_json=False)


def main(arguments: argparse.Namespace) -> int:
    from stator.view.source import LiveSource, LogSource

    if arguments.log is not None:
        asyncio.run(_serve(LogSource(arguments.log, arguments.graph), arguments))
        return 0
    with Link(arguments.link) as link:
        asyncio.run(_serve(LiveSource(link, arguments.graph), arguments))
    return 0


async def _serve(source: LiveSource | LogSource, arguments: argparse.Namespace) -> None:
    """Until Ctrl-C, the usual end of this command, or until the vehicle is gone."""
    from stator.view.server import LOCAL, Hub, start
    from stator.view.source import LiveSource

    hub = Hub(source, {*LOCAL, arguments.host})
    server = await start(hub, arguments.host, arguments.port)
    loop, asked = asyncio.get_running_loop(), asyncio.Event()
    for number in (signal.SIGINT, signal.SIGTERM):
        loop.add_signal_handler(number, asked.set)
    place = f"{arguments.host}:{next(iter(server.sockets)).getsockname()[1]}"
    print(f"http://{place}/ shows it in a browser, ws://{place} in Foxglove; Ctrl-C ends this")
    sys.stdout.flush()
    ends: list[asyncio.Future[object]] = [asyncio.ensure_future(asked.wait())]
    if isinstance(source, LiveSource):
        looking = asyncio.to_thread(
            source.run,
            lambda topic, sample: _call(loop, hub.spread, topic, sample),
            lambda state: _call(loop, hub.spread_state, state),
        )
        ends.append(asyncio.ensure_future(looking))
    try:
        done, _ = await asyncio.wait(ends, return_when=asyncio.FIRST_COMPLETED)
        for end in done:
            end.result()  # that the vehicle is gone
    finally:
        if isinstance(source, LiveSource):
            source.end()
        server.close()
        await server.wait_closed()


def _call(loop: asyncio.AbstractEventLoop, function: Callable[..., None], *words: object) -> None:
    """From another thread; at the end of the command there is nothing left to call."""
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(function, *words)


def _port(text: str) -> int:
    if text.isascii() and text.isdigit() and int(text) <= MAX_PORT:
        return int(text)
    raise argparse.ArgumentTypeError(f"expected a port from 0 to {MAX_PORT}, found '{text}'")
