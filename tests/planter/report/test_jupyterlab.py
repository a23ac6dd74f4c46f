"""The drawing in a real page of JupyterLab, as a reader of a notebook has it."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import expect, sync_playwright

from planter.papers.planting.file import load
from planter.papers.planting.model import Device
from tests.support.browser import browser
from tests.support.structure import ROOT

CELLS = (
    'import planter\nplanter.show("wang2017")',
    'planter.simulate(planter.Device(planter.load_machine("wang2017"), "printed")).show()',
)
"""What a reader runs: each shows a drawing."""


@pytest.fixture
def lab(tmp_path: Path) -> Iterator[str]:
    """The address of a notebook with the cells, in a JupyterLab of its own."""
    pytest.importorskip(
        "jupyterlab", reason="JupyterLab is not installed: make test-long installs it"
    )
    cells = [
        {
            "cell_type": "code",
            "id": f"cell-{k}",
            "metadata": {},
            "source": source,
            "outputs": [],
            "execution_count": None,
        }
        for k, source in enumerate(CELLS)
    ]
    kernel = {"kernelspec": {"name": "python3", "display_name": "Python 3", "language": "python"}}
    book = {"nbformat": 4, "nbformat_minor": 5, "metadata": kernel, "cells": cells}
    (tmp_path / "book.ipynb").write_text(json.dumps(book), encoding="utf-8")
    folders = {
        f"JUPYTER_{name}_DIR": str(tmp_path / name.lower())
        for name in ("CONFIG", "DATA", "RUNTIME")
    }
    command = [
        sys.executable,
        "-m",
        "jupyter",
        "lab",
        "--no-browser",
        "--port=0",
        "--allow-root",
        "--IdentityProvider.token=known",
        f"--ServerApp.root_dir={tmp_path}",
    ]
    surroundings = os.environ | folders | {"PYTHONPATH": str(ROOT)}
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=surroundings) as process:
        try:
            assert process.stderr is not None
            address = next(
                match
                for line in process.stderr
                if (match := re.search(r"http://127\S+?:(\d+)/lab", line))
            )
            yield f"http://127.0.0.1:{address[1]}/lab/tree/book.ipynb?token=known&reset"
        finally:
            process.terminate()
            process.communicate()


@pytest.mark.long
def test_a_notebook_shows_the_machine_as_it_moves(lab: str) -> None:
    """Of both cells the drawing stands there with the model's own numbers, and plays."""
    messages = []
    for model in ("exact", "printed"):
        device = Device(load("wang2017"), model)
        turn = device.columns(device.design, device.engine.list_angles(360))
        messages.append(
            f"carrier angle 0\N{DEGREE SIGN}, vertical support force {turn['support_N'][0]:.5g} N"
        )
    with (
        sync_playwright() as play,
        play.chromium.launch(executable_path=browser(), args=["--no-sandbox"]) as chromium,
    ):
        page = chromium.new_page()
        page.goto(lab)
        page.wait_for_selector(".jp-CodeCell", timeout=120_000)
        expect(page.get_by_text("| Idle")).to_be_visible(timeout=120_000)
        page.get_by_text("Run", exact=True).first.click()
        page.get_by_text("Run All Cells", exact=True).click()
        drawings = page.locator(".planter-view")
        expect(drawings).to_have_count(len(CELLS), timeout=120_000)
        for k, words in enumerate(messages):
            drawing = drawings.nth(k)
            expect(drawing.locator(".teeth")).to_have_count(7)
            expect(drawing.locator(".told")).to_have_text(words)
            drawing.get_by_role("button", name="Play").click()
            expect(drawing.locator(".told")).not_to_have_text(words)
            drawing.get_by_role("button", name="Pause").click()
