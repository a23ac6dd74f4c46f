"""What strangers hand to a studio: no code of theirs runs, no address breaks it, a poisonous file
costs a message.
"""

from __future__ import annotations

import asyncio
import http.client
import json
import os
import signal
from pathlib import Path

import pytest

from planter import workers
from planter.errors import ComputationError, InputError
from planter.studio import live
from planter.studio.live import GivenUpError, RemoteSession
from planter.studio.session import FAILED, Session, _format_answer, answer_request
from tests.planter.studio.serving import answer, message_with, open_line

pytestmark = pytest.mark.fault
EVIL = "open({mark!r}, 'w').close()\n"
"""A module that leaves a mark when it is executed."""
TO_CODE = (
    '"functions" = "evil"',
    "'functions' = \"evil\"",
    'functions="evil"',
    '"\\u0066unctions" = "evil"',
)
"""Ways in which a file says that Python code belongs to it."""


def write_evil(folder: Path) -> Path:
    """Write a module that leaves a mark, with its sidecar, and return where the mark would be."""
    folder.mkdir(parents=True, exist_ok=True)
    mark = folder / "executed"
    (folder / "evil.py").write_text(EVIL.format(mark=str(mark)), encoding="utf-8")
    sidecar = {"vectors": {"data": [], "outputs": []}, "functions": {}, "speed": "omega"}
    (folder / "evil.json").write_text(json.dumps(sidecar), encoding="utf-8")
    return mark


def write_machine(key: str, place: Path | str) -> str:
    """Return the text of a mechanism's file whose functions are in a folder."""
    return (
        f'name = "evil"\ndescription = ""\n{key}\n"folder" = {json.dumps(str(place))}\n[values]\n'
        '[origin]\ndefault = "assumed"\n'
    )


@pytest.mark.parametrize("key", TO_CODE)
def test_loaded_text_leads_to_no_code(key: str, tmp_path: Path) -> None:
    mark = write_evil(tmp_path / "outside")
    session = Session(tmp_path / "studio", tmp_path / "scratch")
    with pytest.raises(InputError, match="planter studio FILE"):
        session.open({"text": write_machine(key, tmp_path / "outside")})
    assert not mark.exists()


@pytest.mark.parametrize("link", [False, True])
def test_file_of_the_folder_leads_to_no_code_outside(link: bool, tmp_path: Path) -> None:
    """By a path, or by a link; the file that the user names on the command line is explicit."""
    mark, inside = write_evil(tmp_path / "outside"), tmp_path / "studio"
    inside.mkdir()
    if link:
        (inside / "generated").symlink_to(tmp_path / "outside")
    place = "generated" if link else "../outside"
    (inside / "own.toml").write_text(write_machine(TO_CODE[0], place), encoding="utf-8")
    with pytest.raises(InputError, match="outside the studio's folder"):
        Session(inside, tmp_path / "scratch").open({"name": "own.toml"})
    assert not mark.exists()
    explicit = Session(inside, tmp_path / "scratch", inside / "own.toml")
    explicit.open({"name": "own.toml"})


def test_studio_imports_no_user_modules(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("json", "numpy", "planter", "casadi"):
        (tmp_path / f"{name}.py").write_text(
            EVIL.format(mark=str(tmp_path / "executed")), encoding="utf-8"
        )
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))

    async def printed() -> tuple[bytes, bytes]:
        process = await workers.start_async_program("planter", "--version")
        return await process.communicate()

    output, wrong = asyncio.run(printed())
    assert output.startswith(b"planter"), wrong
    assert not (tmp_path / "executed").exists()


@pytest.mark.parametrize(
    "path",
    [
        "/%C3%A9/",
        "/\u00e9/",
        "/{token}\u00e9/",
        "/{token}/exports/%00",
        "/{token}/exports/" + "x" * 5000,
        "/{token}/exports/" + "a/" * 3000,
        "/{token}/%00",
        "/%00/",
        "/%ff%fe/live",
        "/{token}/exports/%ed%a0%80",
    ],
)
def test_strange_addresses_are_refused(path: str, address: str) -> None:
    host, token = address.removeprefix("http://").split("/")[:2]
    talk = http.client.HTTPConnection(host, timeout=10)
    talk.putrequest("GET", "/", skip_host=True)
    talk._buffer[0] = f"GET {path.format(token=token)} HTTP/1.1".encode()  # type: ignore[attr-defined]
    talk.putheader("Host", host)
    talk.endheaders()
    assert 400 <= talk.getresponse().status < 500


def test_surrogate_in_an_id_does_not_silence_a_page(address: str) -> None:
    with open_line(address, "wang2017") as talk:
        talk.send('{"id": "\\ud800", "values": {}}')
        assert message_with(talk, "error")
        assert answer(talk, "scenes", id=2, values={})


def test_non_finite_numbers_are_null() -> None:
    assert json.loads(_format_answer({"a": [1.0, float("nan")], "b": {"c": float("inf")}})) == {
        "a": [1.0, None],
        "b": {"c": None},
    }


async def remote_session(folder: Path) -> RemoteSession:
    session = RemoteSession(folder, folder / "scratch")
    assert (await session.open({"name": "shi2021"})).done
    return session


def test_killed_process_is_replaced(tmp_path: Path) -> None:
    """The next request opens the same machine in another one."""

    async def killed() -> str:
        session = await remote_session(tmp_path)
        opening = session._opened
        assert opening
        assert session._process
        os.kill(session._process.pid, signal.SIGKILL)
        with pytest.raises(ComputationError, match="has ended"):
            await session.ask("file", opening, {"values": {}})
        process = await session.ask("file", opening, {"values": {}})
        await session.close()
        return str(process.table()["file"])

    assert "shi2021" in asyncio.run(killed())


def test_slow_request_is_given_up(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the limit of time, or when the page opens something else."""

    async def given_up() -> None:
        session = await remote_session(tmp_path)
        opening = session._opened
        assert opening
        assert session._process
        os.kill(session._process.pid, signal.SIGSTOP)
        monkeypatch.setattr(live, "LONGEST_S", 0.2)
        with pytest.raises(ComputationError, match="given up after"):
            await session.ask("file", opening, {"values": {}})
        monkeypatch.setattr(live, "LONGEST_S", 60.0)
        monkeypatch.setattr(live, "GRACE_S", 0.1)
        assert (await session.ask("file", opening, {"values": {}})).done
        os.kill(session._process.pid, signal.SIGSTOP)
        asking = asyncio.create_task(session.ask("file", opening, {"values": {}}))
        await asyncio.sleep(0.05)
        session.interrupt()
        with pytest.raises(GivenUpError):
            await asking
        await session.close()

    asyncio.run(given_up())


@pytest.mark.parametrize(
    "error", [MemoryError(), RecursionError("too deep"), ValueError("embedded null byte")]
)
def test_every_exception_is_an_answer(
    error: Exception, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def failing(session: Session, message: object) -> None:
        raise error

    monkeypatch.setattr(Session, "seen", failing)
    answer = answer_request(Session(tmp_path, tmp_path), "seen", {"id": 7})
    assert answer.startswith(FAILED)
    assert json.loads(answer)["id"] == 7


def test_memory_of_a_page_is_limited() -> None:
    """What a worker does first, in a process of its own: allocating more than the limit fails."""
    code = "from planter import workers as w; from planter.studio import session as s; "
    code += "w._limit_memory(s.MEMORY_BYTES); bytearray(s.MEMORY_BYTES)"
    done = workers.run_command(workers.python_command(code))
    assert "MemoryError" in done.stderr
