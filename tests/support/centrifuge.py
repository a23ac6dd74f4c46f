"""A paper from outside, with its subject, as the text of a file: `WEIGHT` is a factor that print
may get wrong.
"""

NAME = "centrifuge2024"
TEXT = '''
"""Two masses on opposite arms of a hub, and a paper about them."""

import random

import numpy as np
import sympy as sp

from derive.audit.case import Case
from derive.audit.paper import Cycle, Dynamics, Law, Paper, Subject
from derive.chain import Chain, Solve
from derive.equations import by_claim, defining_equation
from derive.quantity import Quantity


def quantity(name, unit):
    return Quantity(name, unit, "made up", "centrifuge")


m, g, r, w, phi = (quantity(*pair) for pair in (("m", "kg"), ("g", "m/s2"), ("r", "m"), ("w", "rad/s"), ("phi", "rad")))
N, N_2, R = (quantity(name, "N") for name in ("N", "N_2", "R"))


def values(angle):
    side = {m: 2.0, g: 9.81, r: 0.3, w: 20.0, phi: angle}
    one, two = (2.0 * (9.81 - 0.3 * 400 * float(sp.sin(at))) for at in (angle, angle - sp.pi))
    return side | {N: one, N_2: two, R: one + two}


class Centrifuge(Subject):
    def claims(self):
        lift = defining_equation("lift of a mass", N, m * g - m * r * w**2 * sp.sin(phi))
        return by_claim([lift, defining_equation("support of the hub", R, N + N_2)])

    def admissible(self, rng):
        return {symbol: sp.Rational(rng.randint(101, 999), 300) for symbol in (m, g, r, w, phi, N, N_2, R)}

    def reference(self, points):
        return [values(2 * sp.pi * k / points) for k in range(points)]

    def dynamics(self):
        angles = np.linspace(0, 2 * np.pi, 24, endpoint=False)
        one, two = ({s: np.array([float(values(at)[s]) for at in angles - back]) for s in (m, g, r, w, phi)}
                    for back in (0, np.pi))
        law = Law("support is the weight", "N", (R - 2 * m * g,))
        cycle = Cycle((one, two), np.full(24, np.pi / 12))
        return Dynamics((law,), {"reference": cycle}, self.claims(), (), (lambda s: quantity(f"{s.name}_2", s.unit),))


PAPER = Paper("centrifuge2024", "Made up 2024")
PAPER.defines("1", N, WEIGHT * m * g - m * r * w**2 * sp.sin(phi), "lift of a mass")
PAPER.defines("2", R, N + N_2, "support of the hub")
CASE = Case(PAPER, Centrifuge(), (Chain(PAPER.equations, [Solve("1", N)]), Chain(PAPER.equations, [Solve("2", R)])))
'''
