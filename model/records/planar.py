"""The elements of a planar linkage as a scene describes them: nodes, links, sliders, inputs."""

# Annotations are evaluated: msgspec reads the types of a scene file from them.
from typing import Literal

import msgspec

from kousoku.model.records.design import NumberOrAngle

Point = tuple[float, float]


class Node(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A point where links meet; links are hinged there unless a rigid connection says otherwise.

    Parameters
    ----------
    at : (2,) [unit of the scene]
        Position in frame O: exact where the node is fixed, else near the position that belongs to
        the first value of the inputs. It also selects the branch in which the linkage is assembled.
    fixed : bool
        Whether the node stays where it is.
    """

    at: Point
    fixed: bool = False


class Link(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A rigid bar between two nodes: the link element of Yamada and Tatsumi (1981).

    Parameters
    ----------
    nodes : (str, str)
        Its first and its second node; the angle β points from the first to the second.
    length : float [unit of the scene], optional
        Design length; the distance between the positions of its nodes when left out.
    """

    nodes: tuple[str, str]
    length: float | None = None

    def other(self, node: str) -> str:
        """End that is not `node`."""
        first, second = self.nodes
        return second if node == first else first


class Rigid(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A rigid connection: links that keep the angles between them at a node.

    Parameters
    ----------
    at : str
        The node that they share.
    links : tuple of str
        Two links or more.
    angle : float [rad], optional
        Angle from the first link to the second, counter-clockwise, both seen from the node.
        Taken from the positions of the nodes when left out, and with more than two links.
    """

    at: str
    links: tuple[str, ...]
    angle: NumberOrAngle | None = None


class Slider(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A node that moves on a fixed line.

    Parameters
    ----------
    node : str
        The node that slides.
    through : (2,) [unit of the scene]
        A point of the line, in frame O; the displacement of the slider counts from here.
    direction : (2,)
        Direction of the line, of any length but zero; the displacement grows along it.
    """

    node: str
    through: Point
    direction: Point


class Input(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A prescribed motion: the angle of a link, the displacement of a slider, a joint coordinate.

    Parameters
    ----------
    link, about : str, optional
        The link whose angle is prescribed, in radians from +x and counter-clockwise, seen from the
        node `about` towards its other end.
    slider : str, optional
        The slider whose displacement is prescribed, instead of a link.
    joint : str, optional
        The joint of a spatial scene whose coordinate is prescribed, instead of a link.
    start : float [rad or unit of the scene]
        Value at division 0; the key in a file is ``from``.
    to : float [rad or unit of the scene], optional
        Value at the last division.
    turns : float, optional
        Turns from the first to the last division, negative for clockwise; links only. One turn
        when neither `to` nor `turns` is given.
    rate, acceleration : float [per s, per s²]
        First and second time derivative of the value, the same at every division.
    """

    link: str | None = None
    about: str | None = None
    slider: str | None = None
    joint: str | None = None
    start: NumberOrAngle = msgspec.field(default=0.0, name="from")
    to: NumberOrAngle | None = None
    turns: float | None = None
    rate: NumberOrAngle = 1.0
    acceleration: NumberOrAngle = 0.0


class Method(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """How positions are found, unless the caller says otherwise.

    Parameters
    ----------
    scheme : {"newton", "paper"}
        Full Newton, or the iteration of the paper with the matrix of the reference position.
    residual : float [unit of the scene], optional
        Limit of the residual; 8·2⁻⁵² times the largest length of the scene when left out.
    iterations : int
        Largest number of iterations in one step.
    """

    scheme: Literal["newton", "paper"] = "newton"
    residual: float | None = None
    iterations: int = 100
