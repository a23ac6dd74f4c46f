"""The studio's pages: one page, its files, one live line for each tab."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from importlib import resources
from pathlib import Path

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from planter.studio.guard import Guard
from planter.studio.live import Live

FILES = {
    "": ("planter.studio", "studio.html", "text/html"),
    "studio.js": ("planter.studio", "studio.js", "text/javascript"),
    "line.js": ("planter.studio", "line.js", "text/javascript"),
    "studio.css": ("planter.studio", "studio.css", "text/css"),
    "view.js": ("planter.view", "view.js", "text/javascript"),
    "view.css": ("planter.view", "view.css", "text/css"),
}
"""What a page fetches, below its token."""


def application(folder: Path, token: str, port: int) -> Guard:
    """The studio of a folder for whoever knows the token, at a port of this machine."""

    async def live(socket: WebSocket) -> None:
        await Live(socket, folder).run()

    files = [Route(f"/{{token}}/{name}", _file(*place)) for name, place in FILES.items()]
    return Guard(Starlette(routes=[*files, WebSocketRoute("/{token}/live", live)]), token, port)


def _file(package: str, name: str, kind: str) -> Callable[[Request], Awaitable[Response]]:
    async def sent(request: Request) -> Response:
        return Response(resources.files(package).joinpath(name).read_text(encoding="utf-8"), media_type=kind)

    return sent
