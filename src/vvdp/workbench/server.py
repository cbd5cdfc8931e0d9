"""The server of the workbench: one page, its parts, and what it asks for. It listens on 127.0.0.1 only."""

import asyncio
import json
import socket
from importlib import resources
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.websockets import WebSocket

from vvdp.base.errors import ConfigError, Fault, VvdpError
from vvdp.report.interactive import MOTION, SCRIPTS, STYLES, asset
from vvdp.results.store import finite
from vvdp.runs.simulate import json_summary, run_system
from vvdp.workbench.guard import Guard, Guarded
from vvdp.workbench.measured import channels, measured_channel
from vvdp.workbench.offer import Offer
from vvdp.workbench.packet import packet
from vvdp.workbench.palette import palette
from vvdp.workbench.tab import LONGEST_MESSAGE, Tab, asked_by
from vvdp.workbench.work import faults_of, text_drawing

HOST = "127.0.0.1"
OWN_SCRIPTS = ("circuit-motion.js", "schematic.js", "teach.js", "measured.js", "series.js", "build.js", "workbench.js")
"""In the order in which they are needed; the last one begins."""


def own_asset(name: str) -> str:
    """The text of a part of the page."""
    return resources.files("vvdp.workbench").joinpath("assets", name).read_text("utf-8")


def _page() -> dict[str, tuple[str, str]]:
    """Path, text and type of the three files that make the page."""
    scripts = "".join(f"{text}\n" for text in (*map(asset, (*SCRIPTS, MOTION)), *map(own_asset, OWN_SCRIPTS)))
    return {
        "/": (own_asset("page.html"), "text/html"),
        "/workbench.js": (scripts, "text/javascript"),
        "/workbench.css": ("".join(map(asset, STYLES)) + own_asset("workbench.css"), "text/css"),
    }


def application(offer: Offer, guard: Guard) -> Guarded:
    """The workbench as an ASGI application."""

    def answer(text: str, kind: str) -> Any:
        async def respond(request: Request) -> Response:
            return Response(text, media_type=kind)

        return respond

    async def systems(request: Request) -> Response:
        found = await asyncio.to_thread(offer.names)
        listed = [{"name": name, "title": title} for name, title in found.items()]
        return JSONResponse({"systems": listed, "first": offer.first, "logs": offer.logs()})

    async def parts(request: Request) -> Response:
        return JSONResponse({"types": await asyncio.to_thread(palette)})

    def text(message: Any) -> dict[str, Any]:
        name = asked_by(message).system
        return {"text": offer.text(name), "saves": offer.path(name) is not None}

    def save(message: Any) -> dict[str, Any]:
        asked, before = asked_by(message), message.get("before")
        offer.save(asked.system, asked.text or "", before if isinstance(before, str) else "")
        return {"saved": asked.system}

    def run(message: Any) -> dict[str, Any]:
        return json_summary(run_system(offer.system(asked_by(message))))

    def draw(message: Any) -> dict[str, Any]:
        return {"svg": text_drawing(offer, asked_by({"system": offer.first, **message}))["svg"]}

    def log(message: Any) -> dict[str, Any]:
        return channels(offer.log(_word(message, "log")))

    def channel(message: Any) -> bytes:
        path, name = offer.log(_word(message, "log")), _word(message, "channel")
        return packet({"kind": "channel"}, channel=measured_channel(path, name, _word(message, "unit") or None))

    async def drafts(page: WebSocket) -> None:
        await Tab(offer).serve(page)

    posts: dict[str, Any] = {"/api/run": run, "/api/draw": draw, "/api/text": text, "/api/save": save}
    posts |= {"/api/log": log, "/api/channel": channel}
    routes: list[BaseRoute] = [Route(path, answer(*each)) for path, each in _page().items()]
    routes += [Route("/api/systems", systems), Route("/api/palette", parts), WebSocketRoute("/ws", drafts)]
    routes += [Route(path, _post(act), methods=["POST"]) for path, act in posts.items()]
    return Guarded(Starlette(routes=routes), guard)


def _post(act: Any) -> Any:
    """Answers a JSON object with what `act` makes of it, or with 422 and the faults."""

    async def respond(request: Request) -> Response:
        try:
            message = json.loads(await _body(request))
            if not isinstance(message, dict):
                raise ValueError
            found = await asyncio.to_thread(act, message)
            if isinstance(found, bytes):
                return Response(found, media_type="application/octet-stream")
            return JSONResponse(finite(found))
        except VvdpError as problem:
            return JSONResponse({"faults": faults_of(problem)}, 422)
        except (ValueError, RecursionError):
            return JSONResponse({"faults": faults_of(ConfigError([Fault("request", 0, "", "expected JSON")]))}, 422)

    return respond


def _word(message: dict[str, Any], key: str) -> str:
    """A text of a message; empty where it has none."""
    found = message.get(key)
    return found if isinstance(found, str) else ""


async def _body(request: Request) -> bytes:
    """The body of a request. Raises ConfigError where it is too long."""
    found = bytearray()
    async for part in request.stream():
        found += part
        if len(found) > LONGEST_MESSAGE:
            raise ConfigError([Fault("request", 0, "", f"is longer than {LONGEST_MESSAGE} bytes")])
    return bytes(found)


def listening(port: int) -> socket.socket:
    """A socket on this machine's own address; port 0 takes a free one. Raises OSError where the port is taken."""
    found = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    found.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    found.bind((HOST, port))
    found.listen()  # who receives the address at once may connect before the server runs
    return found


def serve(offer: Offer, guard: Guard, place: socket.socket) -> None:
    """Serves until Ctrl-C."""
    config = uvicorn.Config(
        application(offer, guard),
        log_level="error",
        access_log=False,
        ws_max_size=LONGEST_MESSAGE,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=1,
        server_header=False,
    )
    uvicorn.Server(config).run(sockets=[place])
