"""A link element written directly on the graph, in the shape of the derived kind ``link``."""

from __future__ import annotations

from kousoku.codegen.graph import Graph
from kousoku.codegen.kernel import Kernel
from kousoku.model.quantity import Quantity

ENDS = Quantity("x", (6,), "m", "x1 y1 β1 x2 y2 β2 of the ends in frame O, (2)")
LENGTH = Quantity("length", (), "m", "design length l0, (8)")
RATES = Quantity("x_dot", (6,), "m/s", "time derivative of x")


def constraint() -> Kernel:
    """Return ε (5)–(7) and D = ∂ε/∂x, which is (15) at any position."""
    g = Graph()
    x = [g.input("x", k) for k in range(6)]
    l0 = g.input("length", 0)
    dx, dy = g.sub(x[3], x[0]), g.sub(x[4], x[1])
    length = g.sqrt(g.add(g.mul(dx, dx), g.mul(dy, dy)))
    cos, sin = g.div(dx, length), g.div(dy, length)
    turned = []
    for beta in (x[2], x[5]):
        c, s = g.cos(beta), g.sin(beta)
        y_part = g.sub(g.mul(s, dx), g.mul(c, dy))
        turned.append(g.atan2(y_part, g.add(g.mul(c, dx), g.mul(s, dy))))
    epsilon = (g.sub(length, l0), g.mul(turned[0], l0), g.neg(g.mul(turned[1], l0)))
    k = g.div(l0, length)
    ks, kc, o = g.mul(k, sin), g.mul(k, cos), g.const(0)
    rows = (
        (g.neg(cos), g.neg(sin), o, cos, sin, o),
        (g.neg(ks), kc, l0, ks, g.neg(kc), o),
        (ks, g.neg(kc), o, g.neg(ks), kc, g.neg(l0)),
    )
    outputs = (
        Quantity("epsilon", (3,), "m", "deformations"),
        Quantity("D", (3, 6), "-", "their derivatives by x"),
    )
    results = (epsilon, tuple(node for row in rows for node in row))
    return Kernel("constraint", "", "", "", (ENDS, LENGTH), outputs, tuple(g.nodes), results)


def rates() -> Kernel:
    """Return Ḋ, the derivative of D along the motion."""
    g = Graph()
    x = [g.input("x", k) for k in range(6)]
    v = [g.input("x_dot", k) for k in range(6)]
    l0 = g.input("length", 0)
    dx, dy = g.sub(x[3], x[0]), g.sub(x[4], x[1])
    vx, vy = g.sub(v[3], v[0]), g.sub(v[4], v[1])
    length = g.sqrt(g.add(g.mul(dx, dx), g.mul(dy, dy)))
    cos, sin = g.div(dx, length), g.div(dy, length)
    stretch = g.add(g.mul(cos, vx), g.mul(sin, vy))
    beta_dot = g.div(g.sub(g.mul(cos, vy), g.mul(sin, vx)), length)
    cos_dot, sin_dot = g.neg(g.mul(sin, beta_dot)), g.mul(cos, beta_dot)
    k = g.div(l0, length)
    relative = g.div(stretch, length)
    ks = g.mul(k, g.sub(sin_dot, g.mul(sin, relative)))
    kc = g.mul(k, g.sub(cos_dot, g.mul(cos, relative)))
    o = g.const(0)
    rows = (
        (g.neg(cos_dot), g.neg(sin_dot), o, cos_dot, sin_dot, o),
        (g.neg(ks), kc, o, ks, g.neg(kc), o),
        (ks, g.neg(kc), o, g.neg(ks), kc, o),
    )
    outputs = (Quantity("D_dot", (3, 6), "1/s", "time derivative of D"),)
    results = (tuple(node for row in rows for node in row),)
    return Kernel("rates", "", "", "", (ENDS, RATES, LENGTH), outputs, tuple(g.nodes), results)
