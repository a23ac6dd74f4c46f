"""What the README says of the papers is what the audit found."""

from __future__ import annotations

from pathlib import Path

from planter.audit import verdicts

ROOT = Path(__file__).parents[3]
README = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())


def test_paper_table_equals_audit() -> None:
    page = (ROOT / "generated" / "AUDIT.md").read_text(encoding="utf-8").split("\n## ")[0]
    rows = [line for line in page.splitlines() if line.startswith("| ")]
    assert len(rows) == 5
    assert all(" ".join(row.split()) in README for row in rows)


def test_shares_and_slips_are_those_of_the_audit() -> None:
    audit = verdicts.audit()
    law = audit["laws"][0]
    assert law["owed"] in README
    for cause in (c for c in audit["causes"] if c["numbers"]):
        wrong = [
            e
            for e in audit["numbers"]
            if (e["paper"], e["verdict"]) == (cause["paper"], "not reproduced")
        ]
        sentence = (
            f"{len(cause['numbers'])} of the {len(wrong)} printed numbers of "
            f"{cause['paper']} that cannot be reproduced"
        )
        assert sentence in README
        assert cause["cause"].removeprefix("sign of ") in README
