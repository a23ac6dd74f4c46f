"""Text of strangers as it is shown: everything that cannot be seen is written out, nothing is long."""

import pytest

from planter import legible
from planter.errors import InputError
from planter.report import html
from planter.terminal.console import Console

NASTY = "a\x1b[31m\u202e\x00\udcff\u2028b"


@pytest.mark.parametrize("raw", [NASTY, "\x7f", "\x85", "\ufeff", "\u200b"])
def test_what_cannot_be_seen_is_written_out(raw: str) -> None:
    assert "\x1b" not in legible.text(raw)
    assert legible.text(raw).encode("utf-8").decode("utf-8").isprintable()


def test_letters_of_any_script_stay_as_they_are() -> None:
    for raw in ("Getriebe für 1,5 °", "移栽机构", "φ₁ · 2·π"):
        assert legible.text(raw) == legible.line(raw) == raw


def test_a_line_is_one_and_not_long() -> None:
    assert legible.line("a\nb\r\nc\td") == "a\\nb\\r\\nc\\td"
    assert legible.line("a\xa0b\u3000c d") == "a\\xa0b\\u3000c d"
    long = legible.line("x" * 100_000 + " is not allowed: it must be short")
    assert len(long) <= legible.LONGEST
    assert long.endswith("it must be short")


def test_an_errors_message_is_one_line() -> None:
    message = InputError(f"no\nsuch.toml: {'k' * 100_000}\x1b is wrong").message
    assert message.isprintable()
    assert len(message) <= legible.LONGEST


def test_markup_and_control_characters_are_no_instructions_to_the_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    Console(as_json=False).table("t[/i]", ("[/b]", "h\x1b"), [("[red]x[/x]", ":smile:"), ("\x1b[2J", 1.0)])
    out = capsys.readouterr().out
    for text in ("t[/i]", "[/b]", "h\\x1b", "[red]x[/x]", ":smile:", "\\x1b[2J"):
        assert text in out
    assert "\x1b[2J" not in out


def test_a_page_holds_no_control_characters() -> None:
    page = html.page(NASTY, [html.Section("<s>", [html.Text(NASTY), html.Table([NASTY], [[NASTY]])])])
    assert "\x1b" not in page
    assert "\x00" not in page
    assert "a\\x1b[31m" in page
