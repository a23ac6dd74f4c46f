"""The server of the studio, bound to this computer, at an address with its token."""

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
    """Print the address and serve until interrupted. Raises InputError if the machine or folder does not exist."""
    explicit = None
    if machine is not None:
        opened(machine)
        explicit = Path(machine) if Path(machine).is_file() else None
        folder = explicit.parent if explicit else folder
    if not folder.is_dir():
        raise InputError(f"--folder {folder}: there is no such folder")
    with socket.socket() as listening:
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listening.bind((HOST, port))
            listening.listen()
        except OSError:
            raise InputError(f"--port {port}: another program uses this port; choose another") from None
        secret, port = token(), listening.getsockname()[1]
        name = f"#{quote(Path(machine).name)}" if machine else ""
        address = f"http://{HOST}:{port}/{secret}/{name}"
        print(f"planter studio: {address}\nOnly this computer can reach it. Ctrl-C ends it.", flush=True)
        if browser:
            webbrowser.open(address)
        config = uvicorn.Config(
            application(folder, secret, port, explicit),
            log_level="error",
            ws="websockets-sansio",
            ws_per_message_deflate=False,
            ws_max_size=4 * LONGEST_MESSAGE,
        )
        uvicorn.Server(config).run(sockets=[listening])
