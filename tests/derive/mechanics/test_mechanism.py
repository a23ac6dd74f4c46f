"""Mechanisms as they are drawn: loops against closed forms, laws on random bars, and what is
refused.
"""

import pytest
import sympy as sp

from derive import Mechanism, X, Y, Z, quantities
from derive.chain import ChainError
from derive.mechanics.loops import LoopError
from derive.mechanics.mechanism import MechanismError
from derive.model import LinearSolve
from derive.quantity import DimensionError, Quantities, TableError

TABLE = """
    phi   | rad   | crank angle
    omega | rad/s | crank speed                | 12
    g     | m/s2  | free fall                  | 9.81
    a     | mm    | crank                      | 40
    b     | mm    | coupler                    | 110
    c     | mm    | rocker                     | 80
    d     | mm    | frame                      | 120
    m_b   | kg    | coupler's mass             | 0.6
    u     | mm    | coupler's centroid, along  | 45
    v     | mm    | coupler's centroid, across | 20
    J_b   | kg m2 | coupler                    | 0.0011
    m_c   | kg    | rocker's mass              | 0.9
    J_c   | kg m2 | rocker                     | 0.0007
"""


def four_bar(pins: str = "OABC") -> Mechanism:
    q = quantities(TABLE)
    m = Mechanism("four_bar", q, angle=q.phi, speed=q.omega, gravity=q.g)
    beta, gamma = (
        m.coordinate("beta", "rad", "coupler angle"),
        m.coordinate("gamma", "rad", "rocker angle"),
    )
    crank, coupler, rocker = (
        m.frame("crank", q.phi),
        m.frame("coupler", beta),
        m.frame("rocker", gamma),
    )
    A, D = m.point("A", m.O, crank, q.a), m.point("D", m.O, m.world, q.d)
    B, end = m.point("B", A, coupler, q.b), m.point("end", D, rocker, q.c)
    m.close(B, end, start={beta: sp.Rational(4, 5), gamma: sp.Rational(8, 5)})
    crank_body = m.body("crank", crank)
    coupler_body = m.body(
        "coupler", coupler, mass=q.m_b, centroid=m.point("G", A, coupler, q.u, q.v), inertia=q.J_b
    )
    three = m.body(
        "rocker", rocker, mass=q.m_c, centroid=m.point("H", D, rocker, q.c / 2), inertia=q.J_c
    )
    for name, on, by, at in (
        ("O", crank_body, m.ground, m.O),
        ("A", coupler_body, crank_body, A),
        ("B", three, coupler_body, end),
        ("C", three, m.ground, D),
    ):
        if name in pins:
            m.pin(name, on, by, at)
    m.motor("M_in", crank_body, m.ground, m.O)
    return m


def test_four_bar_forces_are_solved_together() -> None:
    lane = four_bar().system().lane
    assert lane is not None
    blocks = [step for step in lane.steps if isinstance(step, LinearSolve)]
    assert {str(s) for s in blocks[-1].symbols} == {"F_Bx", "F_By"}, (
        "the two moments that hold the joint between the bars"
    )
    assert lane.speed is not None
    assert str(lane.speed) == "omega"


def test_too_few_bars_say_their_degrees_of_freedom() -> None:
    m = four_bar()
    m.coordinate("s", "m", "a slider that nothing holds")
    with pytest.raises(
        LoopError, match=r"fewer equations \(2: .*\) than .* \(3: beta, gamma, s\): \+1 degree"
    ):
        m.system()


def test_loop_without_coordinate_is_refused() -> None:
    m = four_bar()
    m.coordinate("s", "m", "a slider that nothing holds")
    m.constrain("wrong", m.given.a - m.given.b, start={})
    with pytest.raises(LoopError, match="nothing says where s starts"):
        m.system()


@pytest.mark.parametrize(("pins", "named"), [("OAB", "M_in"), ("ABC", "M_in")])
def test_free_body_error_names_unknowns_and_balances(pins: str, named: str) -> None:
    with pytest.raises((ChainError, MechanismError)):
        four_bar(pins).system()


def test_redundant_joint_error_names_undetermined_forces() -> None:
    m = four_bar()
    bodies = {body.name: body for body in m.bodies}
    m.weld("D", bodies["rocker"], m.ground, m.point("D2", m.O, m.world, m.given.d))
    with pytest.raises(ChainError, match="no set of them is closed"):
        m.system()


def test_a_wrong_dimension_names_the_step() -> None:
    m = four_bar()
    bodies = {body.name: body for body in m.bodies}
    m.force("odd", bodies["rocker"], m.O, m.vector(m.world, m.given.a))
    with pytest.raises(DimensionError, match="rocker: force along x"):
        m.system()


def test_a_coordinate_in_a_wrong_unit_is_named() -> None:
    m = four_bar()
    m.coordinate("z", "m", "no length", equals=m.given.omega * m.given.a)
    with pytest.raises(DimensionError, match="z is in m"):
        m.system()


@pytest.mark.parametrize(("angle", "speed"), [("mm", "r/min"), ("rad", "mm/s"), ("1", "rad/s")])
def test_driving_angle_in_a_wrong_unit_is_refused(angle: str, speed: str) -> None:
    q = quantities(f"phi | {angle} | drive\nomega | {speed} | its speed | 1")
    with pytest.raises(MechanismError, match="driven along an angle"):
        Mechanism("wrong", q, angle=q.phi, speed=q.omega)


def test_frame_turned_by_a_length_is_refused() -> None:
    q = quantities("phi | deg | drive\nomega | r/min | its speed | 1\na | mm | crank | 3")
    m = Mechanism("wrong", q, angle=q.phi, speed=q.omega)
    with pytest.raises(DimensionError, match="frame arm"):
        m.frame("arm", q.phi + q.a)
    with pytest.raises(DimensionError, match="frame arm"):
        m.frame("arm", q.a)


def test_misspelt_report_gets_a_suggestion() -> None:
    with pytest.raises(MechanismError, match="nothing is called F_Bxx; did you mean F_Bx"):
        four_bar().system(reported=["F_Bxx"])


def test_unreported_results_are_not_computed() -> None:
    lane = four_bar().system(reported=["beta"]).lane
    assert lane is not None
    assert [str(q) for q in lane.outputs] == ["beta", "pivot_beta_dot"] or [
        str(q) for q in lane.outputs
    ] == ["beta"]


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("r | mm", "name | unit | meaning"),
        ("r | furlong | crank | 3", "furlong is no unit"),
        ("r | mm | crank | 3,5", "write 3.5"),
        ("r | mm | crank | 3 | 5", "bounds are two numbers"),
        ("r | mm | crank | 3 | 5 4", "lower bound 5 is not below"),
        ("lambda | mm | crank | 3", "word of Python"),
        ("r | mm | crank | 3\n r | mm | crank | 4", "r stands twice"),
    ],
)
def test_invalid_table_line_is_named(line: str, message: str) -> None:
    with pytest.raises(TableError, match="line") as error:
        quantities(line)
    assert message in str(error.value)


def test_table_quantities_by_attribute_and_key() -> None:
    q = quantities("r | mm | crank | 50.0 | 30 80  # measured\n\n phi | rad | angle")
    assert q.r is q["r"]
    assert (q.r.unit, q.r.shown, str(q.data["r"].value)) == ("m", "values.r_mm", "50.0")
    assert list(q) == ["r", "phi"]
    assert list(q.data) == ["r"]
    with pytest.raises(AttributeError, match="no quantity radius; the table has r, phi"):
        q.radius  # noqa: B018


JOINTS = {
    "weld": (0, ()),
    "pin": (1, (Y,)),
    "cylinder": (2, (Y,)),
    "universal": (2, (Y, X)),
    "ball": (3, ()),
    "plane": (3, (Z,)),
    "slide": (1, (X,)),
}
"""Freedoms of a joint in space, and the axes that it is told."""


@pytest.mark.parametrize("joint", JOINTS)
def test_joint_reactions_match_removed_freedoms(joint: str) -> None:
    freedoms, axes = JOINTS[joint]
    m = Mechanism("test", spatial=True)
    getattr(m, joint)("J", m.body("one", m.frame("turned", sp.S.Half, Z)), m.ground, m.O, *axes)
    assert len(m.assembly.unknowns) == 6 - freedoms
    assert len({str(u) for u in m.assembly.unknowns}) == 6 - freedoms


@pytest.mark.parametrize("joint", ["cylinder", "universal", "plane"])
def test_a_joint_of_space_is_refused_in_the_plane(joint: str) -> None:
    m = Mechanism("test")
    with pytest.raises(MechanismError, match="J: a joint of space; say `spatial=True`"):
        getattr(m, joint)("J", m.body("one", m.world), m.ground, m.O, *JOINTS[joint][1])


def test_contact_pushes_and_never_pulls() -> None:
    m = Mechanism("test", spatial=True)
    body = m.body("one", m.world, about=m.O)
    force = m.contact("C", body, m.ground, m.O, m.vector(m.world, 0, 1))
    assert m.pushing == [force]
    assert [e.residual for e in m.equations()] == [force]


def test_balances_state_their_claims() -> None:
    m = four_bar()
    coupler_body = next(body for body in m.bodies if body.name == "coupler")
    balances = [
        m.balance(coupler_body, "force", "x"),
        m.balance(coupler_body, "force", "y"),
        m.balance(coupler_body, "moment"),
    ]
    assert [e.claims for e in m.equations() if e.number.startswith("coupler")] == balances


@pytest.mark.parametrize(("reported", "has_balances"), [("kinetic", False), ("F_Ox", True)])
def test_balances_are_asked_for_where_actions_are_reported(
    reported: str, has_balances: bool
) -> None:
    q = quantities("m | kg | bob | 1\nl | m | rod | 1\ng | m/s2 | free fall | 9.81")
    m = Mechanism("pendulum", q, gravity=q.g)
    rod = m.frame("rod", m.coordinate("a", "rad", "angle"))
    m.pin("O", m.body("bob", rod, q.m, m.point("A", m.O, rod, q.l)), m.ground, m.O)
    assert ("balances" in {form.name for form in m.system([reported]).closed_forms}) == has_balances


def test_unknown_units_are_refused_by_name() -> None:
    m = Mechanism("test")
    with pytest.raises(MechanismError, match="coordinate s: unit = mm: write rad, m, 1"):
        m.coordinate("s", "mm", "place")
    with pytest.raises(DimensionError, match="v: unit = furlong"):
        m.report("v", "furlong", "speed", sp.S.Zero)
    assert m.coordinate("s", "m", "place").unit == "m"


def test_slips_are_refused_along_an_angle() -> None:
    m = four_bar()
    assert m.system().lane is not None
    m.roll("wheel", m.rate(m.given.phi) * m.given.a)
    with pytest.raises(MechanismError, match="slip_wheel: slips vanish in free motion only"):
        m.system()


@pytest.mark.parametrize("name", ["F_Ax", "P_M_in", "psi", "psi_dot"])
def test_name_clash_is_refused_before_the_derivation(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The reverse: a name that nothing else has reaches the derivation."""
    q = quantities(
        f"phi | rad | crank angle\nomega | rad/s | speed | 10\n{name} | N | load of the crop | 3"
    )

    def build_crank(table: Quantities) -> Mechanism:
        m = Mechanism("crank", table, angle=q.phi, speed=q.omega)
        crank = m.body("crank", m.frame("crank", q.phi))
        m.pin("A", crank, m.ground, m.O)
        m.coordinate("psi", "rad", "another angle", equals=2 * q.phi)
        m.motor("M_in", crank, m.ground, m.O)
        return m

    def derive_nothing(*_: object) -> None:
        raise AssertionError

    monkeypatch.setattr("derive.mechanics.mechanism.derive_driven_motion", derive_nothing)
    with pytest.raises(MechanismError, match=rf"{name} \(load of the crop; "):
        build_crank(q).system()
    with pytest.raises(AssertionError):
        build_crank(
            quantities(
                "phi | rad | crank angle\nomega | rad/s | speed | 10\nF | N | load of the crop | 3"
            )
        ).system()
