"""Calls with a word that nobody should type: any word where an answer is quick, else one that
cannot be meant.
"""

from __future__ import annotations

from hypothesis import strategies as st

from tests.attack.files import NUMBERS, PIECES

Call = tuple[str, ...]

QUICK: tuple[Call, ...] = (
    ("validate", "wang2017", "--set"),
    ("validate", "compact", "--speed-rpm"),
    ("validate",),
    ("simulate",),
    ("clutch", "rotor", "--vertices"),
    ("clutch", "geometry", "shi2021", "--set"),
    ("clutch", "geometry"),
    ("clutch", "field"),
    ("clutch", "field", "--goal"),
    ("clutch", "design", "shi2021", "--shaft-mm"),
    ("synthesise", "sun2019", "--set"),
    ("synthesise",),
    ("explain",),
    ("example",),
    ("schema",),
    ("cite",),
    ("help",),
    ("turn",),
    ("move",),
    ("sweep",),
    ("train",),
    ("train", "sun2019-curve", "--crank-mm"),
    ("train", "sun2019-curve", "--centre-distance-mm"),
    ("audit",),
    ("derive",),
    ("pickup",),
    ("optimise",),
    ("gears",),
    ("compare",),
    ("prove",),
    ("tolerance",),
    ("calibrate",),
    ("export", "motion"),
    (),
)
"""Calls that want one more word, whatever it is."""
SLOW: tuple[Call, ...] = (
    ("simulate", "wang2017", "--at"),
    ("simulate", "wang2017", "--samples"),
    ("simulate", "wang2017", "--model"),
    ("sensitivity", "wang2017", "--samples"),
    ("optimise", "wang2017", "--starts"),
    ("optimise", "wang2017", "--samples"),
    ("optimise", "wang2017", "--method"),
    ("optimise", "wang2017", "--seed"),
    ("compare", "wang2017", "--pair"),
    ("compare", "wang2017", "--starts"),
    ("calibrate", "wang2017", "--target"),
    ("tolerance", "wang2017", "--samples"),
    ("tolerance", "wang2017", "--tolerances"),
    ("gears", "wang2017", "--teeth"),
    ("gears", "wang2017", "--module"),
    ("clutch", "engage", "shi2021", "--mode"),
    ("clutch", "engage", "shi2021", "--shape"),
    ("clutch", "optimise", "shi2021", "--starts"),
    ("export", "motion", "wang2017", "--format"),
    ("export", "fmu", "wang2017", "--fmi"),
    ("pickup", "yu2023", "--at"),
    ("pickup", "yu2023", "--set"),
    ("cam", "wang2017", "--roller-mm"),
    ("drive", "compact", "--stall-Nm"),
    ("animate", "wang2017", "--model"),
    ("studio", "--port"),
)
"""Calls that go on for long with a word that can be meant."""

_SETTINGS = st.tuples(
    st.sampled_from(("mass.sun_kg", "design.R3_mm", "x", "")), st.sampled_from(NUMBERS)
).map("=".join)
ANY = st.one_of(
    st.sampled_from((*NUMBERS, *PIECES)),
    st.text(max_size=12),
    st.floats().map(str),
    st.integers().map(str),
    _SETTINGS,
)
_LETTERS = st.characters(codec="utf-8", exclude_categories=("N",), exclude_characters="-/")
NONE = st.one_of(
    st.sampled_from(
        [word for word in (*NUMBERS, *PIECES) if not any(sign.isdigit() for sign in word)]
    ),
    st.text(_LETTERS, min_size=1, max_size=12).map("!{}".format),
)
"""Words that are no number, no name and no file."""
CALLS: st.SearchStrategy[Call] = st.one_of(
    st.tuples(st.sampled_from(QUICK), ANY), st.tuples(st.sampled_from(SLOW), NONE)
).map(lambda parts: (*parts[0], parts[1]))
