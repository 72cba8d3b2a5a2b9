"""Laws of forces with a kink, a jump or a narrow part, and what moves under them in closed form."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import random
    from collections.abc import Callable

    import kousoku as ks

    #: By what is compared: what the run has, what is right, and what counts as one.
    Wanted = Callable[[ks.Result], dict[str, tuple[float, float, float]]]
    Drawn = tuple[dict[str, float], Wanted]

END = 10.0
"""When runs end [s]."""
SPEED = 10.0
"""How fast bodies come to a wall [m/s]: it is somewhere within END · SPEED."""
FORCE = 10.0
"""Of a pulse [N]; it acts on 1 kg."""
LENGTH = 1.0
"""Of the scenes [m]: places are known to the tolerance times that, and so are jumps."""


@dataclass(frozen=True, slots=True)
class Form:
    """A scene with a law, and how to draw its place and width.

    Parameters
    ----------
    kind : str
        Pulses, walls …: the row of the page.
    text : str
        The scene.
    draw : callable
        Returns parameters, and what is right.
    number : int
        Random runs of the full size.
    is_led, may_be_fixed, may_be_loose : bool
        Whether drivers determine the motion; whether steps are also fixed, or as long as a
        tolerance of 1e-4 lets them.
    free : float [m/s]
        The speed at the end without the force.
    """

    kind: str
    text: str
    draw: Callable[[random.Random], Drawn]
    number: int = 170
    is_led: bool = False
    may_be_fixed: bool = False
    may_be_loose: bool = False
    free: float = SPEED


BLOCK = """
name = "{name}"
unit = "m"
outputs = ["energies"]
parameters = {{ place = 5.0, width = 1.0, rise = 0.01 }}
[bodies.block]
point = true
position = [0, 0, 0]
mass = 1
[forces.hit]
type = "force"
body = "block"
force = ["{law}", "0", "0"]
"""
TRAPEZOID = "max(0, min(1, (t - place)/(rise*width), (place + width - t)/(rise*width)))"
#: For each law of time with a height of one its integral and centre, in widths from its place on.
PULSES: dict[str, tuple[str, Callable[[float], tuple[float, float]]]] = {
    "trapezoid": (TRAPEZOID, lambda rise: (1.0 - rise, 0.5)),
    "steps": (
        "(sign(t - place) + 1)*(sign(place + width - t) + 1)/4 + 0*rise",
        lambda _: (1.0, 0.5),
    ),
    "triangle": ("max(0, 1 - abs(2*(t - place)/width - 1)) + 0*rise", lambda _: (0.5, 0.5)),
    "half_sine": (
        "sin(pi*max(0, min(1, (t - place)/width))) + 0*rise",
        lambda _: (2.0 / math.pi, 0.5),
    ),
    "gauss": (
        "exp(-(12*(t - place)/width - 6)^2) + 0*rise",
        lambda _: (math.sqrt(math.pi) / 12.0, 0.5),
    ),
    # what varies is below 1e-26
    "tiny_gauss": (
        "exp(60)*exp(-60 - (12*(t - place)/width - 6)^2) + 0*rise",
        lambda _: (math.sqrt(math.pi) / 12.0, 0.5),
    ),
    "tiny_gauss_in_time": (
        "(exp(60)*place/width - exp(60)*(place/width - 1) + 0*t)*exp(-60 - (12*(t - place)/width"
        " - 6)^2) + 0*rise",
        lambda _: (math.sqrt(math.pi) / 12.0, 0.5),
    ),
    "sech": (
        "2/(exp(80*(t - place)/width - 40) + exp(40 - 80*(t - place)/width)) + 0*rise",
        lambda _: (math.pi / 80.0, 0.5),
    ),
    "logistic": (
        "1/(1 + exp(20 - 80*(t - place)/width)) - 1/(1 + exp(60 - 80*(t - place)/width)) + 0*rise",
        lambda _: (0.5, 0.5),
    ),
    # 1 and the integral of exp(1 - exp(u^2)), over 12
    "double_exponential": (
        "exp(1 - exp((12*(t - place)/width - 6)^2)) + 0*rise",
        lambda _: (1.431448207236483 / 12.0, 0.5),
    ),
    "two": (
        f"{TRAPEZOID} + exp(-(24*(t - place)/width - 18)^2)",
        lambda rise: (
            1.0 - rise + math.sqrt(math.pi) / 24.0,
            (0.5 * (1.0 - rise) + 0.75 * math.sqrt(math.pi) / 24.0)
            / (1.0 - rise + math.sqrt(math.pi) / 24.0),
        ),
    ),
}


def pulse(of: Callable[[float], tuple[float, float]]) -> Callable[[random.Random], Drawn]:
    """Function that draws a pulse of time."""

    def draw(random_: random.Random) -> Drawn:
        width = END * 10.0 ** random_.uniform(-6.0, -0.5)
        place, rise = random_.uniform(0.0, END - width), random_.choice((0.3, 0.01, 1e-4))
        integral, centre = of(rise)
        speed = FORCE * width * integral
        way = speed * (END - place - centre * width)

        def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
            block = result.body("block")
            return {
                "speed [m/s]": (block.velocity[-1, 0], speed, speed),
                "position [m]": (block.position[-1, 0], way, speed * END),
            }

        return {"place": place, "width": width, "rise": rise}, wanted

    return draw


CART = """
name = "{name}"
unit = "m"
outputs = ["energies"]
parameters = {{ place = 50.0, width = 1.0, height = 1e4 }}
[bodies.cart]
position = [0, 0, 0]
velocity = [10, 0, 0]
mass = 1
inertia = {{ xx = 1, yy = 1, zz = 1 }}
[joints]
rail = {{ type = "prismatic", bodies = ["ground", "cart"], at = [0, 0, 0], axis = [1, 0, 0] }}
[coordinates]
x = {{ joint = "rail" }}
[forces]
wall = {{ type = "along", coordinate = "x", force = "{law}" }}
"""
#: For each wall from ``place`` on, ``width`` thick and ``height`` high, what it takes to pass it.
WALLS = {
    "triangle_wall": ("-height*max(0, 1 - abs(2*(x - place)/width - 1))", 0.5),
    "step_wall": ("-height*(sign(x - place) + 1)*(sign(place + width - x) + 1)/4", 1.0),
    "cap_wall": ("-height*max(0, 1 - (2*(x - place)/width - 1)^2)", 2.0 / 3.0),
    "gauss_wall": ("-height*exp(-(12*(x - place)/width - 6)^2)", math.sqrt(math.pi) / 12.0),
    "tiny_gauss_wall": (
        "-height*exp(60)*exp(-60 - (12*(x - place)/width - 6)^2)",
        math.sqrt(math.pi) / 12.0,
    ),
    "double_exponential_wall": (
        "-height*exp(1 - exp((12*(x - place)/width - 6)^2))",
        1.431448207236483 / 12.0,
    ),
    "sech_wall": (
        "-2*height/(exp(80*(x - place)/width - 40) + exp(40 - 80*(x - place)/width))",
        math.pi / 80.0,
    ),
    "trapezoid_wall": (
        "-height*max(0, min(1, (x - place)/(0.1*width), (place + width - x)/(0.1*width)))",
        0.9,
    ),
}
#: A ball that goes through two places, between which two forces towards and away from them add up.
BALL = """
name = "{name}"
unit = "m"
outputs = ["energies"]
parameters = {{ place = 50.0, width = 1.0, height = 1e4 }}
[bodies.cart]
point = true
position = [0, 0, 0]
velocity = [10, 0, 0]
mass = 1
[coordinates]
x = {{ body = "cart", along = [1, 0, 0] }}
y = {{ body = "cart", along = [0, 1, 0] }}
"""
#: How far it passes by them, in widths: right there a formula is 0/0.
ASIDE = 1e-6
#: How far the ball is from two places, in formulas and as lengths of springs.
DISTANCES = {
    "distance_wall": f"""[forces.wall]
type = "along"
coordinate = "x"
force = '''height*((x - place - width)/sqrt((x - place - width)^2 + (y + {ASIDE}*width)^2)
- (x - place)/sqrt((x - place)^2 + (y + {ASIDE}*width)^2))'''
""",
    "length_wall": f"""[forces.first]
type = "spring_damper"
bodies = ["ground", "cart"]
points = [["place", "-{ASIDE}*width", 0], [0, 0, 0]]
tension = "height + 0*v"
[forces.second]
type = "spring_damper"
bodies = ["ground", "cart"]
points = [["place + width", "-{ASIDE}*width", 0], [0, 0, 0]]
tension = "0*v - height"
""",
}


def wall(integral: float, *, is_steep: bool, least: float) -> Callable[[random.Random], Drawn]:
    """Function that draws a wall: half throw the cart back, half let it pass and keep a part.

    The least width is a power of ten, in metres of the 100 that the cart would go.
    """

    def draw(random_: random.Random) -> Drawn:
        width = 10.0 ** random_.uniform(least, 0.0)
        place = random_.uniform(1.0, 0.9 * END * SPEED)
        energy = 0.5 * SPEED * SPEED
        part = random_.choice((random_.uniform(0.1, 0.8), 10.0 ** random_.uniform(0.2, 2.0)))
        height = part * energy / (integral * width)
        is_back = part > 1.0

        def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
            cart = result.body("cart")
            speed = -SPEED if is_back else SPEED * math.sqrt(1.0 - part)
            # energy, where it jumps by a height at a place
            allowed = SPEED + is_steep * height * LENGTH / abs(speed)
            free = place + speed * (END - place / SPEED)
            off = cart.position[-1, 0] - free
            beyond = math.copysign(max(0.0, abs(off) - 5.0 * width), off)  # it is slow in the wall
            return {
                "speed [m/s]": (cart.velocity[-1, 0], speed, allowed),
                "position [m]": (free + beyond, free, END * allowed),
            }

        return {"place": place, "width": width, "height": height}, wanted

    return draw


def arctangent_integral(u: float) -> float:
    """Integral of atan from 0 to u."""
    return u * math.atan(u) - 0.5 * math.log1p(u * u)


def arctangents(random_: random.Random) -> Drawn:
    """Draw a wall with edges a hundredth of it wide, which is felt from far away."""
    parameters, _ = wall(1.0, is_steep=True, least=-5.0)(random_)
    place, width, height = (parameters[name] for name in ("place", "width", "height"))
    is_back = height * width > 0.5 * SPEED * SPEED

    def potential(x: float) -> float:
        total = 0.0
        for sign, edge in ((1.0, place), (-1.0, place + width)):
            total += sign * arctangent_integral(100.0 * (x - edge) / width)
        return height * width / (100.0 * math.pi) * total

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        cart = result.body("cart")
        gained = potential(0.0) - potential(cart.position[-1, 0])
        speed = math.sqrt(max(0.0, SPEED * SPEED + 2.0 * gained))
        allowed = SPEED + height * LENGTH / SPEED
        return {"speed [m/s]": (cart.velocity[-1, 0], -speed if is_back else speed, allowed)}

    return parameters, wanted


def rise(random_: random.Random) -> Drawn:
    """Draw a step that is as steep as narrow: what it takes on both sides is felt from far away."""
    width: float = 10.0 ** random_.uniform(-5.0, -1.0)
    place, height = random_.uniform(1.0, 0.5 * END * SPEED), random_.uniform(0.02, 0.2)

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        cart = result.body("cart")
        ends = (0.0, cart.position[-1, 0])
        first, last = (arctangent_integral((x - place) / width) for x in ends)
        work = -height * width * (last - first)
        return {"speed [m/s]": (cart.velocity[-1, 0], math.sqrt(SPEED * SPEED + 2.0 * work), SPEED)}

    return {"place": place, "width": width, "height": height}, wanted


def stop(random_: random.Random) -> Drawn:
    """Draw a wall that is a spring without end: it turns the cart in half a period."""
    stiffness = 10.0 ** random_.uniform(2.0, 10.0)
    place = random_.uniform(1.0, 0.9 * END * SPEED)
    back = place / SPEED + math.pi / math.sqrt(stiffness)

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        cart, way = result.body("cart"), place - SPEED * (END - back)
        if back > END:
            return {}
        return {
            "speed [m/s]": (cart.velocity[-1, 0], -SPEED, SPEED),
            "position [m]": (cart.position[-1, 0], way, END * SPEED),
        }

    return {"place": place, "height": stiffness}, wanted


def brake(random_: random.Random) -> Drawn:
    """Draw a strip of oil: each metre in it takes as much speed."""
    width = 10.0 ** random_.uniform(-5.0, 0.0)
    place = random_.uniform(1.0, 0.5 * END * SPEED)
    lost = random_.uniform(0.1, 0.5) * SPEED

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        cart, slower = result.body("cart"), SPEED - lost
        inside = width / lost * math.log(SPEED / slower)
        way = place + width + slower * (END - place / SPEED - inside)
        return {
            "speed [m/s]": (cart.velocity[-1, 0], slower, SPEED + LENGTH * lost / width),
            "position [m]": (cart.position[-1, 0], way, END * (SPEED + LENGTH * lost / width)),
        }

    return {"place": place, "width": width, "height": lost / width}, wanted


def sides(random_: random.Random) -> Drawn:
    """Draw a spring that has another stiffness on either side: halves of two periods."""
    below, above = (10.0 ** random_.uniform(-1.0, 3.0) for _ in range(2))
    first, second = math.pi / math.sqrt(above), math.pi / math.sqrt(below)
    periods, rest = divmod(END, first + second)
    assert periods >= 0.0
    if rest < first:
        rate = math.sqrt(above)
        x, v = SPEED / rate * math.sin(rate * rest), SPEED * math.cos(rate * rest)
    else:
        rate, rest = math.sqrt(below), rest - first
        x, v = -SPEED / rate * math.sin(rate * rest), -SPEED * math.cos(rate * rest)

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        cart = result.body("cart")
        turns = 1.0 + END * max(math.sqrt(above), math.sqrt(below))
        return {
            "speed [m/s]": (cart.velocity[-1, 0], v, SPEED * turns),
            "position [m]": (cart.position[-1, 0], x, SPEED / rate * turns),
        }

    return {"place": above, "height": below}, wanted


def weight(random_: random.Random) -> Drawn:
    """Draw a force towards the origin that is the same everywhere: parabolas, and jumps."""
    force = 10.0 ** random_.uniform(0.0, 2.0)
    half = 2.0 * SPEED / force
    number, rest = divmod(END, half)
    sign = -1.0 if number % 2 else 1.0

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        cart = result.body("cart")
        v, x = SPEED - force * rest, SPEED * rest - 0.5 * force * rest * rest
        # each jump changes the speed, and that how long all later parabolas take
        allowed = SPEED + (1.0 + number) ** 2 * 2.0 * force * LENGTH / SPEED
        return {
            "speed [m/s]": (cart.velocity[-1, 0], sign * v, allowed),
            "position [m]": (cart.position[-1, 0], sign * x, END * allowed),
        }

    return {"height": force}, wanted


def dry(random_: random.Random) -> Drawn:
    """Draw a spring with dry friction: each half of a period is shorter by the same."""
    stiffness, friction = 10.0 ** random_.uniform(0.0, 2.0), 10.0 ** random_.uniform(-3.0, -1.0)
    rate, shift = math.sqrt(stiffness), friction / stiffness
    # the first quarter, from the origin at full speed: about -shift
    amplitude = math.hypot(shift, SPEED / rate)
    quarter = math.acos(shift / amplitude) / rate
    x, left = amplitude - shift, END - quarter
    if left < 0.0:
        angle = rate * END - math.acos(shift / amplitude)
        place, speed = amplitude * math.cos(angle) - shift, -amplitude * rate * math.sin(angle)
    else:
        number, rest = divmod(left, math.pi / rate)
        side = 1.0
        for _ in range(int(number)):
            x, side = x - 2.0 * shift, -side
        about = x - shift
        place = side * (about * math.cos(rate * rest) + shift)
        speed = -side * about * rate * math.sin(rate * rest)

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        cart, turns = result.body("cart"), 1.0 + rate * END
        return {
            "speed [m/s]": (cart.velocity[-1, 0], speed, SPEED * turns),
            "position [m]": (cart.position[-1, 0], place, SPEED / rate * turns),
        }

    return {"place": stiffness, "height": friction}, wanted


#: A shaft that is led by a law of time, and what it turns against.
SHAFT = """
name = "shaft"
unit = "m"
outputs = ["energies", "coordinates"]
[bodies]
shaft = {{ position = [0, 0, 0], mass = 1, inertia = {{ xx = 0.1, yy = 0.1, zz = 0.1 }} }}
[joints]
axle = {{ type = "revolute", bodies = ["ground", "shaft"], at = [0, 0, 0], axis = [0, 0, 1] }}
[coordinates]
turn = {{ joint = "axle" }}
[drivers]
motor = {{ coordinate = "turn", value = "{law}" }}
[forces]
load = {{ type = "along", coordinate = "turn", force = "{load}" }}
"""
#: A cart that is led with a bump, and one that feels how far it is off.
BUMP = """
name = "bump"
unit = "m"
parameters = { place = 5.0, width = 0.1 }
drivers = { road = { coordinate = "x", value = "t + width*exp(-((t - place)/width)^2)" } }
[bodies]
cart = { position = [0, 0, 0], mass = 5, inertia = { xx = 1, yy = 1, zz = 1 } }
bob = { position = [0, 0, 0], mass = 1, inertia = { xx = 1, yy = 1, zz = 1 } }
[joints]
rail = { type = "prismatic", bodies = ["ground", "cart"], at = [0, 0, 0], axis = [1, 0, 0] }
slide = { type = "prismatic", bodies = ["cart", "bob"], at = [0, 0, 0], axis = [0, 1, 0] }
[coordinates]
x = { joint = "rail" }
y = { joint = "slide" }
[forces]
reads = { type = "along", coordinate = "y", force = "(x - t)/width" }
"""


def led(random_: random.Random) -> Drawn:
    """Draw a bump of a shaft that is led: the load takes its share of the bump's rate squared."""
    width = END * 10.0 ** random_.uniform(-6.0, -1.5)
    place, high = random_.uniform(6.0 * width, END - 6.0 * width), math.sqrt(width)
    work = -0.01 * (END + high * high / width * math.sqrt(0.5 * math.pi))

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        turn = result.time + high * 0.0
        for k, time in enumerate(result.time):
            turn[k] += high * math.exp(-(((time - place) / width) ** 2))
        k = int(abs(result["turn"] - turn).argmax())
        return {
            "work [J]": (result.ledger.works["load"], work, abs(work)),
            "angle [rad]": (result["turn"][k], turn[k], END),
        }

    return {"place": place, "width": width, "high": high}, wanted


def bump(random_: random.Random) -> Drawn:
    """Draw a bump of a driver, whose momentum a second body gets."""
    width = END * 10.0 ** random_.uniform(-6.0, -1.5)
    place = random_.uniform(6.0 * width, END - 6.0 * width)
    speed = width * math.sqrt(math.pi)

    def wanted(result: ks.Result) -> dict[str, tuple[float, float, float]]:
        return {"speed [m/s]": (result.body("bob").velocity[-1, 1], speed, speed)}

    return {"place": place, "width": width}, wanted


def moved(name: str, law: str) -> str:
    """Scene of a cart under a law."""
    return CART.format(name=name, law=f"{law} + 0*place*width*height")


FORMS: dict[str, Form] = {
    **{
        name: Form(
            "pulses",
            BLOCK.format(name=name, law=f"10*({law})"),
            pulse(of),
            may_be_fixed=True,
            free=0.0,
        )
        for name, (law, of) in PULSES.items()
    },
    "bump": Form("bumps of drivers", BUMP, bump, free=0.0),
    "led": Form(
        "loads of bumps, kinematics",
        SHAFT.format(law="t + high*exp(-((t - place)/width)^2)", load="-0.01*turn_dot")
        + "[parameters]\nplace = 5.0\nwidth = 0.1\nhigh = 1.0\n",
        led,
        is_led=True,
    ),
    **{
        name: Form(
            "walls",
            moved(name, law),
            wall(
                integral,
                is_steep=name in {"step_wall", "trapezoid_wall"},
                least=-6.0 if name == "cap_wall" else -5.0,
            ),
            number=50,
            may_be_fixed=True,
        )
        for name, (law, integral) in WALLS.items()
    },
    **{
        name: Form(
            "distances",
            BALL.format(name=name) + forces,
            wall(2.0, is_steep=True, least=-4.0),
            number=50,
            may_be_loose=name == "distance_wall",
        )
        for name, forces in DISTANCES.items()
    },
    "arctangent_wall": Form(
        "walls",
        moved(
            "arctangent_wall",
            "-height*(atan(100*(x - place)/width) - atan(100*(x - place - width)/width))/pi",
        ),
        arctangents,
        may_be_fixed=True,
    ),
    "rise": Form("steep rises", moved("rise", "-height*atan((x - place)/width)"), rise),
    "stop": Form("stops", moved("stop", "-height*max(0, x - place)"), stop, may_be_fixed=True),
    "brake": Form(
        "brakes",
        moved("brake", "-height*x_dot*(sign(x - place) + 1)*(sign(place + width - x) + 1)/4"),
        brake,
    ),
    "sides": Form(
        "kinks of the state", moved("sides", "-place*max(0, x) - height*min(0, x)"), sides
    ),
    "weight": Form("jumps of the state", moved("weight", "-height*sign(x)"), weight),
    "dry": Form("dry friction", moved("dry", "-place*x - height*sign(x_dot)"), dry),
}
