"""The web application of the studio: a page, its files, and one WebSocket connection for each tab."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from importlib import resources
from pathlib import Path

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket

from planter.studio.exports import find_export
from planter.studio.guard import Guard
from planter.studio.live import Live

FILES = {
    "": ("planter.studio", "studio.html", "text/html"),
    "studio.js": ("planter.studio", "studio.js", "text/javascript"),
    "exports.js": ("planter.studio", "exports.js", "text/javascript"),
    "line.js": ("planter.studio", "line.js", "text/javascript"),
    "studio.css": ("planter.studio", "studio.css", "text/css"),
    "view.js": ("planter.view", "view.js", "text/javascript"),
    "view.css": ("planter.view", "view.css", "text/css"),
}
"""Files that a page loads, by name below its token."""
EXPORTED = {"content-security-policy": "sandbox allow-scripts allow-downloads"}
"""Policy of exported files, which cannot reach the studio or its address; a report has a stricter one."""


def application(folder: Path, token: str, port: int, explicit: Path | None = None) -> Guard:
    """Return the studio of a folder and of the file that the user named, at a port, protected by a token."""

    async def live(socket: WebSocket) -> None:
        await Live(socket, folder, explicit).run()

    async def exported(request: Request) -> Response:
        path = find_export(folder, request.path_params["path"])
        return FileResponse(path, headers=EXPORTED) if path else Response(status_code=404)

    files = [Route(f"/{{token}}/{name}", _file(*place)) for name, place in FILES.items()]
    return Guard(
        Starlette(
            routes=[*files, Route("/{token}/exports/{path:path}", exported), WebSocketRoute("/{token}/live", live)]
        ),
        token,
        port,
    )


def _file(package: str, name: str, kind: str) -> Callable[[Request], Awaitable[Response]]:
    async def sent(request: Request) -> Response:
        return Response(resources.files(package).joinpath(name).read_text(encoding="utf-8"), media_type=kind)

    return sent
