"""Scenes of what random ones hold nowhere: one of each, so that draws stay what they are."""

from __future__ import annotations

BODY = "mass = 2.0, inertia = { xx = 0.2, yy = 0.3, zz = 0.4 }, center = [0.1, 0, 0.05]"

#: A body on a plane, which a force draws back along the second direction there.
PLANE = """
unit = "m"
gravity = [3, 4, -8]
outputs = ["accelerations", "coordinates", "reactions"]
[bodies]
b = { position = [0.2, 0.1, 0], velocity = [0.4, -0.6, 0], BODY }
[joints]
table = { type = "planar", bodies = ["ground", "b"], at = [0.2, 0.1, 0], axis = [0, 0, 1], \
zero = [[1, 0, 0], [1, 0, 0]] }
[coordinates]
x = { joint = "table", of = "displacement" }
y = { joint = "table", of = "second_displacement" }
[forces]
back = { type = "along", coordinate = "y", force = "-20*y - 0.5*y_dot + x" }
[events]
down = { when = "y + 0.01", direction = "falling" }
"""

#: A nut without a thread that a driver moves along its rod, free to turn about it.
ALONG = """
unit = "mm"
gravity = [0, -9810, 0]
outputs = ["coordinates", "energies"]
[bodies]
b = { position = [100, 0, 0], mass = 2.0, inertia = { xx = 2e4, yy = 3e4, zz = 4e4 }, \
center = [0, 0, 50] }
[joints]
rod = { type = "cylindrical", bodies = ["ground", "b"], at = [100, 0, 0], axis = [1, 0, 0] }
[coordinates]
turn = { joint = "rod", of = "angle" }
[drivers]
motor = { joint = "rod", of = "displacement", value = "200*sin(3*t)" }
"""

#: A pendulum on a shaft that an input turns, not from where it is written on.
FROM = """
unit = "m"
gravity = [0, -9.81, 0]
divisions = 20
outputs = ["accelerations", "reactions", "energies"]
[bodies]
a = { position = [0, 0, 0], BODY }
[joints]
pin = { type = "revolute", bodies = ["ground", "a"], at = [0, 0, 0], axis = [0, 0, 1] }
[inputs]
motor = { joint = "pin", from = "20 deg", turns = 0.125, rate = 2, acceleration = 1.5 }
"""

#: A swinging body whose far end has a height, which a force knows.
POINT = """
unit = "m"
gravity = [0, -9.81, 0]
outputs = ["accelerations", "coordinates"]
[bodies]
b = { position = [0.1, 0.2, 0.3], angular_velocity_b = [0.5, 1, -1], BODY }
[joints]
ball = { type = "spherical", bodies = ["ground", "b"], at = [0, 0, 0] }
[coordinates]
height = { body = "b", point = [0.4, -0.2, 0.1], along = [1, 2, 0] }
[forces]
wind = { type = "force", body = "b", force_b = ["3*height", "-height_dot", 0.5] }
lift = { type = "along", coordinate = "height", force = "2 - height^2" }
[events]
low = { when = "height - 0.1*t", direction = "both", action = "record" }
"""

#: A point that a star draws, by its distance, and what happens at one.
DISTANCE = """
unit = "m"
outputs = ["accelerations", "coordinates"]
[bodies]
b = { position = [0.5, 0.1, 0], velocity = [-0.8, 1.2, 0.3], point = true, mass = 1.5 }
[coordinates]
x = { body = "b", along = [1, 0, 0] }
y = { body = "b", along = [0, 1, 0] }
[forces]
star = { type = "force", body = "b", \
force = ["-2*x/(x^2 + y^2)^1.5", "-2*y/(x^2 + y^2)^1.5", "0.3*(x^2 + y^2)^0.5"] }
[events]
near = { when = "sqrt(x^2 + y^2) - 0.48", direction = "both" }
"""

RARE = tuple(
    f'name = "rare_{k}"{text}'.replace("BODY", BODY)
    for k, text in enumerate((PLANE, ALONG, FROM, POINT, DISTANCE))
)
"""Scenes that hold what random ones never do."""
