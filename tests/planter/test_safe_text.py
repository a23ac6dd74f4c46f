"""Untrusted text made safe to print: invisible characters are escaped, length is limited."""

import pytest

from planter import safe_text
from planter.errors import InputError
from planter.report import html
from planter.report.console import Console

NASTY = "a\x1b[31m\u202e\x00\udcff\u2028b"


@pytest.mark.parametrize("raw", [NASTY, "\x7f", "\x85", "\ufeff", "\u200b"])
def test_invisible_characters_are_escaped(raw: str) -> None:
    assert "\x1b" not in safe_text.sanitise_text(raw)
    assert safe_text.sanitise_text(raw).encode("utf-8").decode("utf-8").isprintable()


def test_letters_of_any_script_are_unchanged() -> None:
    for raw in ("Getriebe für 1,5 °", "移栽机构", "φ₁ · 2·π"):
        assert safe_text.sanitise_text(raw) == safe_text.sanitise_line(raw) == raw


def test_line_is_single_and_limited() -> None:
    assert safe_text.sanitise_line("a\nb\r\nc\td") == "a\\nb\\r\\nc\\td"
    assert safe_text.sanitise_line("a\xa0b\u3000c d") == "a\\xa0b\\u3000c d"
    long = safe_text.sanitise_line("x" * 100_000 + ": it must be short")
    assert len(long) <= safe_text.MAX_LENGTH
    assert long.endswith("it must be short")


def test_error_message_is_a_single_line() -> None:
    message = InputError(f"no\nsuch.toml: {'k' * 100_000}\x1b is wrong").message
    assert message.isprintable()
    assert len(message) <= safe_text.MAX_LENGTH


def test_table_escapes_markup_and_control_characters(capsys: pytest.CaptureFixture[str]) -> None:
    Console(as_json=False).table(
        "t[/i]", ("[/b]", "h\x1b"), [("[red]x[/x]", ":smile:"), ("\x1b[2J", 1.0)]
    )
    out = capsys.readouterr().out
    for text in ("t[/i]", "[/b]", "h\\x1b", "[red]x[/x]", ":smile:", "\\x1b[2J"):
        assert text in out
    assert "\x1b[2J" not in out


def test_page_has_no_control_characters() -> None:
    page = html.render_page(
        NASTY, [html.Section("<s>", [html.Text(NASTY), html.Table([NASTY], [[NASTY]])])]
    )
    assert "\x1b" not in page
    assert "\x00" not in page
    assert "a\\x1b[31m" in page
