"""The command `planter audit`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import typer

from planter.errors import InputError
from planter.report.console import Console
from planter.report.options import (
    JsonOption,
    OutOption,
    list_allowed,
    refuse_unused,
    text_option,
    writes_files,
)

app = typer.Typer()

AGAINST = (
    "Python file with the mechanism that a text is compared with (it is run: only use files "
    "you trust)"
)
NAMES = (
    "TOML file with the meanings of a text's names; without it, one to complete is written "
    "next to the text"
)
TEXTS = (".tex", ".md", ".rst", ".ipynb")
SLIPS = 300
NUMBERS = (
    "printed numbers of a paper of your own, to compute anew: the TOML file that is described above"
)


def _list_papers() -> Iterable[str]:
    from planter.audit import numbers

    return numbers.list_papers()


@app.command(cls=list_allowed(paper=_list_papers))
@writes_files("summary.json", "report.html")
def audit(
    paper: Annotated[
        str | None,
        typer.Argument(
            metavar="[PAPER|FILE]",
            help="a text (.tex, .md, .rst, .ipynb), with --against; a Python file that states "
            "your paper (it is run: "
            "only use files you trust); or one of the papers, by its short name",
        ),
    ] = None,
    against: Annotated[Path | None, text_option(AGAINST, "FILE")] = None,
    names: Annotated[Path | None, text_option(NAMES, "TOML")] = None,
    numbers: Annotated[Path | None, text_option(NUMBERS, "TOML")] = None,
    benchmark: Annotated[
        bool,
        typer.Option(
            "--benchmark",
            help="score the audit on a corpus of texts, the folder FILE, beside other checkers "
            "(this takes minutes)",
        ),
    ] = False,
    slips: Annotated[
        int,
        typer.Option(min=1, max=100_000, help="with --benchmark: number of errors that are drawn"),
    ] = SLIPS,
    seed: Annotated[int, typer.Option(help="with --benchmark: random seed")] = 0,
    answers: Annotated[
        Path | None, text_option("with --benchmark: answers of another checker", "JSONL")
    ] = None,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Check the printed equations, laws and numbers of a paper.

    Without a file these are the papers that the built-in machines come from.

    `planter audit slider_crank_paper.py --numbers slider_crank_numbers.toml --out trial` judges
    your paper; the verdicts are also written to generated/ next to its file, with the functions
    that its numbers are computed by.

    `planter audit paper.tex --against slider_crank.py` reads the displayed equations of a text and
    judges each that it can read and whose names it knows. paper.names.toml is written to say what
    the other names mean: complete it, and pass it by --names.

    `planter audit --benchmark` draws errors into sound equations of a corpus, and counts which are
    found and repaired. claims.jsonl has what was judged; --answers scores what another checker says
    of it, a line of JSON for each claim: "key", "outcome" (holds, fails or refused), and "latex",
    the row as it should be.

    The numbers are tables [[number]]: place = "Table 2, row 3"; quantity = "max F_Ax" (or min,
    range, mean, rms, variance, with abs before the name if wanted; "M_in at 90", in deg, "x_G at
    0.5 s" of a mechanism that moves by itself); unit = "N"; printed = "412.6", as text, for its
    digits are its precision. What else they may say: with = { omega_rpm = 600 }, values that it
    holds for; each = { phi = [0, 90] }, for a row of numbers, printed a list then and {phi}
    replaced in place and quantity; samples, if extremes and means are computed from a number of
    samples; until_s, of a free motion; needs, inputs that are unknown; reading. Before them
    [disclosed] holds values that the paper gives, [assumed] such that it does not give, both by the
    keys of generated/NAME.toml; every other value is that of the mechanism's table. [measurement]
    says what the paper's sensor saw, in the keys of a machine file, and "max measured_F_Ax" is then
    a number of that signal.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.audit import user_paper
        from planter.audit.presentation import present_audit

        is_text = bool(against or names) or str(paper).lower().endswith(TEXTS)
        is_user_paper = not is_text and _is_file(paper)
        if benchmark:
            refuse_unused("with --benchmark", "--against", "--names", "--numbers")
            _present_benchmark(console, out, paper, slips, seed, answers)
            return
        refuse_unused("without --benchmark", "--answers", "--slips", "--seed")
        if is_text:
            audited = _audit_text(console, paper, against, names, numbers)
        elif is_user_paper:
            trial = user_paper.audit_user_paper(Path(paper or "."), numbers)
            console.say(f"written to {trial.folder}")
            audited = trial.result, trial.typeset
        else:
            audited = _audit_built_in(paper, numbers)
        present_audit(*audited).show(console, out)


def _present_benchmark(
    console: Console,
    out: Path | None,
    corpus: str | None,
    slips: int,
    seed: int,
    answers: Path | None,
) -> None:
    from planter.audit.benchmark import CORPUS, present_benchmark, run_benchmark

    result = run_benchmark(CORPUS if corpus is None else Path(corpus), slips, seed, answers)
    present_benchmark(*result).show(console, out)


def _is_file(paper: str | None) -> bool:
    """Return whether PAPER is a file or folder."""
    if not paper:
        return False
    return paper.endswith(".py") or (paper not in list(_list_papers()) and Path(paper).exists())


def _audit_text(
    console: Console,
    text: str | None,
    against: Path | None,
    names: Path | None,
    numbers: Path | None,
) -> tuple[dict[str, Any], Any]:
    from planter.audit import user_paper

    if text is None or not text.lower().endswith(TEXTS):
        option = "--against" if against is not None else "--names"
        raise InputError(f"{option} needs a text that ends in {', '.join(TEXTS)}, not {text}")
    if against is None:
        raise InputError(f"{text} needs --against: a Python file that states the mechanism")
    trial = user_paper.audit_text(Path(text), against, names, numbers)
    console.say(f"written to {trial.folder}")
    if trial.skeleton is not None:
        console.say(f"names to complete: {trial.skeleton}; pass them by --names {trial.skeleton}")
    elif names is None:
        console.say(
            f"{Path(text).with_suffix(user_paper.NAMES_SUFFIX)} exists and was not used: pass it "
            f"by --names"
        )
    return trial.result, trial.typeset


def _audit_built_in(paper: str | None, numbers: Path | None) -> tuple[dict[str, Any], Any]:
    from planter.audit import verdicts
    from planter.kernels import generated

    if numbers is not None:
        raise InputError(f"--numbers {numbers} needs the Python file of a paper")
    return verdicts.audit(paper), generated.sidecar("audit_mathml")
