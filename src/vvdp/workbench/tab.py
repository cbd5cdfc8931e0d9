"""One open page: of what it asks for, only the newest is calculated, in a thread of its own."""

import asyncio
import threading
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from starlette.websockets import WebSocket, WebSocketDisconnect

from vvdp.base.errors import ConfigError, Fault, VvdpError
from vvdp.results.store import finite
from vvdp.runs.run import RecordedRun
from vvdp.simulation.run import Run
from vvdp.workbench.offer import Asked, Offer
from vvdp.workbench.packet import packet
from vvdp.workbench.work import (
    View,
    added_series,
    command_line,
    draft,
    faults_of,
    figures,
    numbers,
    text_drawing,
    whole,
)

LONGEST_MESSAGE = 1_200_000
LOOKS = 0.5
"""Time between two looks at the file on disk [s]."""


def asked_by(message: Any) -> Asked:
    """Request in a message. Raises ConfigError if it does not have the form."""
    found = message if isinstance(message, Mapping) else {}
    settings = found.get("set", [])
    texts = [found.get("system"), *(settings if isinstance(settings, list) else [None])]
    texts += [found[key] for key in ("text", "until") if found.get(key) is not None]
    if not all(isinstance(each, str) for each in texts):
        raise ConfigError([Fault("request", 0, "", 'expected {"system": NAME, "set": ["table.key=value"]}')])
    return Asked(str(found["system"]), found.get("text"), tuple(settings), found.get("until"))


class Tab:
    """Last request of a page, its last whole run, and its last draft, from which the next one goes on."""

    def __init__(self, offer: Offer) -> None:
        self._offer = offer
        self._newest: Mapping[str, object] = {}
        self._waiting = asyncio.Event()
        self._superseded = threading.Event()
        self._last: tuple[str, Run] | None = None
        self._whole: RecordedRun | None = None

    async def serve(self, socket: WebSocket) -> None:
        """Answers one page until it is closed."""
        await socket.accept()
        tasks = [
            asyncio.create_task(each)
            for each in (self._work(socket), watch(self._offer, lambda: str(self._newest.get("system", "")), socket))
        ]
        try:
            while True:
                message = await socket.receive_json()
                if isinstance(message, Mapping):
                    self._superseded.set()
                    if message.get("kind") != "stop":
                        self._newest = message
                        self._waiting.set()
        except (WebSocketDisconnect, ValueError, KeyError):
            pass
        finally:
            self._superseded.set()
            for task in tasks:
                task.cancel()

    async def _work(self, socket: WebSocket) -> None:
        while True:
            await self._waiting.wait()
            self._waiting.clear()
            self._superseded.clear()
            message = self._newest
            answers = self._answers(message, self._speaker(socket, message.get("n")))
            while (answer := await asyncio.to_thread(next, answers, None)) is not None:
                await socket.send_bytes(answer)

    def _speaker(self, socket: WebSocket, number: Any) -> Callable[[str], None]:
        """Sends words on the way, such as how long compiling takes, from any thread."""
        loop = asyncio.get_running_loop()

        def say(words: str) -> None:
            asyncio.run_coroutine_threadsafe(
                socket.send_bytes(packet({"kind": "words", "n": number, "words": words})), loop
            )

        return say

    def _answers(self, message: Mapping[str, object], say: Callable[[str], None]) -> Iterator[bytes]:
        """The packets that answer one message; each begins with its number, so that a page knows which one it was."""
        kind = message.get("kind")
        number = message.get("n")
        try:
            asked, view = asked_by(message), _view(message)
            if kind == "series":
                if self._whole is not None:
                    yield added_series(self._whole, view, number)
                return
            if kind == "draw":
                yield packet({**text_drawing(self._offer, asked), "n": number})
                return
            system = self._offer.system(asked)
            if kind == "draft":
                yield self._draft(system, view, number, say)
                return
            self._whole = whole(system, self._superseded.is_set, say)
            yield figures(self._whole, view, number)
            yield packet({"kind": "numbers", "n": number, "line": command_line(asked), **numbers(self._whole)})
        except VvdpError as problem:
            yield packet({"kind": "faults", "n": number, "faults": finite(faults_of(problem))})
        except KeyboardInterrupt:  # stopped before its first step
            return
        except Exception as problem:  # else the page would wait indefinitely
            told = VvdpError(f"a mistake of vvdp: {type(problem).__name__}: {problem}")
            yield packet({"kind": "faults", "n": number, "faults": finite(faults_of(told))})

    def _draft(self, system: Any, view: View, number: Any, say: Callable[[str], None]) -> bytes:
        """A draft that goes on from the last one, if that had the same circuit."""
        before = self._last[1] if self._last is not None and self._last[0] == system.circuit.digest else None
        done, found = draft(system, before, view, number, say)
        self._last = system.circuit.digest, done
        return found


async def watch(offer: Offer, shown: Callable[[], str], socket: WebSocket) -> None:
    """Shows a page the text of the file that is `shown`, and again when it changes on disk; none where it is gone."""
    name, before = "", None
    while True:
        await asyncio.sleep(LOOKS)
        asked = shown()
        text = await asyncio.to_thread(offer.text_on_disk, asked)
        if text != before if asked == name else text is not None:
            await socket.send_bytes(packet({"kind": "disk", "system": asked, "text": text}))
        name, before = asked, text


def _view(message: Mapping[str, object]) -> View:
    """Charts and series that the page shows."""
    charts, series = message.get("charts"), message.get("series")
    return View(
        frozenset(map(str, charts)) if isinstance(charts, list) else None,
        message.get("moves") is True,
        tuple(map(str, series)) if isinstance(series, list) else (),
    )
