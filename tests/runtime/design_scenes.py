"""Scenes whose masses, lengths, points and axes are formulas of parameters."""

from __future__ import annotations

PENDULUM = """
name = "pendulum"
unit = "cm"
gravity = [0, 0, -981]
outputs = ["positions", "accelerations", "reactions", "energies"]
[parameters]
m = 2.0
L = 150
[bodies.bar]
position = [0, 0, 0]
mass = "m"
center = ["L/2", 0, 0]
inertia = { xx = 100, yy = "m*L^2/12", zz = "m*L^2/12" }
[joints.hinge]
type = "revolute"
bodies = ["ground", "bar"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[0, 1, 0], [0, 1, 0]]
"""

FOUR_BAR = """
name = "four_bar"
unit = "m"
gravity = [0, -9.81, 0]
outputs = ["positions", "accelerations", "reactions", "energies"]
[parameters]
a = 1.0
b = 3.0
c = 2.5
g = 3.2
rho = 1.3
[bodies.crank]
position = [0, 0, 0]
orientation = { axis = [0, 0, 1], angle = 1.0 }
rods = [{ mass = "rho*a", ends = [[0, 0, 0], ["a", 0, 0]] }]
angular_velocity = [0, 0, 2]
[bodies.coupler]
position = [0.54, 0.84, 0]
orientation = { axis = [0, 0, 1], angle = 0.3 }
rods = [
  { mass = "rho*b", ends = [[0, 0, 0], ["b", 0, 0]] },
  { mass = 0.4, ends = [[0, 0, 0], [0.3, "b/3", 0]] },
]
[bodies.rocker]
position = [3.2, 0, 0]
orientation = { axis = [0, 0, 1], angle = 1.5 }
rods = [{ mass = "rho*c", ends = [[0, 0, 0], ["c", 0, 0]] }]
[joints.A]
type = "revolute"
bodies = ["ground", "crank"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[joints.B]
type = "revolute"
bodies = ["crank", "coupler"]
points = [["a", 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[joints.C]
type = "revolute"
bodies = ["coupler", "rocker"]
points = [["b", 0, 0], ["c", 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[joints.D]
type = "revolute"
bodies = ["ground", "rocker"]
points = [["g", 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
"""

LOOP = """
name = "loop"
unit = "m"
gravity = [0, 0, -9.81]
outputs = ["positions", "accelerations", "reactions", "energies"]
[parameters]
r = 2.0
h = 1.0
m = 1.0
ax = 0.05
s = 0.4
[bodies.crank]
position = [0, 0, 0]
mass = 1.5
center = [0, "h/2", 0]
inertia = { xx = 0.125, yy = 0.1, zz = 0.125 }
angular_velocity = [1, 0, 0]
[bodies.coupler]
position = [0, 1, 0]
mass_points = [
  { mass = "m", at = [0, 0, 0] },
  { mass = "4*m", at = [1.5, 0.5, 0] },
  { mass = "m", at = [3, 1, 0] },
]
boxes = [{ mass = "m", size = ["s", 0.1, 0.2], at = [1.5, 0.5, 0] }]
[bodies.rocker]
position = [3, 0, 0]
orientation = { quaternion = [1, 0, 0, 1], order = "wxyz" }
cylinders = [{ mass = "m", radius = "s", ends = [[0, 0, 0], ["r", 0, 0]] }]
spheres = [{ mass = "m/2", radius = "s/2", at = ["r", 0, 0] }]
[joints.a]
type = "revolute"
bodies = ["ground", "crank"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[1, 0, "ax"], [1, 0, "ax"]]
[joints.b]
type = "spherical"
bodies = ["crank", "coupler"]
points = [[0, "h", 0], [0, 0, 0]]
[joints.c]
type = "universal"
bodies = ["coupler", "rocker"]
points = [[3, 1, 0], ["r", 0, 0]]
axes = [[1, -3, 0], [0, 0, 1]]
[joints.d]
type = "revolute"
bodies = ["rocker", "ground"]
points = [[0, 0, 0], [3, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
"""

TOP = """
name = "top"
unit = "m"
gravity = ["-tilt", 0, -9.81]
outputs = ["positions", "accelerations", "reactions", "energies"]
[parameters]
I1 = 0.002
I3 = 0.001
h = 0.05
m = 0.4
tilt = 0.5
[bodies.top]
position = [0, 0, 0]
orientation = { angles = [0, 0.3, 0], sequence = "zxz", about = "body" }
angular_velocity_b = [0, 0, 60]
mass = "m"
center = [0, 0, "h"]
inertia = { xx = "I1", yy = "I1", zz = "I3" }
[joints.tip]
type = "ball"
bodies = ["ground", "top"]
points = [[0, 0, 0], [0, 0, 0]]
"""

COUPLED = """
name = "coupled"
unit = "m"
gravity = [0, 0, -9.81]
outputs = ["positions", "accelerations", "reactions", "energies"]
[parameters]
n = 2.0
J = 0.12
e = 0.1
R = 0.3
f = 0.4
p = 0.2
L = 1.0
[bodies.w1]
position = [0, 0, 0]
mass = 1.0
center = ["e", 0.1, 0]
inertia = { xx = 0.1, yy = 0.1, zz = "J", about = ["e/2", 0, 0] }
[bodies.w2]
position = [1, 0, 0]
mass = 2.0
inertia = { xx = 0.3, yy = 0.3, zz = 0.5 }
[bodies.rack]
position = [0, 0.3, 0]
mass = "f"
inertia = { xx = 0.3, yy = 0.3, zz = 0.5 }
[bodies.nut]
position = [0, 0, 2]
mass = 1.0
inertia = { xx = 0.1, yy = 0.2, zz = 0.1 }
[bodies.slide]
position = [0, 2, 0]
mass = "f"
inertia = { xx = 0.3, yy = 0.3, zz = 0.5 }
[bodies.bob]
position = [1, 2, 1]
mass = "f"
point = true
[joints.a]
type = "revolute"
bodies = ["ground", "w1"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[joints.b]
type = "revolute"
bodies = ["ground", "w2"]
points = [[1, 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[joints.mesh]
type = "gear"
joints = ["a", "b"]
ratio = "-n"
[joints.c]
type = "prismatic"
bodies = ["ground", "rack"]
points = [[0, 0.3, 0], [0, 0, 0]]
axes = [[1, 0, 0], [1, 0, 0]]
[joints.pinion]
type = "rack_and_pinion"
joints = ["a", "c"]
radius = "R"
[joints.thread]
type = "screw"
bodies = ["ground", "nut"]
points = [[0, 0, 2], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
pitch = "p"
[joints.way]
type = "prismatic"
bodies = ["ground", "slide"]
points = [[0, 2, 0], [0, 0, 0]]
axes = [["L", 0, 0.5], ["L", 0, 0.5]]
[joints.sum]
type = "linear"
coordinates = ["turn", "shift"]
factors = [1, "-f"]
[joints.rope]
type = "rod"
bodies = ["slide", "bob"]
points = [[0, 0, 1], [0, 0, 0]]
length = "L"
[coordinates.turn]
joint = "a"
[coordinates.shift]
joint = "way"
[forces.spring]
type = "spring_damper"
bodies = ["ground", "slide"]
points = [["-L", 0, 0.5], ["e", 0.1, 0]]
stiffness = "30*f"
damping = 0.5
[forces.push]
type = "force"
body = "nut"
point = ["e", 0, 0]
force = [0, 3, 1]
"""

BELL = """
name = "bell"
unit = "m"
gravity = [0, 0, -9.81]
outputs = ["positions", "accelerations", "reactions", "energies"]
[parameters]
a = 1.0
b = 0.5
m = 2.0
[bodies.bell]
position = [0, 0, 0]
rods = [
  { mass = "m*a", ends = [[0, 0, 0], ["a", 0, 0]] },
  { mass = "m*b", ends = [[0, 0, 0], [0, "b", 0]] },
]
[joints.cross]
type = "universal"
bodies = ["ground", "bell"]
points = [[0.2, 0, 0], [0.2, 0, 0]]
axes = [[1, 0, 0], [0, 1, 0]]
[forces.mount]
type = "bushing"
bodies = ["ground", "bell"]
points = [[0.5, 0.5, 0.5], ["a/2", "b", 0]]
stiffness = [1, 2, 3, 0.4, 0.5, 0.6]
damping = [1, 0, 0, 0, 0, 0]
[forces.wind]
type = "torque"
body = "bell"
torque_b = [0.1, "0.2*a", 0.3]
"""

DRIVEN = """
name = "driven"
unit = "m"
gravity = [0, -9.81, 0]
outputs = ["positions", "accelerations", "reactions", "energies"]
[parameters]
a = 1.0
b = 3.0
w = 3.0
[bodies.crank]
position = [0, 0, 0]
mass = 1.0
center = ["a/2", 0, 0]
inertia = { xx = 0.1, yy = 0.1, zz = "a^2/12" }
[bodies.rod]
position = [1, 0, 0]
mass = "b"
center = ["b/2", 0, 0]
inertia = { xx = 0.1, yy = 1.1, zz = 1.05 }
[bodies.piston]
position = [4, 0, 0]
mass = 1.0
inertia = { xx = 0.1, yy = 0.1, zz = 0.1 }
[joints.A]
type = "revolute"
bodies = ["ground", "crank"]
at = [0, 0, 0]
axis = [0, 0, 1]
[joints.B]
type = "revolute"
bodies = ["crank", "rod"]
points = [["a", 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[joints.C]
type = "revolute"
bodies = ["rod", "piston"]
points = [["b", 0, 0], [0, 0, 0]]
axes = [[0, 0, 1], [0, 0, 1]]
[joints.D]
type = "prismatic"
bodies = ["ground", "piston"]
points = [[0, 0, 0], [0, 0, 0]]
axes = [[1, 0, 0], [1, 0, 0]]
[drivers.motor]
joint = "A"
value = "0.3 + w*t"
"""

MIXED = """
name = "mixed"
unit = "m"
gravity = [0, 0, -9.81]
outputs = ["positions", "accelerations", "reactions", "energies"]
[parameters]
u = 0.3
g = 1.1
[bodies.a]
position = [0, 0, 0]
mass = 1.0
center = ["u", 0.2, 0.1]
inertia = { xx = 0.4, yy = 0.5, zz = 0.6, xy = 0.01 }
[bodies.b]
position = [1, 0, 0]
mass = "g"
center = [0.1, 0.2, 0.3]
inertia = { xx = "0.4*g", yy = "0.5*g", zz = "0.6*g", xy = "0.05*g", yz = "0.02*g", zx = "0.01*g" }
[bodies.c]
position = [2, 0.3, 0]
mass = "g"
inertia = { xx = 1, yy = 1.1, zz = "g" }
[joints.j1]
type = "revolute"
bodies = ["ground", "a"]
at = ["u", 0, 0]
axis = [0, "u", 1]
[joints.j2]
type = "universal"
bodies = ["a", "b"]
points = [[1, 0, "u"], [0, 0, "u"]]
axes = [[0, 1, 0], [0, 0, 1]]
[joints.j3]
type = "cylindrical"
bodies = ["b", "c"]
points = [[1, 0.3, 0], [0, 0, 0]]
axes = [["u", 0, 1], ["u", 0, 1]]
zero = [[1, "u", 0], [1, "u", 0]]
[coordinates.len]
bodies = ["ground", "b"]
points = [["u", 3, 0], ["g", 0, 0]]
[coordinates.pl]
body = "c"
point = ["u", 0, 0]
along = [1, "g", 0]
[coordinates.ang]
joint = "j3"
of = "angle"
[forces.s1]
type = "along"
coordinate = "pl"
force = "-3*u*sin(pl)"
[forces.s2]
type = "rotational_spring_damper"
joint = "j1"
stiffness = "4*g"
damping = 0.2
[forces.s3]
type = "friction"
joint = "j2"
damping = "0.1*g"
of = "angle"
[forces.s4]
type = "spring_damper"
bodies = ["ground", "c"]
points = [[0, "u", 1], ["g", 0, 0]]
stiffness = 3
[forces.s5]
type = "force"
body = "b"
point = ["u", "g", 0]
force_b = [1, "u*t", 0]
[forces.s6]
type = "spring_damper"
bodies = ["ground", "a"]
points = [["u", 3, 0], ["g", 0, 0]]
tension = "4*x + 0.3*v + u"
"""

SCENES = {
    "pendulum": PENDULUM,
    "four_bar": FOUR_BAR,
    "loop": LOOP,
    "top": TOP,
    "coupled": COUPLED,
    "bell": BELL,
    "driven": DRIVEN,
    "mixed": MIXED,
}
