"""Who may speak with the server: pages that it has served itself, on this machine, with its token."""

import hmac
import secrets
from dataclasses import dataclass, field
from http.cookies import CookieError, SimpleCookie
from urllib.parse import parse_qs

from starlette.datastructures import Headers
from starlette.responses import PlainTextResponse, RedirectResponse, Response
from starlette.types import ASGIApp, Message, Receive, Scope, Send

COOKIE = "vvdp_workbench"
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self' 'unsafe-inline'; connect-src 'self'; img-src data:; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
}


@dataclass(frozen=True)
class Guard:
    """The token of this server and the port that it listens on."""

    port: int
    token: str = field(default_factory=lambda: secrets.token_urlsafe(24))

    @property
    def url(self) -> str:
        """The address to open; the token in it becomes a cookie."""
        return f"http://127.0.0.1:{self.port}/?token={self.token}"

    def refusal(self, scope: Scope) -> Response | None:
        """Why a request is not answered; None where it is."""
        headers = Headers(scope=scope)
        hosts = {f"127.0.0.1:{self.port}", f"localhost:{self.port}"}
        origin = headers.get("origin")
        foreign = headers.get("host") not in hosts or headers.get("sec-fetch-site", "none") == "cross-site"
        if foreign or (origin is not None and origin.removeprefix("http://") not in hosts):
            return PlainTextResponse("foreign host or origin", 403)
        if scope["type"] == "websocket" and origin is None:
            return PlainTextResponse("no origin", 403)
        if self._knows(headers.get("authorization", "").removeprefix("Bearer ")) or self._knows(_cookie(headers)):
            return None
        if scope["type"] == "http" and scope["path"] == "/" and self._knows(_asked_token(scope)):
            found = RedirectResponse("/", 303)
            found.set_cookie(f"{COOKIE}_{self.port}", self.token, httponly=True, samesite="strict")
            return found
        return PlainTextResponse("token missing: open the address that `vvdp workbench` prints", 401)

    def _knows(self, token: str) -> bool:
        return hmac.compare_digest(token.encode(), self.token.encode())


class Guarded:
    """An application behind a guard; every answer has the headers that keep a page from running anything foreign."""

    def __init__(self, app: ASGIApp, guard: Guard) -> None:
        self._app, self._guard = app, guard

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answers one request or web socket."""

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                message["headers"] += [(key.lower().encode(), text.encode()) for key, text in HEADERS.items()]
            await send(message)

        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
        elif (refusal := self._guard.refusal(scope)) is None:
            await self._app(scope, receive, with_headers)
        elif scope["type"] == "websocket":
            await receive()
            await send({"type": "websocket.close", "code": 1008})
        else:
            await refusal(scope, receive, with_headers)


def _cookie(headers: Headers) -> str:
    try:
        found = SimpleCookie(headers.get("cookie", ""))
    except CookieError:
        return ""
    port = headers.get("host", "").rpartition(":")[2]
    name = f"{COOKIE}_{port}"
    return str(found[name].value) if name in found else ""


def _asked_token(scope: Scope) -> str:
    found: str = parse_qs(scope["query_string"].decode("latin-1")).get("token", [""])[0]
    return found
