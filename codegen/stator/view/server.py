"""The page, and the Foxglove WebSocket protocol on the same port.

Viewers only read. A viewer that stops reading loses its oldest samples, and costs no one else
anything: the vehicle is asked by one thread, at most a hundred times a second.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import math
import struct
import time
from collections import deque
from pathlib import Path
from typing import TYPE_CHECKING, Any

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from stator.charts.graph import View, rendered
from stator.diagnostics import UserError
from stator.params.table import table_of
from stator.version import VERSION
from stator.view.source import PAST_S, LiveSource, LogSource, Sample, State

if TYPE_CHECKING:
    from collections.abc import Iterable

PROTOCOLS = ("foxglove.websocket.v1", "foxglove.sdk.v1")
PAGE = Path(__file__).parent / "page"
TYPES = {".html": "text/html", ".js": "text/javascript", ".css": "text/css"}
LOCAL = ("127.0.0.1", "localhost", "[::1]")
MOST_VIEWERS = 32
MOST_WAITING = 512  # messages to a viewer
MOST_REQUEST_BYTES = 65_536
STATE = "stator/state"  # a channel of JSON
DATA = 1
ERROR = 2
PLAY_S = 0.05  # of a log, between two messages
STATE_EVERY_S = 0.5
FASTEST = 100.0
# Nothing is loaded from elsewhere.
POLICY = "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; connect-src "
POLICY += "'self' ws: wss:; img-src 'self' data:; frame-ancestors 'none'; base-uri 'none'"


class Viewer:
    """One connection: what it subscribes to, and what waits for it."""

    def __init__(self, connection: ServerConnection) -> None:
        self.connection = connection
        self.topics: dict[int, str] = {}  # by number of the subscription
        self._waiting: deque[str | bytes] = deque(maxlen=MOST_WAITING)
        self._has_more = asyncio.Event()

    def send(self, message: str | bytes) -> None:
        self._waiting.append(message)
        self._has_more.set()

    def send_sample(self, topic: str, sample: Sample) -> None:
        time_us, data = sample
        for number, name in self.topics.items():
            if name == topic:
                self.send(struct.pack("<BIQ", DATA, number, time_us * 1000) + data)

    async def write(self) -> None:
        """Until the viewer is gone."""
        while True:
            await self._has_more.wait()
            self._has_more.clear()
            while self._waiting:
                await self.connection.send(self._waiting.popleft())


class Hub:
    """What is the same for all viewers."""

    def __init__(self, source: LiveSource | LogSource, hosts: Iterable[str]) -> None:
        self.source = source
        self.viewers: set[Viewer] = set()
        self._hosts = frozenset(hosts)
        self._jobs: set[asyncio.Task[None]] = set()
        self._topics = [channel.topic for channel in source.channels]
        self._scene = json.dumps(_scene(source)).encode()

    # --- HTTP ---

    def answer(self, connection: ServerConnection, request: Request) -> Response | None:
        """A file of the page; None for a WebSocket. A page of another origin gets nothing, and
        neither does one whose name was made to lead here."""
        host = request.headers.get("Host", "")
        origin = request.headers.get("Origin")
        if not self._is_ours(host) or (origin is not None and not self._is_origin(origin, host)):
            return _response(403, b"this page may not look here\n", "text/plain")
        if request.headers.get("Upgrade", "").lower() == "websocket":
            if len(self.viewers) >= MOST_VIEWERS:
                return _response(503, b"too many viewers\n", "text/plain")
            return None
        path = request.path.partition("?")[0]
        if path == "/scene.json":
            return _response(200, self._scene, "application/json")
        name = "index.html" if path == "/" else path[1:]
        files = {file.name: file for file in PAGE.iterdir() if file.suffix in TYPES}
        if name not in files:
            return _response(404, b"not found\n", "text/plain")
        return _response(200, files[name].read_bytes(), TYPES[files[name].suffix])

    def _is_ours(self, host: str) -> bool:
        return host.rpartition(":")[0] in self._hosts or host in self._hosts

    def _is_origin(self, origin: str, host: str) -> bool:
        return origin in (f"http://{host}", f"https://{host}")

    # --- WebSocket ---

    async def serve(self, connection: ServerConnection) -> None:
        viewer = Viewer(connection)
        self.viewers.add(viewer)
        jobs = [asyncio.create_task(viewer.write())]
        player = _Player(self.source, viewer) if isinstance(self.source, LogSource) else None
        if player is not None:
            jobs.append(asyncio.create_task(player.run()))
        try:
            self._greet(viewer)
            async for message in connection:
                self._hear(viewer, message, player)
        except ConnectionClosed:
            pass
        finally:
            self.viewers.discard(viewer)
            self._tell_wanted()
            for job in jobs:
                job.cancel()
                with contextlib.suppress(asyncio.CancelledError, ConnectionClosed):
                    await job

    def _greet(self, viewer: Viewer) -> None:
        graph = self.source.plan.graph.name
        info = {
            "op": "serverInfo",
            "name": f"stator {VERSION}: {graph}",
            "capabilities": ["parameters", "connectionGraph"],
            "supportedEncodings": ["cdr", "json"],
            "metadata": {"graph": graph},
        }
        viewer.send(json.dumps(info))
        channels = [
            {
                "id": i,
                "topic": f"/{channel.topic}",
                "encoding": "cdr",
                "schemaName": channel.schema,
                "schema": channel.definition,
                "schemaEncoding": "ros2msg",
            }
            for i, channel in enumerate(self.source.channels)
        ]
        channels.append(
            {
                "id": len(channels),
                "topic": f"/{STATE}",
                "encoding": "json",
                "schemaName": "stator.State",
                "schema": '{"type": "object"}',
                "schemaEncoding": "jsonschema",
            }
        )
        viewer.send(json.dumps({"op": "advertise", "channels": channels}))

    def _hear(self, viewer: Viewer, message: str | bytes, player: _Player | None) -> None:
        """What a viewer sends is checked as what a stranger sends."""
        try:
            request = json.loads(message)
            self._do(viewer, request["op"], request, player)
        except (ValueError, KeyError, TypeError, IndexError, AttributeError, RecursionError):
            _complain(viewer, "unknown request")

    def _do(self, viewer: Viewer, op: str, request: dict[str, Any], player: _Player | None) -> None:
        names = [*self._topics, STATE]
        if op == "subscribe":
            for item in request["subscriptions"][: len(names)]:
                number, channel = item["id"], item["channelId"]
                if not (type(number) is int and 0 <= number < 2**32 and type(channel) is int):
                    raise ValueError(number)
                if len(viewer.topics) < 2 * len(names) and channel >= 0:
                    viewer.topics[number] = names[channel]
                    if player is not None:
                        player.begin(names[channel])
            self._tell_wanted()
        elif op == "unsubscribe":
            for number in request["subscriptionIds"]:
                viewer.topics.pop(number, None)
            self._tell_wanted()
        elif op == "getParameters":
            wanted = {str(name) for name in request.get("parameterNames", [])}
            job = asyncio.create_task(self._parameters(viewer, request, wanted))
            self._jobs.add(job)  # a task that nothing refers to may be lost
            job.add_done_callback(self._jobs.discard)
        elif op == "setParameters":
            _complain(viewer, "parameters are read-only here; use ./stator param set")
        elif op == "subscribeConnectionGraph":
            viewer.send(json.dumps(self._connections()))
        elif op == "statorSeek" and player is not None:
            player.seek(float(request["time"]), float(request["speed"]))
        elif op not in ("unsubscribeConnectionGraph", "unsubscribeParameterUpdates"):
            _complain(viewer, f"unknown request '{str(op)[:40]}'")

    async def _parameters(self, viewer: Viewer, request: dict[str, Any], wanted: set[str]) -> None:
        try:
            values = await asyncio.to_thread(self.source.parameters)
        except UserError as error:
            _complain(viewer, str(error))
            return
        names = {row.id: row.name for row in table_of(self.source.plan.graph)}
        rows = [
            {"name": names[key], "value": _plain(value)}
            for key, value in values.items()
            if not wanted or names[key] in wanted
        ]
        viewer.send(
            json.dumps({"op": "parameterValues", "parameters": rows, "id": request.get("id", "")})
        )

    def _connections(self) -> dict[str, Any]:
        topics = self.source.plan.topics.values()
        return {
            "op": "connectionGraphUpdate",
            "publishedTopics": [
                {"name": f"/{t.name}", "publisherIds": list(t.publishers)} for t in topics
            ],
            "subscribedTopics": [
                {"name": f"/{t.name}", "subscriberIds": [name for name, _ in t.readers]}
                for t in topics
            ],
            "advertisedServices": [],
            "removedTopics": [],
            "removedServices": [],
        }

    def _tell_wanted(self) -> None:
        if isinstance(self.source, LiveSource):
            wanted = {name for viewer in self.viewers for name in viewer.topics.values()}
            self.source.wanted = frozenset(wanted - {STATE})

    def spread(self, topic: str, sample: Sample) -> None:
        for viewer in self.viewers:
            viewer.send_sample(topic, sample)

    def spread_state(self, state: State) -> None:
        self.spread(STATE, _state_sample(state))


class _Player:
    """Plays a log for one viewer, from the time and at the speed that it asks for."""

    def __init__(self, source: LogSource, viewer: Viewer) -> None:
        self._source, self._viewer = source, viewer
        self._at_s, self._speed = source.begin_s, 1.0

    def begin(self, topic: str) -> None:
        """The newest samples of a topic, as far back as a plot goes."""
        if topic == STATE:
            self._viewer.send_sample(STATE, _state_sample(self._source.state(self._at_s)))
            return
        for sample in self._source.samples(topic, self._at_s - PAST_S, self._at_s):
            self._viewer.send_sample(topic, sample)

    def seek(self, at_s: float, speed: float) -> None:
        if not (math.isfinite(at_s) and 0.0 <= speed <= FASTEST):
            raise ValueError(speed)
        moved = abs(at_s - self._at_s) > 2 * PLAY_S * max(self._speed, 1.0)
        self._at_s = min(max(at_s, self._source.begin_s), self._source.end_s)
        self._speed = speed
        if moved:
            for topic in dict.fromkeys(self._viewer.topics.values()):
                self.begin(topic)

    async def run(self) -> None:
        before_s = time.monotonic()
        told_s = before_s
        while True:
            await asyncio.sleep(PLAY_S)
            now_s = time.monotonic()
            from_s, step_s = self._at_s, (now_s - before_s) * self._speed
            before_s = now_s
            if step_s == 0.0:
                continue
            self._at_s = min(from_s + step_s, self._source.end_s)
            for topic in dict.fromkeys(self._viewer.topics.values()):
                if topic != STATE:
                    for sample in self._source.samples(topic, from_s, self._at_s):
                        self._viewer.send_sample(topic, sample)
            if now_s - told_s >= STATE_EVERY_S:
                told_s = now_s
                self._viewer.send_sample(STATE, _state_sample(self._source.state(self._at_s)))


def _state_sample(state: State) -> Sample:
    return round(state["time_s"] * 1e6), json.dumps(state).encode()


def _plain(value: Any) -> Any:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _complain(viewer: Viewer, text: str) -> None:
    viewer.send(json.dumps({"op": "status", "level": ERROR, "message": text}))


def _response(status: int, body: bytes, kind: str) -> Response:
    words = {200: "OK", 403: "Forbidden", 404: "Not Found", 503: "Service Unavailable"}
    headers = Headers(
        {
            "Content-Type": f"{kind}; charset=utf-8",
            "Content-Length": str(len(body)),
            "Content-Security-Policy": POLICY,
            "X-Content-Type-Options": "nosniff",
            "Cache-Control": "no-store",
            "Connection": "close",
        }
    )
    return Response(status, words[status], headers, body)


def _scene(source: LiveSource | LogSource) -> dict[str, Any]:
    """What does not change while it runs."""
    plan = source.plan
    nodes = {
        name: {
            "level": next(t.level for t in plan.tasks if t.node.name == name),
            "budget_us": node.budget_us,
            "deadline_us": node.deadline_us,
            "outputs": [output.topic for output in node.outputs.values()],
            "doc": node.interface.doc,
        }
        for name, node in plan.graph.nodes.items()
    }
    known = {channel.topic for channel in source.channels}
    topics = {}
    for name, topic in plan.topics.items():
        ages = [
            port.max_age_us
            for reader, _ in topic.readers
            for port in plan.graph.nodes[reader].inputs.values()
            if port.topic == name and port.max_age_us is not None
        ]
        topics[name] = {
            "message": topic.message.name,
            "publishers": list(topic.publishers),
            "readers": [reader for reader, _ in topic.readers],
            "max_age_s": min(ages) / 1e6 if ages else None,
            "is_known": name in known,
            "fields": [
                {
                    "name": field.name,
                    "type": field.type,
                    "count": field.count,
                    "unit": field.unit,
                    "values": {str(number): word for word, number in field.values},
                    "doc": field.doc,
                }
                for field in topic.message.fields
                if not field.name.startswith("_padding")
            ],
        }
    params = {
        row.name: {
            "id": row.id,
            "unit": row.unit,
            "least": None if row.param.least is None else float(row.param.least),
            "most": None if row.param.most is None else float(row.param.most),
            "graph_value": _plain(row.default),
            "doc": row.param.doc,
        }
        for row in table_of(plan.graph)
    }
    is_log = isinstance(source, LogSource)
    return {
        "graph": plan.graph.name,
        "board": plan.board.name,
        "svg": {
            theme: rendered(plan, "svg", View(wakes=True, dark=theme == "dark")).decode()
            for theme in ("light", "dark")
        },
        "nodes": nodes,
        "topics": topics,
        "parameters": params,
        "log": {"begin_s": source.begin_s, "end_s": source.end_s, "lines": source.lines}
        if isinstance(source, LogSource)
        else None,
        "is_live": not is_log,
    }


async def start(hub: Hub, host: str, port: int) -> Server:
    """Serves until it is closed. Raises `UserError`."""
    try:
        return await serve(
            hub.serve,
            host,
            port,
            subprotocols=PROTOCOLS,  # type: ignore[arg-type]
            process_request=hub.answer,
            max_size=MOST_REQUEST_BYTES,
            write_limit=65_536,
            compression=None,
            ping_interval=20,
        )
    except OSError as error:
        raise UserError(
            f"error: cannot listen on {host}:{port}: {error.strerror or error}\n"
            "hint: name another port with --port"
        ) from None
