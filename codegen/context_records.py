"""Context of the templates of a kernel: strings, whole numbers, and tuples of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kousoku.codegen.context_body import Assignment, OutputText

#: Rows of this size are at least as long as any vector.
LARGEST_LANE_WIDTH = 8


@dataclass(frozen=True, slots=True)
class ArgumentContext:
    """Input or output of a kernel.

    Parameters
    ----------
    name : str
        Name for the caller.
    symbol : str
        Name in the text.
    index, size : int
        Index among the inputs or outputs; count of numbers in one evaluation.
    shape : str
        The shape as Python writes it.
    batched : str
        Shape with leading axes, and unit.
    meaning : str
        Meaning, and frame.
    rows : tuple of str
        Rows of the argument table: symbol, shape, unit, meaning.
    """

    name: str
    symbol: str
    index: int
    size: int
    shape: str
    batched: str
    meaning: str
    rows: tuple[str, ...]

    @property
    def load(self) -> str:
        """Transposition of the rows of an input to lanes."""
        at = f"in[{self.index}], i, stride[{self.index}]"
        if self.size >= LARGEST_LANE_WIDTH:
            return f"load_rows({at}, {self.size}, {self.symbol})"
        return f"load_{self.size}({at}, {self.symbol})"

    @property
    def store(self) -> str:
        """Transposition of the lanes of an output to rows."""
        if self.size >= LARGEST_LANE_WIDTH:
            return f"store_rows({self.symbol}, out[{self.index}], i, {self.size})"
        return f"store_{self.size}({self.symbol}, out[{self.index}], i)"

    @property
    def block(self) -> str:
        """Address of an output in the lanes layout."""
        return f"out[{self.index}] ? (vec *)out[{self.index}] + block * {self.size} : NULL"


@dataclass(frozen=True, slots=True)
class BodyText:
    """Straight-line code of one choice of outputs, in one language.

    Parameters
    ----------
    inputs : tuple of ArgumentContext
        Inputs that it reads.
    components : tuple of str
        For each input the names of its elements, where the target unpacks them.
    head : tuple of Assignment
        The terms that all choices of rows have in common; none where there is no choice.
    tails : tuple of TailText
        The other terms, for each choice.
    """

    inputs: tuple[ArgumentContext, ...]
    components: tuple[str, ...]
    head: tuple[Assignment, ...]
    tails: tuple[TailText, ...]


@dataclass(frozen=True, slots=True)
class TailText:
    """Operations and outputs of one choice of rows.

    Parameters
    ----------
    first : tuple of (str, str)
        Elements of outputs that need no term of its own, and their expressions.
    statements : tuple of Assignment
        The shared terms.
    results : tuple of OutputText
        Elements that are written, output by output.
    """

    first: tuple[tuple[str, str], ...]
    statements: tuple[Assignment, ...]
    results: tuple[OutputText, ...]


@dataclass(frozen=True, slots=True)
class BodyContext:
    """Choice of outputs: all of them, or one that alone costs at most half.

    Parameters
    ----------
    name : str
        ``all``, or the output.
    function : str
        Name of the function in NumPy.
    outputs : tuple of ArgumentContext
        Outputs that it writes.
    c, numpy : BodyText
        The code, line by line the same.
    """

    name: str
    function: str
    outputs: tuple[ArgumentContext, ...]
    c: BodyText
    numpy: BodyText

    @property
    def python_parameters(self) -> tuple[str, ...]:
        """Parameters of its function in NumPy."""
        choice = ("choice: int",) if len(self.c.tails) > 1 else ()
        return (*choice, *(f"{a.symbol}: Sequence[Any]" for a in self.numpy.inputs))


@dataclass(frozen=True, slots=True)
class CallsContext:
    """Inputs and outputs of a kernel, as calls of C pass them.

    Parameters
    ----------
    pointers : tuple of str
        Elements of the arrays of pointers ``in`` and ``out``.
    single : tuple of str
        Evaluation ``i`` of the arrays.
    arrays : str
        Declarations of the lanes of one block of evaluations.
    signature : str
        Names and sizes, as strings of C.
    """

    pointers: tuple[str, ...]
    single: tuple[str, ...]
    arrays: str
    signature: str


@dataclass(frozen=True, slots=True)
class KernelContext:
    """Kernel, and its family of kernels that differ in the choice of rows.

    Parameters
    ----------
    name, family : str
        Name of the kernel, and the same without the ending of its choice of rows.
    choice : tuple of str
        Its number among the choices, as an argument; none where there is no choice.
    is_first : bool
        Whether it is the first of its family, whose text serves all.
    names : str
        Names of the kernels of the family.
    heading : tuple of str
        Package, kernel and title, in lines that fit.
    summary : str
        First line of a docstring.
    about, about_ascii : tuple of str
        Lines of the formula and its source.
    cost, family_cost : tuple of str
        Count of operations, and the count without sharing; those of each of the family.
    inputs, outputs : tuple of ArgumentContext
        In the order of the arguments.
    declared, parameters, arguments : tuple of str
        Arguments as C declares them, in the header and in the definition, and passes them.
    calls : CallsContext
        Arguments of calls, which differ only in their sources.
    flags : tuple of str
        Flags of the outputs that are wanted.
    unwanted : str
        Declarations of arrays that outputs are computed into where they are not wanted.
    alone_calls : tuple of tuple of str
        For each output the arguments that compute it alone.
    bodies : tuple of BodyContext
        The body for all outputs first, then, in NumPy, those of single outputs.
    is_polynomial : bool
        Whether Python's floats give what arrays give.
    """

    name: str
    family: str
    choice: tuple[str, ...]
    is_first: bool
    names: str
    heading: tuple[str, ...]
    summary: str
    about: tuple[str, ...]
    about_ascii: tuple[str, ...]
    cost: tuple[str, ...]
    family_cost: tuple[str, ...]
    inputs: tuple[ArgumentContext, ...]
    outputs: tuple[ArgumentContext, ...]
    declared: tuple[str, ...]
    parameters: tuple[str, ...]
    arguments: tuple[str, ...]
    calls: CallsContext
    flags: tuple[str, ...]
    unwanted: str
    alone_calls: tuple[tuple[str, ...], ...]
    bodies: tuple[BodyContext, ...]
    is_polynomial: bool

    @property
    def python_parameters(self) -> tuple[str, ...]:
        """Parameters of its function in NumPy."""
        inputs = (f"{a.symbol}: ArrayLike" for a in self.inputs)
        return (*inputs, "*", "out: Out = None", "outputs: Sequence[str] | None = None")

    @property
    def shapes_in(self) -> tuple[str, ...]:
        """The inputs as entries of a dict of Python."""
        return tuple(f'"{a.name}": {a.shape}' for a in self.inputs)

    @property
    def shapes_out(self) -> tuple[str, ...]:
        """The outputs as entries of a dict of Python."""
        return tuple(f'"{a.name}": {a.shape}' for a in self.outputs)

    @property
    def body(self) -> BodyContext:
        """The body for all outputs."""
        return self.bodies[0]

    @property
    def unread(self) -> tuple[str, ...]:
        """The inputs that no output depends on."""
        return tuple(a.symbol for a in self.inputs if a not in self.body.c.inputs)

    @property
    def flags_declared(self) -> tuple[str, ...]:
        """The flags as parameters, and the choice of rows."""
        return (*(f"int {flag}" for flag in self.flags), *self.choice_declared)

    @property
    def choice_declared(self) -> tuple[str, ...]:
        """The choice of rows as a parameter."""
        return ("int choice",) if self.choice else ()

    @property
    def choice_passed(self) -> tuple[str, ...]:
        """The same as an argument."""
        return ("choice",) if self.choice else ()

    @property
    def are_wanted(self) -> tuple[str, ...]:
        """The flags of a single call, and the choice."""
        return (*(f"{a.symbol} != NULL" for a in self.outputs), *self.choice)

    @property
    def are_wanted_batch(self) -> tuple[str, ...]:
        """The flags of a batch, and the choice."""
        return (*(f"out[{a.index}] != NULL" for a in self.outputs), *self.choice)

    @property
    def are_given(self) -> tuple[str, ...]:
        """The pointers of a batch that tell which outputs are wanted."""
        return tuple(f"out[{a.index}]" for a in self.outputs)

    @property
    def all_wanted(self) -> tuple[str, ...]:
        """The flags of all outputs, and the choice."""
        return ("1",) * len(self.outputs) + self.choice

    def one_wanted(self, output: int) -> tuple[str, ...]:
        """Flags of one output, and the choice."""
        return (*("1" if k == output else "0" for k in range(len(self.outputs))), *self.choice)

    @property
    def python_alone(self) -> tuple[str, ...]:
        """The bodies of single outputs as entries of a dict of Python."""
        return tuple(
            f'"{body.outputs[0].name}": '
            f"({self.python_body(body)}, {[a.index for a in body.numpy.inputs]})"
            for body in self.alone
        )

    def python_body(self, body: BodyContext) -> str:
        """Body of the family as a function of NumPy, with the choice of this kernel."""
        if len(body.c.tails) == 1:
            return body.function
        return f"partial({', '.join((body.function, *self.choice))})"

    @property
    def alone(self) -> tuple[BodyContext, ...]:
        """The bodies of single outputs."""
        return self.bodies[1:]


@dataclass(frozen=True, slots=True)
class PackageContext:
    """Context of the templates of all files.

    Parameters
    ----------
    name, title, title_ascii, regenerate, version, digest : str
        As in the manifest.
    kernels : tuple of KernelContext
        In the order of the text.
    has_calls, has_choices : bool
        Whether they call functions of the math library, and whether rows are chosen.
    """

    name: str
    title: str
    title_ascii: str
    regenerate: str
    version: str
    digest: str
    kernels: tuple[KernelContext, ...]
    has_calls: bool
    has_choices: bool

    @property
    def quoted_kernels(self) -> tuple[str, ...]:
        """The names of the kernels as strings of Python."""
        return tuple(f'"{kernel.name}"' for kernel in self.kernels)
