"""Access control of the studio: only pages of this computer with its token, and no page of another host."""

from __future__ import annotations

import secrets

from starlette.types import ASGIApp, Receive, Scope, Send

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' data:; "
    "base-uri 'none'; form-action 'none'"
)
HEADERS = (
    (b"content-security-policy", POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cache-control", b"no-store"),
)


def token() -> str:
    """Return a new random token."""
    return secrets.token_urlsafe(24)


class Guard:
    """Middleware that passes requests with valid host, origin and token, and refuses all others with status 403."""

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self.app, self.token = app, token
        self.hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "lifespan":
            await self.app(scope, receive, send)
        elif not self._allowed(scope):
            await _refused(scope, send)
        else:
            await self.app(scope, receive, _with_headers(send))

    def _allowed(self, scope: Scope) -> bool:
        headers = {name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]}
        origin = headers.get("origin")
        if headers.get("host") not in self.hosts:
            return False
        if origin is not None and origin.removeprefix("http://") not in self.hosts:
            return False
        if scope["type"] == "websocket" and origin is None:
            return False
        return secrets.compare_digest(_token(scope).encode("utf-8", "replace"), self.token.encode())


def _token(scope: Scope) -> str:
    """Return the token, which is the first part of the path: addresses are /TOKEN/..."""
    path: str = scope["path"]
    return path.split("/")[1] if path.count("/") > 1 else ""


async def _refused(scope: Scope, send: Send) -> None:
    if scope["type"] == "websocket":
        await send({"type": "websocket.close", "code": 4403})
        return
    await send({"type": "http.response.start", "status": 403, "headers": [(b"content-type", b"text/plain")]})
    await send({"type": "http.response.body", "body": b"not allowed"})


def _with_headers(send: Send) -> Send:
    async def sent(message: dict[str, object]) -> None:
        if message["type"] == "http.response.start":
            headers: list[tuple[bytes, bytes]] = list(message.get("headers", ()))  # type: ignore[call-overload]
            names = {name.lower() for name, _ in headers}
            message["headers"] = [*headers, *(pair for pair in HEADERS if pair[0] not in names)]
        await send(message)

    return sent  # type: ignore[return-value]
