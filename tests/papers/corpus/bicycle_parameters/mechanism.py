"""Geometry and inertia of a bicycle as they are measured: lines through pendulums, periods, and
errors of results.

Errors are standard deviations of independent measurements, to first order: the root of the sum of
squares of each partial derivative times its error.
"""

from collections.abc import Mapping

from sympy import Expr, cos, pi, sqrt

from derive import Mechanism, Quantity, Y, Z, displacement, quantities

q = quantities("""
    g     | m/s2    | free fall                                      | 9.81
    lam   | rad     | tilt of the steering axis                      | 0.32
    w     | m       | wheel base                                     | 1.1
    r_R   | m       | radius of the rear wheel                       | 0.34
    r_F   | m       | radius of the front wheel                      | 0.33
    f_o   | m       | offset of the fork                             | 0.06
    l_1   | m       | hub to handlebar, across the steering axis     | 0.05
    l_2   | m       | hub to handlebar, along the steering axis      | 0.7
    a     | m       | pendulum axis to hub                           | 0.3
    beta  | rad     | turn of the frame as it hangs                  | 0.6
    D_2   | m       | diameter of the rear dummy axle                | 0.01
    D_3   | m       | diameter of the front dummy axle               | 0.012
    D_5   | m       | diameter of an axle of the fork                | 0.011
    D_6   | m       | diameter of the clamp's bolt                   | 0.009
    x_B   | m       | centroid of the rear frame, forward            | 0.3
    z_B   | m       | centroid of the rear frame, down               | -0.5
    x_H   | m       | centroid of the fork, forward                  | 0.9
    z_H   | m       | centroid of the fork, down                     | -0.7
    m_w   | kg      | wheel                                          | 1.5
    l_w   | m       | support to centroid of the wheel               | 0.28
    I_yy  | kg m2   | wheel about its axle                           | 0.09
    I_xx  | kg m2   | wheel across its axle                          | 0.05
    k     | N m     | torsional pendulum                             | 5
    I_Bxx | kg m2   | rear frame                                     | 0.5
    I_Bzz | kg m2   | rear frame                                     | 0.9
    I_Bxz | kg m2   | rear frame                                     | -0.2
    s_rF  | m       | error of the radius of the front wheel         | 0.002
    s_rR  | m       | error of the radius of the rear wheel          | 0.002
    s_fo  | m       | error of the offset of the fork                | 0.001
    s_lam | rad     | error of the tilt                              | 0.004
    s_beta | rad    | error of the turn                              | 0.005
    s_a   | m       | error of the distance to the pendulum axis     | 0.001
    s_w   | m       | error of the wheel base                        | 0.002
""")

m = Mechanism("bicycle_parameters", q, gravity=(0, 0, q.g), spatial=True)


def combine_errors(expr: Expr, errors: Mapping[Quantity, Quantity]) -> Expr:
    """Return the standard deviation of an expression, to first order in the errors of its
    variables.
    """
    return sqrt(sum((expr.diff(variable) * error) ** 2 for variable, error in errors.items()))


# The bicycle stands upright; the steering axis passes behind the front hub by the offset of the
# fork.
tilted = m.frame("tilted", q.lam, Y)
hub_R, hub_F = (
    m.point("hub_R", m.O, m.world, 0, 0, -q.r_R),
    m.point("hub_F", m.O, m.world, q.w, 0, -q.r_F),
)
axis_point = m.point("axis_point", hub_F, tilted, -q.f_o)
height = -m.position(axis_point)[2]
foot = m.point("foot", axis_point, tilted, 0, 0, height / cos(q.lam))
m.name_("c", "m", "trail", m.position(foot)[0] - q.w)
m.name_(
    "s_c",
    "m",
    "error of the trail",
    combine_errors(
        m.position(foot)[0] - q.w,
        {
            q.r_F: q.s_rF,
            q.f_o: q.s_fo,
            q.lam: q.s_lam,
        },
    ),
)
rear, front = displacement(hub_R, axis_point, tilted), displacement(hub_R, hub_F, tilted)
m.name_("d_1", "m", "rear hub to steering axis, across it", rear[0])
m.name_("d_2", "m", "between the hubs, along the steering axis", front[2])
m.name_("d_3", "m", "steering axis to front hub, across it", q.f_o)

# On the table the fork is turned about, so that both hubs lie on one side of the steering axis.
fork = m.frame("fork", pi, Z, tilted)
turned_hub = m.point("turned_hub", m.point("level", axis_point, tilted), fork, q.f_o)
m.name_(
    "d",
    "m",
    "gap between the dummy axles",
    sqrt(sum(part**2 for part in displacement(hub_R, turned_hub, tilted).components))
    - (q.D_2 + q.D_3) / 2,
)

# The handlebar lies up along the steering axis from the front hub, and forward across it.
handlebar = displacement(hub_F, m.point("handlebar", hub_F, tilted, q.l_1, 0, -q.l_2), m.world)
m.name_("u_1", "m", "front hub to handlebar, backward", -handlebar[0])
m.name_("u_2", "m", "front hub to handlebar, up", -handlebar[2])
m.name_("l", "m", "over axle and bolt", sqrt(q.l_1**2 + q.l_2**2) + (q.D_5 + q.D_6) / 2)

# A line through the hanging frame, as the frame sees it while the bicycle stands.
hanging = m.frame("hanging", q.beta, Y)
way = m.vector(hanging, 1).resolved(m.world)
slope = way[2] / way[0]
m.name_("slope", "1", "slope of the pendulum's axis", slope)
m.name_("s_slope", "1", "error of the slope", combine_errors(slope, {q.beta: q.s_beta}))
for part, hub, errors in (
    ("B", hub_R, {q.a: q.s_a, q.r_R: q.s_rR, q.beta: q.s_beta}),
    ("H", hub_F, {q.a: q.s_a, q.r_F: q.s_rF, q.beta: q.s_beta, q.w: q.s_w}),
):
    on_axis = m.position(m.point(f"on_axis_{part}", hub, hanging, 0, 0, -q.a))
    intercept = on_axis[2] - slope * on_axis[0]
    m.name_(
        f"b_{part}", "m", "height of the pendulum's axis over the rear contact, down", intercept
    )
    m.name_(f"s_b{part}", "m", "error of the height", combine_errors(intercept, errors))
for part, hub, forward, down in (("B", hub_R, q.x_B, q.z_B), ("H", hub_F, q.x_H, q.z_H)):
    arm = displacement(hub, m.point(f"centroid_{part}", m.O, m.world, forward, 0, down), m.world)
    m.name_(
        f"l_{part}", "m", "hub to centroid", sqrt(sum(component**2 for component in arm.components))
    )

# Small swings: of a wheel on its rim by its weight, of a wheel and of the frame on a wire.
m.name_(
    "T_swing",
    "s",
    "period of the hanging wheel",
    2 * pi * sqrt((q.I_yy + q.m_w * q.l_w**2) / (q.m_w * q.g * q.l_w)),
)
m.name_("T_wheel", "s", "period of the wheel on the wire", 2 * pi * sqrt(q.I_xx / q.k))
about_wire = m.name_(
    "J_B",
    "kg m2",
    "rear frame about the pendulum's axis",
    sum(
        way[i] * way[j] * inertia
        for i, j, inertia in ((0, 0, q.I_Bxx), (2, 2, q.I_Bzz), (0, 2, q.I_Bxz), (2, 0, q.I_Bxz))
    ),
)
m.name_("T_frame", "s", "period of the frame on the wire", 2 * pi * sqrt(about_wire / q.k))
