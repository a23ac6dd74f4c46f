"""Files to start from: `planter new`, from built-in machines and from examples of statements."""

from __future__ import annotations

import os
import shlex
from dataclasses import dataclass
from pathlib import Path

from planter import paths
from planter.errors import InputError
from planter.files import documents, examples
from planter.report import folder


@dataclass(frozen=True)
class Template:
    """A file to start from: its content in words, its source, and the commands to type next.

    A source with a dot is an example of the documentation, any other the name of a built-in file;
    `name` is the file's default name. `companions` are examples that are written beside it. In
    `steps`, {file} is the file, and {folder} what its folder's files begin with.
    """

    content: str
    source: str
    name: str
    steps: tuple[str, ...]
    companions: tuple[str, ...] = ()


def _describe_statement(content: str, source: str, *steps: str, options: str = "") -> Template:
    """Return the template of a statement in Python, which is derived and simulated first."""
    simulation = f"planter simulate own/{source}.toml{options}"
    first = ("planter derive {file} --out own", simulation)
    return Template(content, f"{source}.py", f"{source}.py", (*first, *steps))


TEMPLATES = {
    "planting-device": Template(
        "the planting device of wang2017, with the paper's optimum as its design",
        "wang2017",
        "planting_device.toml",
        ("planter simulate {file} --out run", "planter optimise {file} --out best"),
    ),
    "crank-rocker": _describe_statement("a four-bar with a load on its rocker", "crank_rocker"),
    "slider-crank": _describe_statement(
        "an offset slider-crank with gas, a spring and friction", "slider_crank"
    ),
    "cam": _describe_statement(
        "a plate cam that lifts a slide by a roller",
        "cam_follower",
        "planter cam own/cam_follower.toml --roller-mm 8 --bore-mm 12 --out cam",
    ),
    "gear-train": _describe_statement(
        "a planetary train of elliptic gears with a planting arm",
        "planetary_train",
        "planter gears own/planetary_train.toml --module 1 --out teeth",
    ),
    "six-bar": _describe_statement(
        "a Watt six-bar: the rocker of a four-bar drives another", "watt_six_bar"
    ),
    "pendulum": _describe_statement(
        "a free pendulum with a damper, which nothing drives", "pendulum", options=" --until 5"
    ),
    "arm": _describe_statement("a four-bar that moves a transplanting arm", "transplanting_arm"),
    "pick-up": Template(
        "the seedling pick-up of yu2023, by its law of motion",
        "yu2023",
        "pick_up.toml",
        ("planter design pickup {file} --out pickup", "planter gears {file} --out gears"),
    ),
    "clutch": Template(
        "the Reuleaux-pentagon clutch of shi2021",
        "shi2021",
        "clutch.toml",
        ("planter design clutch geometry {file} --out clutch",),
    ),
    "poses": Template(
        "five poses of an arm, for a linkage that passes them",
        "sun2019-corrected",
        "poses.toml",
        ("planter design synthesise {file} --out linkage",),
    ),
    "measured-curve": Template(
        "a measured force over a turn, from which inputs are estimated",
        "measured_curve.csv",
        "measured_curve.csv",
        (
            "planter calibrate wang2017 --model exact --data {file} --column force --angle angle "
            "--fit mass.planet_kg=0.8:1.6 --fit offset_N=-20:20",
        ),
    ),
    "sweep": Template(
        "a plan that varies speed, a mass and a coefficient of wang2017",
        "sweep_speed.toml",
        "sweep.toml",
        ("planter sweep {file} --out run",),
    ),
    "tolerances": Template(
        "tolerances of wang2017: of masses, centroids, angles, speed",
        "tolerances.toml",
        "tolerances.toml",
        ("planter tolerance wang2017 --tolerances {file} --out run",),
    ),
    "paper": Template(
        "a paper in LaTeX with errors, tried against a mechanism",
        "slider_crank_text.tex",
        "paper.tex",
        (
            "planter audit {file} --against {folder}slider_crank.py "
            "--names {folder}slider_crank_text.names.toml",
        ),
        ("slider_crank.py", "slider_crank_text.names.toml"),
    ),
}


def read_template(name: str) -> Template:
    """Return a template. Raises InputError for an unknown name."""
    if name not in TEMPLATES:
        raise InputError.for_value("TEMPLATE", name, paths.suggest_names(name, list(TEMPLATES)))
    return TEMPLATES[name]


def write_template(template: Template, target: Path | None) -> tuple[list[str], list[str]]:
    """Write the files of a template, the first as `target`; return their paths and the next
    commands.

    Raises InputError, before anything is written, for a file that exists or has another suffix.
    """
    target = target or Path(template.name)
    suffix = Path(template.name).suffix
    if target.suffix != suffix:
        raise InputError.for_value("FILE", str(target), f"its name must end in {suffix}")
    texts = {target: _read_source(template.source)}
    texts |= {target.with_name(name): _read_source(name) for name in template.companions}
    for path in filter(os.path.lexists, texts):
        raise InputError(f"{path}: this file exists, and it is not overwritten; name another FILE")
    folder.output_folder(target.parent)
    for path, text in texts.items():
        folder.create_file(path, text.encode())
    prefix = str(target.parent / "_")[:-1] if target.parent != Path() else ""

    def complete(step: str) -> str:
        words = (word.format(file=target, folder=prefix) for word in step.split(" "))
        return shlex.join(words)

    steps = [complete(step) for step in template.steps]
    return [str(path) for path in texts], steps


def _read_source(source: str) -> str:
    return documents.read_statement(source) if "." in source else examples.example(source)
