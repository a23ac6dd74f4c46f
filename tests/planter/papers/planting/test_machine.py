"""Machine files: what is read, what is refused and in which words, where numbers come from."""

import math
import re
import time
from pathlib import Path

import pytest
from pydantic import ValidationError

from planter import paths
from planter.errors import GeometryError, InputError
from planter.files import examples
from planter.files.fields import FileSection, Problems, check, invalid_value_problem
from planter.papers.planting.file import PlantingMachine, load
from planter.papers.planting.model import Device


def tampered(folder: Path, section: str, key: str, line: str | None) -> Path:
    """A copy of the wang2017 file in which the line of a key in a section is replaced, or taken
    out.
    """
    before, header, rest = f"\n{examples.example('wang2017')}".partition(f"\n[{section}]")
    body, count = re.subn(rf"(?m)^{re.escape(key)} = .*$", lambda _: line or "", rest, count=1)
    assert header
    assert count == 1
    path = folder / "my.toml"
    path.write_text(before + header + body, encoding="utf-8")
    return path


def refusal(source: str | Path, changes: dict[str, float] | None = None) -> str:
    """The sentence with which a machine is refused."""
    with pytest.raises(InputError) as caught:
        load(source, changes)
    assert caught.value.exit_code == 2
    assert "\n" not in caught.value.message
    return caught.value.message


# --- what is read
# ----------------------------------------------------------------------------------


def test_wang2017_has_weight_of_source() -> None:
    mass = load("wang2017").mass
    halves = 4 * (mass.half_C1_kg + mass.half_C2_kg)
    total = mass.sun_kg + mass.carrier_kg + 2 * (mass.middle_kg + mass.planet_kg) + halves
    assert total == pytest.approx(9.975, abs=1e-12)


def test_the_example_is_a_file_to_start_from(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(examples.example("compact"), encoding="utf-8")
    assert load(path).table() == load("compact").table()
    assert load(str(path)).source == str(path)


def test_a_byte_order_mark_is_no_obstacle(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(examples.example("compact"), encoding="utf-8-sig")
    assert load(path).name == "compact"


# --- SI values
# -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "si"),
    [
        ("operation.speed_rpm", 40 * 2 * math.pi / 60),
        ("speed_rpm", 40 * 2 * math.pi / 60),
        ("mass.sun_kg", 0.4),
        ("inertia.J7_about_B1_kg_m2", 1.5e-3),
        ("nozzle.hinge_A_mm[2]", 0.040),
        ("cam.rise_delta_deg[1]", math.pi),
        ("spring.rate_N_m", 700),
        ("design.theta_deg", math.radians(65.744)),
        ("R3_mm", 0.030916),
        ("bounds.R3_mm[0]", 0.03046),
        ("m31", 1.542),
        ("objective.samples", 360),
    ],
)
def test_si_values(path: str, si: float) -> None:
    assert load("wang2017").si(path) == pytest.approx(si, rel=1e-15)


@pytest.mark.parametrize(
    "path", ["mass", "cam.flank", "nozzle.hinge_A_mm", "nozzle.hinge_A_mm[3]", "no_such_kg"]
)
def test_si_of_non_number_is_refused(path: str) -> None:
    with pytest.raises(InputError, match=re.escape(f"wang2017: {path}:")):
        load("wang2017").si(path)


def test_a_check_outside_can_refuse_a_value_in_the_same_words() -> None:
    machine = load("wang2017", {"e3_mm": 31.0})
    error = machine.input_error(
        "e3_mm", "it must be less than design.R3_mm = 30.916", GeometryError
    )
    assert isinstance(error, GeometryError)
    assert error.message == (
        "wang2017: design.e3_mm = 31.0 (set on the command line): it must be less than "
        "design.R3_mm = 30.916"
    )


# --- origins
# ---------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("path", "origin"),
    [
        ("mass.sun_kg", "assumed"),
        ("operation.speed_rpm", "paper"),
        ("operation.gravity_m_s2", "assumed"),
        ("genetic_algorithm.individuals", "paper (section 3.4)"),
        ("design.R3_mm", "paper (optimum, section 3.4)"),
        ("bounds.R3_mm[1]", "paper (section 3.4)"),
        ("bounds.m61[1]", "paper (section 3.4, printed with the index 51)"),
        ("m61", "paper (optimum, section 3.4)"),
        ("nozzle.hinge_A_mm[0]", "assumed"),
    ],
)
def test_origin_is_the_closest_entry(path: str, origin: str) -> None:
    assert load("wang2017").origin(path) == origin


def test_only_disclosed_values_are_marked_paper() -> None:
    machine = load("wang2017")
    disclosed = {"design", "bounds", "genetic_algorithm"}
    from_paper = {path for path in machine.numbers() if machine.origin(path).startswith("paper")}
    assert {path for path in from_paper if path.partition(".")[0] not in disclosed} == {
        "operation.speed_rpm",
        "contact.pressure_angle_deg",
        "objective.weight_range",
        "objective.weight_variance",
    }
    assert all(load("compact").origin(path) == "assumed" for path in load("compact").numbers())


def test_origin_entries_may_be_paths_with_and_without_quotes(tmp_path: Path) -> None:
    path = tampered(
        tmp_path,
        "origin",
        "carrier_kg",
        'mass.carrier_kg = "measured"\n"nozzle.C2_mm" = "calibrated to Table 1"',
    )
    machine = load(path)
    assert machine.origin("carrier_kg") == "measured"
    assert machine.origin("nozzle.C2_mm[1]") == "calibrated to Table 1"
    assert PlantingMachine.model_validate(machine.table()).origins == machine.origins


# --- changes
# -----------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("mass.sun_kg", "mass.sun_kg"),
        ("sun_kg", "mass.sun_kg"),
        ("R3_mm", "design.R3_mm"),
        ("design.R3_mm", "design.R3_mm"),
        ("bounds.R3_mm[1]", "bounds.R3_mm[1]"),
        ("nozzle.hinge_A_mm[0]", "nozzle.hinge_A_mm[0]"),
        ("hinge_A_mm[0]", "nozzle.hinge_A_mm[0]"),
        ("speed_rpm", "operation.speed_rpm"),
    ],
)
def test_change_affects_only_the_named_number(name: str, path: str) -> None:
    before, after = load("wang2017"), load("wang2017", {name: 33.25})
    changed = {key for key, value in after.numbers().items() if value != before.numbers()[key]}
    assert changed == {path}
    assert after.numbers()[path] == 33.25
    assert after.changed == (path,)
    origins = {key for key in after.numbers() if after.origin(key) != before.origin(key)}
    assert origins == {path}
    assert after.origin(path) == "set on the command line"


def test_changes_add_up() -> None:
    machine = load("wang2017", {"sun_kg": 0.5}).with_numbers({"samples": 90.0})
    assert machine.mass.sun_kg == 0.5
    assert machine.objective.samples == 90
    assert isinstance(machine.objective.samples, int)
    assert machine.changed == ("mass.sun_kg", "objective.samples")


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        ("sun_kgg", 0.5, ["sun_kgg = 0.5 (set on the command line)", "did you mean mass.sun_kg"]),
        ("hinge_A_mm", 0.5, ["hinge_A_mm = 0.5", "nozzle.hinge_A_mm[0]"]),
        ("qqq", 0.5, ["qqq = 0.5", "no such value"]),
        ("", 1.0, ["no such value"]),
        (
            "sun_kg",
            -1.0,
            ["mass.sun_kg = -1.0 (set on the command line)", "it must be greater than 0"],
        ),
        ("sun_kg", math.nan, ["mass.sun_kg = nan (set on the command line)", "finite"]),
        ("samples", 8.5, ["objective.samples = 8.5 (set on the command line)", "a whole number"]),
        (
            "bounds.R3_mm[0]",
            32.0,
            ["bounds.R3_mm = [32.0, 31.01] (set on the command line)", "lower less than"],
        ),
        ("rise_delta_deg[1]", 120.0, ["cam.rise_delta_deg = [130.0, 120.0] (set", "start < end"]),
    ],
)
def test_invalid_changes_are_refused(name: str, value: float, words: list[str]) -> None:
    message = refusal("wang2017", {name: value})
    assert message.startswith("wang2017: ")
    for word in words:
        assert word in message


def test_ambiguous_name_lists_candidates(tmp_path: Path) -> None:
    path = tampered(tmp_path, "design", "m31", "m31 = 1.5\nsun_kg = 2.0")
    path.write_text(
        path.read_text().replace("[bounds]", "[bounds]\nsun_kg = [1, 3]\n#"), encoding="utf-8"
    )
    message = refusal(path, {"sun_kg": 1.0})
    assert f"{path}: sun_kg = 1.0" in message
    assert "name one of mass.sun_kg, design.sun_kg" in message
    assert load(path, {"design.sun_kg": 1.0}).design["sun_kg"] == 1.0


# --- values that are refused
# -----------------------------------------------------------------------

REFUSED = [
    ("mass", "sun_kg", "-0.4", "it must be greater than 0"),
    ("mass", "half_C2_kg", "nan", "it must be a finite number"),
    ("mass", "half_C2_kg", "true", "it must be a number"),
    ("operation", "gravity_m_s2", "-9.81", "it must be at least 0"),
    ("contact", "pressure_angle_deg", "45", "it must be less than 45"),
    ("contact", "tooth_friction_angle_deg", "20.0", "it must be less than pressure_angle_deg = 20"),
    ("inertia", "J56_about_A1_kg_m2", "5.3e-06", "mass times squared centroid distance, 5.4e-06"),
    (
        "inertia",
        "C1_centroidal_xx_yy_zz_kg_m2",
        "[2e-05, 4e-05, 7e-05]",
        "none of the three may exceed the sum of the other two",
    ),
    ("inertia", "C1_centroidal_xx_yy_zz_kg_m2", "[2e-05, 4e-05]", "it must be a list of 3 numbers"),
    ("cam", "psi0_deg", "72.0", "it must be less than 90 - opening_deg = 72"),
    ("cam", "rise_delta_deg", "[130.0, 130.0]", "0 <= start < end <= 360"),
    ("cam", "fall_delta_deg", "[246.0, 361.0]", "0 <= start < end <= 360"),
    (
        "cam",
        "fall_delta_deg",
        "[170.0, 296.0]",
        "it must start where the rise has ended, at 180 or later",
    ),
    (
        "cam",
        "flank",
        '"cycloid"',
        "it must be one of '3-4-5 polynomial', '4-5-6-7 polynomial', 'cyc",
    ),
    ("stage1", "family", '""', "it must not be empty"),
    ("bounds", "R3_mm", "[31.01, 30.46]", "it must be [lower, upper] with lower less than upper"),
    ("objective", "samples", "7", "it must be at least 8"),
    ("objective", "samples", "90.5", "it must be a whole number"),
    ("objective", "kind", '"si"', "it must be 'paper' or 'newton'"),
    ("genetic_algorithm", "bits_per_variable", "53", "it must be at most 52"),
    ("genetic_algorithm", "crossover_probability", "1.5", "it must be at most 1"),
    (
        "origin",
        "speed_rpm",
        '"guessed"',
        "it must start with paper, assumed, calibrated, measured or optimised",
    ),
    ("origin", "speed_rpm", "1", "it must be text in quotes"),
]


@pytest.mark.parametrize(("section", "key", "value", "allowed"), REFUSED)
def test_refused_value_names_file_key_and_rule(
    tmp_path: Path, section: str, key: str, value: str, allowed: str
) -> None:
    path = tampered(tmp_path, section, key, f"{key} = {value}")
    message = refusal(path)
    assert message.startswith(f"{path}: {section}.{key} = ")
    stated_value, _, reason = message.partition(" = ")[2].partition(": ")
    assert stated_value.replace('"', "") == value.replace('"', "")
    assert allowed in reason


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        ("operation", "speed_rpm", "0.001"),
        ("operation", "gravity_m_s2", "0"),
        ("contact", "pressure_angle_deg", "44.9"),
        ("contact", "tooth_friction_angle_deg", "19.9"),
        ("inertia", "J56_about_A1_kg_m2", "5.5e-6"),
        ("inertia", "C1_centroidal_xx_yy_zz_kg_m2", "[2e-5, 4e-5, 6e-5]"),
        ("cam", "rise_delta_deg", "[0, 246]"),
        ("cam", "fall_delta_deg", "[180, 360]"),
        ("objective", "weight_range", "0"),
        ("origin", "speed_rpm", '"measured on the test bed"'),
    ],
)
def test_values_just_inside_are_accepted(
    tmp_path: Path, section: str, key: str, value: str
) -> None:
    assert load(tampered(tmp_path, section, key, f"{key} = {value}")).name == "wang2017"


@pytest.mark.parametrize(
    ("section", "key", "line", "words"),
    [
        ("mass", "sun_kg", None, ["mass.sun_kg is missing", "in kg"]),
        ("objective", "samples", None, ["objective.samples is missing"]),
        ("bounds", "m31", None, ["bounds.m31 is missing", "[lower, upper]"]),
        ("origin", "default", None, ["origin.default is missing"]),
        ("design", "m31", None, ["bounds.m31 = [1.45, 1.56]:", "[design]: theta_deg"]),
        (
            "mass",
            "sun_kg",
            "sun_g = 400",
            ["mass.sun_g = 400", "did you mean sun_kg?", "; mass.sun_kg is missing"],
        ),
        (
            "mass",
            "sun_kg",
            "sun_kg = 0.4\nextra = 1",
            ["mass.extra = 1", "no such key", "carrier_kg"],
        ),
        (
            "origin",
            "speed_rpm",
            'speed_rmp = "paper"',
            ['origin.speed_rmp = "paper"', "operation.speed_rpm"],
        ),
        (
            "origin",
            "speed_rpm",
            'family = "paper"',
            ['origin.family = "paper"', "stage1.family, stage2.family"],
        ),
        (
            "design",
            "m31",
            'm31 = 1.5\n"a.b" = 1',
            ['design = "a.b"', "letters, digits and underscores"],
        ),
        (
            "mass",
            "sun_kg",
            "sun_kg = -1\nmiddle_kgg = 1",
            ["mass.middle_kgg = 1", "; mass.sun_kg = -1:"],
        ),
        ("mass", "sun_kg", f"sun_kg = 1{400 * '0'}", ["mass.sun_kg = 1000", "number"]),
    ],
)
def test_missing_unknown_and_misspelt_keys(
    tmp_path: Path, section: str, key: str, line: str | None, words: list[str]
) -> None:
    path = tampered(tmp_path, section, key, line)
    message = refusal(path)
    assert message.startswith(f"{path}: ")
    for word in words:
        assert word in message


def test_missing_or_malformed_section_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_text('name = "x"\ndescription = ""\nmass = 3\n', encoding="utf-8")
    message = refusal(path)
    assert message.startswith(f"{path}: operation is missing")
    assert message.endswith("more problems)")
    remaining = re.sub(
        r"(?s)\n\[mass\].*?\n\[inertia\]", "\n[inertia]", examples.example("wang2017")
    )
    path.write_text(f"mass = 3\n{remaining}", encoding="utf-8")
    assert refusal(path).startswith(f"{path}: mass = 3: it must be a table")


def test_file_problems_are_all_listed_up_to_a_limit(tmp_path: Path) -> None:
    path = tampered(tmp_path, "mass", "sun_kg", "sun_kg = -0.4\nextra = 1")
    path.write_text(path.read_text().replace('kind = "paper"', 'kind = "si"'), encoding="utf-8")
    message = refusal(path)
    for fragment in ("mass.extra = 1", "; mass.sun_kg = -0.4", '; objective.kind = "si"'):
        assert fragment in message
    assert message.count(str(path)) == 1
    assert "more problem" not in message
    path.write_text("x = 1\n", encoding="utf-8")
    assert re.search(r"x = 1.*is missing.*\(and \d+ more problems\)$", refusal(path))


def test_every_inconsistent_number_is_reported(tmp_path: Path) -> None:
    """Twice in one section, in two sections, and in what several sections make together."""
    message = refusal(
        "wang2017",
        {
            "rise_delta_deg[0]": 300.0,
            "psi0_deg": 80.0,
            "tooth_friction_angle_deg": 30.0,
            "weight_range": 0.0,
            "weight_variance": 0.0,
        },
    )
    for fragment in (
        "cam.rise_delta_deg = ",
        "cam.psi0_deg = 80.0",
        "tooth_friction_angle_deg = 30.0",
        "objective.weight",
    ):
        assert fragment in message
    assert message.count(": ") == 5
    message = refusal("wang2017", {"J56_about_A1_kg_m2": 1e-9, "J7_about_B1_kg_m2": 1e-9})
    assert message.count("at least mass times squared centroid distance") == 2
    assert message.count("wang2017: ") == 1
    path = tampered(tmp_path, "bounds", "k6", None)
    path.write_text(path.read_text().replace("theta_deg = [", "thet_deg = [", 1), encoding="utf-8")
    message = refusal(path)
    for fragment in ("bounds.k6 is missing", "bounds.theta_deg is missing", "bounds.thet_deg = "):
        assert fragment in message


def test_unmarked_section_checks_are_not_run() -> None:
    """The tampered case of the one before."""

    class Marked(FileSection):
        a: float

        @check
        def _a_is_small(self) -> Problems:
            if self.a > 1:
                yield invalid_value_problem("a", self.a, "it must be small")

    class Unmarked(Marked):
        def _a_is_smaller(self) -> Problems:
            yield invalid_value_problem("a", self.a, "it must be smaller")

    assert Unmarked(a=0.5).a == 0.5
    for kind in (Marked, Unmarked):
        with pytest.raises(ValidationError, match="1 validation error"):
            kind(a=2.0)


@pytest.mark.parametrize(
    ("name", "value", "allowed"),
    [
        ("mass.sun_kg", 1e308, "it must be at most 1e+15"),
        ("operation.gravity_m_s2", 1e16, "it must be at most 1e+15"),
        ("operation.forward_speed_m_s", -1e300, "it must be at least -1e+15"),
        ("cam.base_radius_mm", 1e-300, "it must be at least 1e-15"),
        ("requirements.curvature_radius_min_mm", 1e20, "it must be at most 1e+15"),
    ],
)
def test_extreme_numbers_are_named(name: str, value: float, allowed: str) -> None:
    assert f"{name} = {value!r} (set on the command line): {allowed}" in refusal(
        "wang2017-wide", {name: value}
    )


@pytest.mark.parametrize(
    ("section", "key", "value", "words"),
    [
        (
            "mass",
            "sun_kg",
            '"0,40"',
            "it must be a number without quotes, with a decimal point: 0.40",
        ),
        ("mass", "sun_kg", '"0.40"', "it must be a number, without quotes"),
        (
            "centroid",
            "planet_xy_mm",
            "[20,5, -6,0]",
            "a list of 2 numbers (decimals are written with a point)",
        ),
    ],
)
def test_probable_meaning_is_suggested(
    tmp_path: Path, section: str, key: str, value: str, words: str
) -> None:
    assert words in refusal(tampered(tmp_path, section, key, f"{key} = {value}"))


@pytest.mark.parametrize(
    ("key", "line", "set_"),
    [
        ("sun_kg", "sun_kg = -0.4", 0.4),
        ("sun_kg", "sun_kg = nan", 0.4),
        ("sun_kg", 'sun_kg = "0,4"', 0.4),
        ("samples", "samples = 90.5", 90.0),
    ],
)
def test_a_refused_value_can_be_set_right_on_the_command_line(
    tmp_path: Path, key: str, line: str, set_: float
) -> None:
    path = tampered(tmp_path, "objective" if key == "samples" else "mass", key, line)
    assert f".{key} = " in refusal(path)
    machine = load(path, {key: set_})
    assert machine.si(key) == set_
    assert machine.origin(key) == "set on the command line"
    assert "did you mean mass.sun_kg" in refusal(path, {"sun_kgg": 0.4})
    assert f".{key} = " in refusal(path, {"carrier_kg": 3.0})


def test_names_with_dots_are_set_in_place() -> None:
    table = {"a.b": {"c_mm": 1.0}, "a": {"b": {"d_mm": 2.0}}}
    changed = paths.with_values(table, {("a.b", "c_mm"): 3.0})
    assert changed == {"a.b": {"c_mm": 3.0}, "a": {"b": {"d_mm": 2.0}}}


def test_large_file_is_refused_in_linear_time(tmp_path: Path) -> None:
    path = tampered(
        tmp_path, "design", "m31", "m31 = 1.5\n" + "\n".join(f"n{i} = {i}" for i in range(4000))
    )
    text = path.read_text().replace(
        "\n[origin]\n", "\n[origin]\n" + "".join(f'n{i} = "paper"\n' for i in range(4000))
    )
    path.write_text(text, encoding="utf-8")
    begun = time.process_time()
    assert "bounds.n0 is missing" in refusal(path)
    many = path.read_text().replace(
        "\n[bounds]\n", "\n[bounds]\n" + "".join(f"m{i} = [0, 1]\n" for i in range(300))
    )
    path.write_text(many, encoding="utf-8")
    refusal(path)
    assert time.process_time() - begun < 5


# --- files that are refused
# ------------------------------------------------------------------------


def test_misspelt_built_in_name_gets_suggestions() -> None:
    message = refusal("wang2071")
    assert message.startswith("wang2071: ")
    assert "did you mean wang2017?" in message
    assert "compact, wang2017" in message
    with pytest.raises(InputError, match="did you mean compact"):
        examples.example("compac")


def test_unreadable_files_are_refused(tmp_path: Path) -> None:
    assert refusal(tmp_path / "none.toml") == f"{tmp_path / 'none.toml'}: there is no such file"
    assert refusal("none.toml") == "none.toml: there is no such file"
    assert "this is a directory" in refusal(tmp_path)
    assert "this is a device or pipe" in refusal("/dev/zero")
    assert "cannot be read" in refusal("a\0b.toml")
    assert "cannot be read" in refusal(tmp_path / ("x" * 5000))


def test_a_file_without_permission_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "my.toml"
    path.write_text(examples.example("compact"), encoding="utf-8")

    def denied(*_: object, **__: object) -> None:
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("planter.text_files.open", denied, raising=False)
    message = refusal(path)
    assert str(path) in message
    assert "cannot be read (Permission denied)" in message


def test_huge_file_is_refused_and_limit_accepted(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    text = examples.example("compact") + "#"
    path.write_text(text + "x" * (1_000_000 - len(text)), encoding="utf-8")
    assert load(path).name == "compact"
    path.write_text(text + "x" * (1_000_001 - len(text)), encoding="utf-8")
    assert refusal(path) == f"{path}: the file is too large, it must not exceed 1000000 bytes"


def test_non_utf_8_text_is_refused_with_line(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_bytes(b'name = "x"\ndescription = "\xff"\n')
    assert refusal(path) == f"{path}: line 2 is not UTF-8 text, which it must be"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ('name = "x"\nspeed 40\n', ["line 2", "not valid TOML"]),
        ("[mass]\nsun_kg = 1\nsun_kg = 2\n", ["line 3", "not valid TOML"]),
        ("[mass", ["end of document", "not valid TOML"]),
        ("a = " + "[" * 100_000, ["nested too deep"]),
        ("a = " + "9" * 10_000, ["too many digits"]),
        ("a = 0x" + "f" * 3600, ["a = 0xfff", "fewer digits"]),
        (".".join("a" * 20_000) + " = 1", ["line 1", "nested too deep"]),
        ("[" + ".".join("a" * 100_000) + "]", ["line 1", "nested too deep"]),
        ("a = " + "{a = " * 17 + "1" + "}" * 17, ["nested too deep"]),
        (9 * "a." + "a = {" + 9 * "a." + "a = 1}", ["nested too deep"]),
        ('a = "' + "k" * 201 + '"\n' + "k" * 201 + " = 1", ["the name kkk", "200 characters"]),
        ("a = [" + "1," * 10_000 + "]", ["too many values"]),
        ("x = 1,20", ["line 1", "with a decimal point: 1.20"]),
        (
            'name = "' + "a.[{" * 100 + '" # ' + "[[[" * 100 + "\nx = 1,20",
            ["line 2", "with a decimal point: 1.20"],
        ),
    ],
)
def test_broken_toml_is_refused_with_place(tmp_path: Path, text: str, words: list[str]) -> None:
    path = tmp_path / "my.toml"
    path.write_text(text, encoding="utf-8")
    message = refusal(path)
    assert message.startswith(f"{path}: ")
    for word in words:
        assert word in message


def test_control_characters_of_a_file_do_not_reach_the_message(tmp_path: Path) -> None:
    path = tampered(tmp_path, "mass", "sun_kg", 'sun_kg = 0.4\n"a\\nb\\u001b[31m" = 1')
    message = refusal(path)
    assert message.isprintable()
    assert "no such key" in message


def test_name_is_a_single_printable_line(tmp_path: Path) -> None:
    for name in ("a\\nb", "a\\u001b[31m", "\\u202eabc"):
        path = tmp_path / "my.toml"
        path.write_text(
            examples.example("compact").replace('name = "compact"', f'name = "{name}"'),
            encoding="utf-8",
        )
        message = refusal(path)
        assert "name = " in message
        assert message.isprintable()


def test_raw_control_characters_are_refused_with_their_line(tmp_path: Path) -> None:
    path = tmp_path / "my.toml"
    path.write_bytes(b"a = 1\n# \x1b[31m\n")
    assert refusal(path) == f"{path}: line 2 holds the control character '\\x1b', which it must not"


def test_misspelt_family_gets_suggestion(tmp_path: Path) -> None:
    path = tampered(tmp_path, "stage1", "family", 'family = "elipse"')
    with pytest.raises(InputError, match=r'stage1.family = "elipse": did you mean ellipse\?'):
        Device(load(path))


def test_files_of_other_kinds_are_recognised(tmp_path: Path) -> None:
    hint = "it must be one of compact, wang2017, wang2017-wide or the path of a .toml file"
    assert (
        refusal("shi2021")
        == f"shi2021: this is a built-in TOML file for planter design clutch, but {hint}"
    )
    assert "built-in CSV file for planter design synthesise, design train" in refusal(
        "sun2019-curve"
    )
    path = tmp_path / "my.toml"
    path.write_text(examples.example("yu2023", suffix=".toml") + "\n[extra]\n", encoding="utf-8")
    assert refusal(path).startswith(
        f"{path}: this is a file for planter design pickup, but it must be one like compact"
    )
    path = tmp_path / "poses.csv"
    assert "this is a .csv file, but it must be a .toml file" in refusal(path)
    assert "no built-in machine of that name" in refusal("n" * 300)
