"""The studio's server: bound to this machine, at an address that holds its token."""

from __future__ import annotations

import socket
import webbrowser
from pathlib import Path
from urllib.parse import quote

import uvicorn

from planter.errors import InputError
from planter.studio.app import application
from planter.studio.guard import token
from planter.studio.live import LONGEST_MESSAGE
from planter.view.subject import opened

HOST = "127.0.0.1"


def serve(machine: str | None, folder: Path, port: int, browser: bool) -> None:
    """Serve until interrupted; the address is printed first. Raises InputError for a machine or folder that is none."""
    explicit = None
    if machine is not None:
        opened(machine)
        explicit = Path(machine) if Path(machine).is_file() else None
        folder = explicit.parent if explicit else folder
    if not folder.is_dir():
        raise InputError(f"--folder {folder} is not allowed: it must be a folder")
    with socket.socket() as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((HOST, port))
            listening.listen()
        except OSError:
            raise InputError(f"--port {port} is not allowed: another program uses it") from None
        known, port = token(), listening.getsockname()[1]
        name = f"#{quote(Path(machine).name)}" if machine else ""
        address = f"http://{HOST}:{port}/{known}/{name}"
        print(f"planter studio: {address}\nOnly this machine can reach it. Ctrl-C ends it.", flush=True)
        if browser:
            webbrowser.open(address)
        config = uvicorn.Config(
            application(folder, known, port, explicit),
            log_level="error",
            ws="websockets-sansio",
            ws_per_message_deflate=False,
            ws_max_size=4 * LONGEST_MESSAGE,
        )
        uvicorn.Server(config).run(sockets=[listening])
