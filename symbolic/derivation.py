"""Records of a derivation, and access to their parts."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, overload

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    import sympy

    from kousoku.model.files.quantity import Quantity

#: Characters of a line of a repr, and kernels that it lists.
LONGEST_LINE, MOST_FUNCTIONS = 100, 6


@dataclass(frozen=True, slots=True, repr=False)
class Step:
    """One line of a derivation.

    Parameters
    ----------
    left : sympy.Basic
        Left-hand side, e.g. δC.
    right : sympy.Basic
        Right-hand side.
    rule : str
        Why: the rule that led here, in words.
    source : str
        The equation that states the rule, e.g. ``7.16``; empty where it is plain algebra.
    """

    left: sympy.Basic
    right: sympy.Basic
    rule: str
    source: str

    def __repr__(self) -> str:
        from kousoku.symbolic.printing import show

        return _line(f"<{show(self.left)} = {show(self.right)}", f": {self.rule}>")

    def _repr_latex_(self) -> str:
        from kousoku.symbolic.printing import latex_of

        return latex_of([self])


@dataclass(frozen=True, slots=True, repr=False)
class DerivedOutput:
    """A derived quantity, on both levels.

    Parameters
    ----------
    quantity : Quantity
        Name, shape, unit, meaning.
    expression : sympy.Basic
        Matrix level: what is frozen and emitted. Built only from the node types that
        ``symbolic.matrices`` lists.
    components : sympy.ImmutableDenseMatrix
        Component level: scalar expressions, one column, row-major, found without the matrix
        level; references are computed from these. The components of an input are the symbols
        that ``symbolic.matrices.elements`` gives (``r_i[0]`` …; a scalar keeps its bare name).
    through : tuple of sympy.Basic
        Further forms on the matrix level, on the way to which ``expression`` is proved equal to
        the components: each next one equals the one before it.
    at_pole : float, optional
        Documented value where the components have a pole or a kink: a number for each element,
        NaN where it must not be finite. Nothing is checked there when left out.
    """

    quantity: Quantity
    expression: sympy.Basic
    components: sympy.ImmutableDenseMatrix
    through: tuple[sympy.Basic, ...] = ()
    at_pole: float | None = None

    def __repr__(self) -> str:
        quantity = self.quantity
        return _line(f"<{_sized(quantity)} [{quantity.unit}]", f": {quantity.meaning}>")


def output_of(
    quantity: Quantity,
    expression: Any,
    scalars: Sequence[Any],
    through: tuple[Any, ...] = (),
) -> DerivedOutput:
    """Output of its components, row-major; the other arguments are those of the record."""
    from sympy.matrices.immutable import ImmutableDenseMatrix

    column = ImmutableDenseMatrix(len(scalars), 1, list(scalars))
    return DerivedOutput(quantity, expression, column, through)


@dataclass(frozen=True, slots=True, repr=False)
class Function:
    """Outputs that are evaluated together: the source of one kernel.

    Parameters
    ----------
    name, title, formula, source : str
        As in :class:`kousoku.model.operations.kernel.Kernel`.
    inputs : tuple of Quantity
        In the order of the arguments.
    outputs : tuple of DerivedOutput
        In the order of the arguments.
    """

    name: str
    title: str
    formula: str
    source: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[DerivedOutput, ...]

    def __repr__(self) -> str:
        inputs = ", ".join(quantity.name for quantity in self.inputs)
        outputs = ", ".join(_sized(output.quantity) for output in self.outputs)
        return _line(f"<{self.name}({inputs})", f" -> {outputs}>")


@dataclass(frozen=True, slots=True, repr=False)
class Derivation:
    """All that is derived of one kind.

    ``d[:5]`` is the same derivation with these steps only, ``d[4]`` one step. An output is an
    attribute by its name, as SymPy components: ``d.C``, ``d.C_q``, ``d.nu``, ``d.gamma``, in the
    symbols that :attr:`symbols` lists. ``print(d)`` prints the steps; a notebook shows them as
    formulas.

    Parameters
    ----------
    name : str
        The package that is emitted, e.g. ``p2_z``.
    kind : str
        The kind, e.g. ``p2``.
    title : str
        What it is, in one line, with its names in other books.
    source : str
        The document and section.
    steps : tuple of Step
        The derivation on the matrix level, in the order of reading.
    functions : tuple of Function
        The functions that are emitted.
    numbers : range, optional
        The numbers of the steps, where they are those of a longer derivation; from 1 when left out.
    """

    name: str
    kind: str
    title: str
    source: str
    steps: tuple[Step, ...]
    functions: tuple[Function, ...]
    numbers: range | None = None

    @property
    def step_numbers(self) -> range:
        """The number of each step."""
        return range(1, len(self.steps) + 1) if self.numbers is None else self.numbers

    @property
    def inputs(self) -> Mapping[str, Quantity]:
        """Everything that its outputs are functions of, by name: shape, unit and meaning."""
        return {q.name: q for function in self.functions for q in function.inputs}

    @property
    def outputs(self) -> Mapping[str, DerivedOutput]:
        """Everything that is emitted, by name, on both levels."""
        return {o.quantity.name: o for function in self.functions for o in function.outputs}

    @property
    def symbols(self) -> Mapping[str, Any]:
        """The symbols of each input: a column or a matrix of ``r_i[0]`` …, or one symbol."""
        from kousoku.symbolic.matrices import elements

        return {name: _shaped(q, elements(q)) for name, q in self.inputs.items()}

    def at(
        self,
        numbers: Mapping[str, Any] | None = None,
        /,
        *,
        outputs: Sequence[str] | None = None,
        **named: Any,
    ) -> dict[str, Any]:
        """Values of the outputs at given numbers, from the formulas and not from a kernel.

        Parameters
        ----------
        numbers : mapping of str to array_like, optional
            The inputs by name, in their shapes and SI units; or as keyword arguments.
        outputs : sequence of str, optional
            The outputs wanted; when left out, all that the given inputs are enough for.

        Returns
        -------
        dict of str to ndarray
            In the shapes of the outputs. Of integers, fractions and SymPy's exact numbers: arrays
            of exact SymPy numbers. Of mpmath's ``mpf``: arrays of ``mpf`` in its working precision.
            With any float: float64, each element rounded once from the exact value of the formula
            at these floats; ``nan`` where the formula has a pole or no real value.

        Raises
        ------
        DerivationError
            A name is not an input, an input is missing, or has another shape; no number.

        Examples
        --------
        >>> from kousoku.symbolic import derive
        >>> upright, quarter = [1, 0, 0, 0], [1, 0, 0, 1]  # Euler parameters of norm 1 and √2
        >>> axes = {"a_i_b": [1, 0, 0], "a_j_b": [1, 0, 0]}
        >>> derive("n1").at(p_i=upright, p_j=quarter, **axes)["C"]
        array([0], dtype=object)
        """
        from kousoku.symbolic.values import values_at

        return values_at(self, {**(numbers or {}), **named}, outputs)

    def prove(self) -> dict[str, int]:
        """Prove the derivation in exact arithmetic: its steps, and the two levels of each output.

        Returns
        -------
        dict of str to int
            How many equalities were proved between ``steps``, and of how many elements of each
            function.

        Raises
        ------
        DerivationError
            Names the first step that does not follow, or the element that differs.
        """
        from kousoku.symbolic.prove import prove, prove_steps

        counts = {function.name: prove(function) for function in self.functions}
        return {"steps": prove_steps(self), **counts}

    @overload
    def __getitem__(self, key: int) -> Step: ...
    @overload
    def __getitem__(self, key: slice) -> Derivation: ...
    def __getitem__(self, key: int | slice) -> Step | Derivation:
        if isinstance(key, slice):
            return replace(self, steps=self.steps[key], numbers=self.step_numbers[key])
        try:
            return self.steps[key]
        except IndexError:
            raise IndexError(f"{self.name} has no step {key}: there are {len(self)}") from None

    def __len__(self) -> int:
        return len(self.steps)

    def __iter__(self) -> Iterator[Step]:
        return iter(self.steps)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        known = self.outputs
        if name not in known:
            raise AttributeError(f"{self.name} has no output {name!r}; it has {', '.join(known)}")
        return _shaped(known[name].quantity, known[name].components)

    def __dir__(self) -> list[str]:
        return [*object.__dir__(self), *self.outputs]

    def __str__(self) -> str:
        from kousoku.symbolic.printing import print_steps

        return print_steps(self).removesuffix("\n")

    def __repr__(self) -> str:
        numbers = self.step_numbers
        steps = f"steps {numbers[0]} to {numbers[-1]}" if numbers else "no steps"
        functions = [f"  {function!r}" for function in self.functions[:MOST_FUNCTIONS]]
        hidden = len(self.functions) - len(functions)
        more = [f"  and {hidden} more in .functions"] if hidden else []
        head = _line(f"<Derivation {self.name}: {self.title}")
        usage = f"{steps}, which print() shows; of a part, print(...[:5])"
        return "\n".join([head, _line(f"  {self.source}; {usage}"), *functions, *more]) + ">"

    def _repr_latex_(self) -> str:
        from kousoku.symbolic.printing import print_steps

        return print_steps(self, "latex")


def _sized(quantity: Quantity) -> str:
    return f"{quantity.name} {quantity.shape}"


def _line(text: str, tail: str = "") -> str:
    """Line of a repr, cut where it is too long; the tail goes first."""
    room = LONGEST_LINE - min(len(tail), LONGEST_LINE // 2)
    head = text if len(text) <= room else text[: room - 1] + "…"
    line = head + tail
    return line if len(line) <= LONGEST_LINE else line[: LONGEST_LINE - 2] + "…" + line[-1]


def _shaped(quantity: Quantity, elements: Any) -> Any:
    """Elements as a SymPy matrix in the shape of a quantity; a scalar as it is."""
    from sympy import ImmutableDenseMatrix

    if not quantity.shape:
        return elements[0]
    return ImmutableDenseMatrix(*(*quantity.shape, 1)[:2], list(elements))
