"""The page of findings: what the audit's records say is wrong in the papers, cause by cause, with the evidence.

Each sentence is put together from a record, so that none claims more than was found.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import groupby
from typing import Any

from planter import plugins
from planter.audit import verdicts
from planter.kernels import generated

Entry = Mapping[str, Any]
FAULT = ("misprint", "incomplete", "contradicted")
CURED = {
    "misprint": "The edit removes the difference between the print and the derivation.",
    "incomplete": "Terms of the derivation are left over after every edit that was tried.",
    "contradicted": "A printed term is neither derived nor explained by an edit.",
}
HEAD = """\
# Findings

What four papers print, held against independent derivations of what each equation claims. Judged is the machine-read
text, not the pages: pieces that could not be read were completed, and the page says where a finding rests on that, on a
reading of a symbol, or on one character, which may be an error of reading rather than of the paper. A difference in
print says nothing about the programs that the authors computed with. What an equation claims is read off the text
around it; where it is read wrongly, the verdict falls with it. A verdict is relative to the assumptions that are
listed: a paper that means others may be right by them. Sizes are those over a reference cycle with the built-in
machine file, whose numbers are assumed where the paper does not disclose them: other inputs give other sizes of the
same terms.

Every sentence below is put together from the records that `planter audit` prints; [how the audit judges](../theory.md)
says what a verdict means. Corrections from authors are welcome: what a paper means goes into its file in
`derive/papers/` as a reading, and the verdict follows.
"""
SMALL = 0.01
"""Share of an equation's largest term below which a term may have been left out on purpose."""


def numbers(entries: Sequence[Entry]) -> str:
    """Equations' numbers in a row."""
    return ", ".join(f"({entry['equation']})" for entry in entries)


def caution(entry: Entry) -> Iterator[str]:
    """What a finding hangs on, in sentences."""
    if entry["fragile"]:
        whole = entry["verdict"] == "misprint" and ";" not in entry["correction"][0]
        yield (
            f"{'It hangs' if whole else 'Its correction hangs in part'} on one character of the "
            f"text as read."
        )
    if entry["rebuilt"]:
        yield (
            f"Completed in the text as read: "
            f"{'; '.join(f'`{piece}`' for piece in entry['rebuilt'])}."
        )
    if not entry["robust"]:
        yield "Under another admissible reading the verdict is another one:"
    if entry["reading"]:
        yield f"Read so: {entry['reading']}."


def terms(entry: Entry, key: str, words: str) -> Iterator[str]:
    """Terms that are missing or too many, with their size over the reference cycle."""
    for term in entry[key]:
        known = term.get("max_abs") is not None
        most = (
            f"up to {term['max_abs']:.3g} {term['unit']}"
            if known and term["max_abs"]
            else "zero over the cycle"
        )
        size = f", {most}" if known else ""
        share = term.get("share_of_largest")
        yield f"  * {words}: `{term['term']}`{size}" + (
            f" ({share:.2g} of the largest term)" if known and share else ""
        )


def negligible(entry: Entry) -> bool:
    """Whether all terms that an equation lacks are known to be small, and there are some."""
    known = [term.get("share_of_largest") for term in entry["terms"]]
    return bool(known) and all(share is not None and share < SMALL for share in known)


def evidence(entry: Entry) -> Iterator[str]:
    """An equation at fault: what it claims, the verdict, the correction, what is missing."""
    yield (
        f"* **({entry['equation']})**, {entry['claims']}: {entry['verdict']}. "
        f"{CURED[entry['verdict']]}"
    )
    if entry["verdict"] == "contradicted":
        yield f"  Found: `{entry['finding']}`."
    if entry["correction"]:
        yield f"  Correction: {' or '.join(f'`{one}`' for one in entry['correction'])}."
    yield from (f"  {sentence}" for sentence in caution(entry))
    if not entry["robust"]:
        yield from (f"  * {one['reading']}: {one['verdict']}" for one in entry["depends"])
    if negligible(entry):
        yield (
            f"  Each is less than {100 * SMALL:g} % of the largest term: they may have been "
            f"left out on purpose."
        )
    yield from terms(entry, "terms", "lacks")
    yield from terms(entry, "unexplained", "has, unexplained")


def shares(laws: Sequence[Entry], equations: Sequence[Entry]) -> Iterator[str]:
    """The share of a cause's equations in the laws that the paper's chain breaks."""
    own = {entry["equation"] for entry in equations}
    for law in laws:
        for share in law["shares"]:
            if share["equation"] in own and abs(share["shapley"]) >= 0.01 * law["violation"]:
                unit = law["unit"]
                yield (
                    f"* By {law['violation']:.3g} {unit}: {law['law']}. Repairs of "
                    f"({share['equation']}) take away "
                    f"{share['shapley']:.3g} {unit} on the mean over all orders of repair, "
                    f"{share['alone']:.3g} {unit} "
                    "as the only ones."
                )


def causes(
    found: Sequence[Entry], by_name: Mapping[str, Entry], laws: Sequence[Entry]
) -> Iterator[str]:
    """Causes of the same equations, the printed numbers that each repair cures, and the share in what is broken."""
    judged = [by_name[name] for name in found[0]["equations"] if name in by_name]
    yield f"\n### {numbers(judged) or 'Printed numbers'}\n"
    for one in found:
        repair = "" if one["repair"] == one["cause"] else f" Repair: `{one['repair']}`."
        yield f"Cause: `{one['cause']}`.{repair}\n"
        if one["numbers"]:
            yield (
                f"The repair brings {len(one['numbers'])} printed numbers out as they are "
                f"printed.\n"
            )
    for entry in judged:
        yield from evidence(entry)
    listed = list(shares(laws, judged))
    if listed:
        yield (
            "\nShare in the laws that the printed chain breaks, of each equation with all that "
            "is repaired in it:\n"
        )
        yield from listed


def assumed(name: str) -> list[str]:
    """What the derivation assumes that a paper is held against."""
    folders = plugins.find_folders("printed").items()
    machine = next(
        machine for machine, folder in folders if folder.joinpath(f"{name}.toml").is_file()
    )
    return list(generated.sidecar(f"{machine}_exact")["assumptions"])


def paper(name: str, record: Entry) -> Iterator[str]:
    """A paper: how many verdicts of each kind, then cause by cause."""
    mine = {
        key: [one for one in record[key] if one["paper"] == name]
        for key in ("equations", "laws", "causes")
    }
    counts = ", ".join(f"{count} {verdict}" for verdict, count in record["summary"][name].items())
    yield f"\n## {record['papers'][name]['title']}\n"
    yield f"{len(mine['equations'])} equations and formulas: {counts}.\n"
    by_name = {
        f"{name}: {one['equation']}": one for one in mine["equations"] if one["verdict"] in FAULT
    }
    yield f"Assumed in the derivation: {'; '.join(assumed(name))}."
    for _, found in groupby(mine["causes"], key=lambda one: (one["equations"], one["numbers"])):
        yield from causes(list(found), by_name, mine["laws"])
    for one in (one for one in record["references"] if one["paper"] == name):
        places = ", ".join(f"({number})" for number in one["refers_to"])
        yield (
            f"\n### {places} as the source of {', '.join(one['quantities'])}\n\nThe reference "
            f"{one['verdict']}: "
        )
        yield f"these formulas do not hold {', '.join(one['lacking'])}."


def page(record: Entry | None = None) -> str:
    """The page, of the committed records."""
    record = record or verdicts.load_verdicts()
    return (
        "\n".join([HEAD, *(line for name in record["papers"] for line in paper(name, record))])
        + "\n"
    )
