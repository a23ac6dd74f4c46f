"""The command `planter audit`."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Annotated, Any

import typer

from planter.errors import InputError
from planter.report.writing import writes_files
from planter.terminal.console import Console
from planter.terminal.options import JsonOption, OutOption, list_allowed

app = typer.Typer()

NUMBERS = "printed numbers of a paper of your own, to compute anew: the TOML file that is described above"


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
            help="a Python file that states your paper (it is run: only use files you trust), or "
            "one of the papers, by its short name",
            show_default=False,
        ),
    ] = None,
    numbers: Annotated[Path | None, typer.Option(metavar="TOML", help=NUMBERS, show_default=False)] = None,
    front: Annotated[
        bool, typer.Option("--front", help="also list the ranges and variances that the derived model can give")
    ] = False,
    experiment: Annotated[
        bool, typer.Option("--experiment", help="also compare hypotheses on what the paper measured")
    ] = False,
    as_json: JsonOption = False,
    out: OutOption = None,
) -> None:
    """Check the printed equations, laws and numbers of a paper.

    Without a file these are the papers that the built-in machines come from.

    `planter audit slider_crank_paper.py --numbers slider_crank_numbers.toml --out trial` judges your paper;
    the verdicts are also written to generated/ next to its file, with the functions that its numbers are computed by.

    The numbers are tables [[number]]: place = "Table 2, row 3"; quantity = "max F_Ax" (or min, range, mean, rms,
    variance, with abs before the name if wanted; "M_in at 90", in deg, "x_G at 0.5 s" of a mechanism that moves by
    itself); unit = "N"; printed = "412.6", as text, for its digits are its precision. What else they may say: with =
    { omega_rpm = 600 }, values that it holds for; each = { phi = [0, 90] }, for a row of numbers, printed a list then
    and {phi} replaced in place and quantity; samples, if extremes and means are computed from a number of samples;
    until_s, of a free motion; needs, inputs that are unknown; reading. Before them [disclosed] holds values that the
    paper gives, [assumed] such that it does not give, both by the keys of generated/NAME.toml; every other value is
    that of the mechanism's table.
    """
    console = Console(as_json)
    with console.outcome():
        from planter.audit.presentation import present_audit

        trial = _audit_user_paper if _is_file(paper) else _audit_built_in
        present_audit(*trial(console, paper, numbers, front, experiment)).show(console, out)


def _is_file(paper: str | None) -> bool:
    """Return whether PAPER is a file or folder."""
    if not paper:
        return False
    return paper.endswith(".py") or (paper not in list(_list_papers()) and Path(paper).exists())


def _audit_user_paper(
    console: Console, source: str | None, numbers: Path | None, front: bool, experiment: bool
) -> tuple[dict[str, Any], Any]:
    from planter.audit import user_paper

    if front:
        raise InputError("--front needs one of the papers by its short name")
    if experiment:
        raise InputError("--experiment needs one of the papers by its short name")
    trial = user_paper.audit_user_paper(Path(source or "."), numbers)
    console.say(f"written to {trial.folder}")
    return trial.result, trial.typeset


def _audit_built_in(
    console: Console, paper: str | None, numbers: Path | None, front: bool, experiment: bool
) -> tuple[dict[str, Any], Any]:
    from planter.audit import verdicts
    from planter.audit.presentation import compare_hypotheses, search_front
    from planter.kernels import generated

    if numbers is not None:
        raise InputError(f"--numbers {numbers} needs the Python file of a paper")
    result = verdicts.audit(paper)
    if front:
        result["front"] = search_front(paper, console.progress)
    if experiment:
        result["experiment"] = compare_hypotheses(paper, console.progress)
    return result, generated.sidecar("audit_mathml")
