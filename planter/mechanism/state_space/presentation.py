"""The presentation of a linear model."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from planter.mechanism.file import MechanismFile
from planter.mechanism.presentation import describe_file
from planter.mechanism.state_space.results import LinearModelResult, Matrix
from planter.report import files
from planter.report.html import Block, Cell, Section, Table, Text
from planter.report.presentation import ResultPresentation


def present_linear_model(result: LinearModelResult, file: MechanismFile) -> ResultPresentation:
    """Return the presentation: eigenvalues, state, inputs, outputs, matrices."""
    document, model = describe_file(file)
    place = {"start": "its start", "rest": "rest"}[result.at]
    return ResultPresentation(
        f"{result.machine} about {place}",
        result,
        list(_list_sections(result)),
        _conclude(result),
        document=document,
        model=model,
        comments=list(files.list_comments(document, "mechanism")),
    )


def _conclude(result: LinearModelResult) -> str:
    unstable = sum(real > 0 for real, _ in result.eigenvalues)
    count = len(result.eigenvalues)
    return f"{unstable} of {count} eigenvalues have a positive real part."


def _list_sections(result: LinearModelResult) -> Iterator[Section]:
    header = ("real / 1/s", "imaginary / 1/s")
    lines: list[Block] = [Table(header, result.eigenvalues)]
    if result.drift > 0:
        lines.append(
            Text(f"The largest rate of the state there is {result.drift:.4g} in SI.", "note")
        )
    yield Section("Eigenvalues", lines)
    for title, variables in (
        ("State", result.state),
        ("Inputs", result.inputs),
        ("Outputs", result.outputs),
    ):
        if variables:
            rows = [(x.name, x.value, x.unit, x.meaning) for x in variables]
            yield Section(title, [Table(("name", "value", "unit", "meaning"), rows)])
    if result.constraints.rows:
        yield Section(
            "Constraints", [Table(("kept",), [(row,) for row in result.constraints.rows])]
        )
    state, inputs = ([x.name for x in part] for part in (result.state, result.inputs))
    outputs = [x.name for x in result.outputs]
    yield from _list_matrix("A", result.A, [f"{name}'" for name in state], state)
    yield from _list_matrix("B", result.B, [f"{name}'" for name in state], inputs)
    yield from _list_matrix("C", result.C, outputs, state)
    yield from _list_matrix("D", result.D, outputs, inputs)


def _list_matrix(
    name: str, matrix: Matrix, rows: Sequence[str], columns: Sequence[str]
) -> Iterator[Section]:
    if columns and rows:
        cells: list[tuple[Cell, ...]] = [
            (row, *values) for row, values in zip(rows, matrix, strict=True)
        ]
        yield Section(name, [Table(("", *columns), cells)])
