"""The web server of the studio on this computer: a page and its files, a WebSocket for each tab,
access control.
"""

from __future__ import annotations

import secrets
import socket
import webbrowser
from collections.abc import Awaitable, Callable
from importlib import resources
from pathlib import Path
from urllib.parse import quote

import uvicorn
from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Receive, Scope, Send
from starlette.websockets import WebSocket

from planter.errors import InputError
from planter.report.subject import open_machine
from planter.studio.live import LONGEST_MESSAGE, Live
from planter.studio.process import find_export

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src 'self' "
    "data:; "
    "base-uri 'none'; form-action 'none'"
)
HEADERS = (
    (b"content-security-policy", POLICY.encode()),
    (b"x-content-type-options", b"nosniff"),
    (b"referrer-policy", b"no-referrer"),
    (b"cache-control", b"no-store"),
)


class Guard:
    """Middleware that passes requests with valid host, origin and token, and refuses all others
    with status 403.
    """

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
        headers = {
            name.decode("latin-1"): value.decode("latin-1") for name, value in scope["headers"]
        }
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
    await send(
        {
            "type": "http.response.start",
            "status": 403,
            "headers": [(b"content-type", b"text/plain")],
        }
    )
    await send({"type": "http.response.body", "body": b"not allowed"})


def _with_headers(send: Send) -> Send:
    async def sent(message: dict[str, object]) -> None:
        if message["type"] == "http.response.start":
            headers: list[tuple[bytes, bytes]] = list(message.get("headers", ()))  # type: ignore[call-overload]
            names = {name.lower() for name, _ in headers}
            message["headers"] = [*headers, *(pair for pair in HEADERS if pair[0] not in names)]
        await send(message)

    return sent  # type: ignore[return-value]


FILES = {
    "": ("planter.studio", "studio.html", "text/html"),
    "studio.js": ("planter.studio", "studio.js", "text/javascript"),
    "fields.js": ("planter.studio", "fields.js", "text/javascript"),
    "tables.js": ("planter.studio", "tables.js", "text/javascript"),
    "exports.js": ("planter.studio", "exports.js", "text/javascript"),
    "line.js": ("planter.studio", "line.js", "text/javascript"),
    "saved.js": ("planter.studio", "saved.js", "text/javascript"),
    "studio.css": ("planter.studio", "studio.css", "text/css"),
    "view.js": ("planter.report", "view.js", "text/javascript"),
    "view.css": ("planter.report", "view.css", "text/css"),
}
"""Files that a page loads, by name below its token."""
EXPORTED = {"content-security-policy": "sandbox allow-scripts allow-downloads"}
"""Policy of exported files, which cannot reach the studio or its address; a report has a stricter
one.
"""


def build_application(
    folder: Path, token: str, port: int, explicit: Path | None = None, first: Live | None = None
) -> Guard:
    """Return the studio of a folder and of the file that the user named, at a port, protected by a
    token; `first` serves the first page.
    """
    prepared = [] if first is None else [first]

    async def live(socket: WebSocket) -> None:
        await (prepared.pop() if prepared else Live(folder, explicit)).run(socket)

    async def exported(request: Request) -> Response:
        path = find_export(folder, request.path_params["path"])
        return FileResponse(path, headers=EXPORTED) if path else Response(status_code=404)

    files = [Route(f"/{{token}}/{name}", _file(*place)) for name, place in FILES.items()]
    return Guard(
        Starlette(
            routes=[
                *files,
                Route("/{token}/exports/{path:path}", exported),
                WebSocketRoute("/{token}/live", live),
            ]
        ),
        token,
        port,
    )


def _file(package: str, name: str, kind: str) -> Callable[[Request], Awaitable[Response]]:
    async def sent(request: Request) -> Response:
        return Response(
            resources.files(package).joinpath(name).read_text(encoding="utf-8"), media_type=kind
        )

    return sent


HOST = "127.0.0.1"


def serve_studio(machine: str | None, folder: Path, port: int, browser: bool) -> None:
    """Print the address and serve until interrupted.

    Raises InputError if the machine or folder does not exist.
    """
    explicit = None
    if machine is not None:
        explicit = Path(machine) if Path(machine).is_file() else None
        folder = explicit.parent if explicit else folder
    if not folder.is_dir():
        raise InputError(f"--folder {folder}: there is no such folder")
    name = Path(machine).name if machine else ""
    first = Live(folder, explicit, name)
    first.front.start()  # it works while this process reads the file and the browser starts
    if machine is not None:
        open_machine(machine)
    with socket.socket() as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((HOST, port))
            listening.listen()
        except OSError:
            raise InputError(
                f"--port {port}: another program uses this port; choose another"
            ) from None
        secret, port = secrets.token_urlsafe(24), listening.getsockname()[1]
        address = f"http://{HOST}:{port}/{secret}/{f'#{quote(name)}' if name else ''}"
        print(
            f"planter studio: {address}\nOnly this computer can reach it. Ctrl-C ends it.",
            flush=True,
        )
        if browser:
            webbrowser.open(address)
        config = uvicorn.Config(
            build_application(folder, secret, port, explicit, first),
            log_level="error",
            ws="websockets-sansio",
            ws_per_message_deflate=False,
            ws_max_size=4 * LONGEST_MESSAGE,
        )
        uvicorn.Server(config).run(sockets=[listening])
