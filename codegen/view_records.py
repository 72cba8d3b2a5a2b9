"""What a template may see of a kernel: strings, whole numbers, and tuples of them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kousoku.codegen.view_body import OutputText, Statement
    from kousoku.codegen.view_shuffles import RowsView


@dataclass(frozen=True, slots=True)
class ArgumentView:
    """An input or an output.

    Parameters
    ----------
    name : str
        As the caller knows it.
    symbol : str
        As the text calls it.
    index, size : int
        Place among the inputs or outputs; count of numbers in one evaluation.
    shape : str
        The shape as Python writes it.
    batched : str
        Shape with leading axes, and unit.
    meaning : str
        Of what, in which frame.
    rows : tuple of str
        Of the argument table: symbol, shape, unit, meaning.
    is_used : bool
        Whether any output depends on it.
    """

    name: str
    symbol: str
    index: int
    size: int
    shape: str
    batched: str
    meaning: str
    rows: tuple[str, ...]
    is_used: bool


@dataclass(frozen=True, slots=True)
class BodyView:
    """The straight-line code of one choice of outputs.

    Parameters
    ----------
    name : str
        ``all``, or the output.
    function : str
        Name of the function in NumPy.
    inputs, outputs : tuple of ArgumentView
        What it reads and writes.
    is_wanted : str
        The condition under which a batch runs it.
    arguments : str
        The symbols of both, as a call of C passes them.
    components : tuple of str
        For each input the names of its elements, where the target unpacks them.
    first : tuple of (str, str)
        Elements of outputs that need no shared term, and their expressions.
    statements : tuple of Statement
        The shared terms.
    results : tuple of OutputText
        What is written, output by output.
    """

    name: str
    function: str
    inputs: tuple[ArgumentView, ...]
    outputs: tuple[ArgumentView, ...]
    is_wanted: str
    arguments: str
    components: tuple[str, ...]
    first: tuple[tuple[str, str], ...]
    statements: tuple[Statement, ...]
    results: tuple[OutputText, ...]


@dataclass(frozen=True, slots=True)
class CallsView:
    """All inputs and outputs of a kernel, as calls of C pass them.

    Parameters
    ----------
    symbols : str
        By their own names.
    pointers : str
        Elements of the arrays of pointers ``in`` and ``out``.
    single : str
        Evaluation ``i`` of the arrays.
    lanes : str
        Block ``block`` of the lanes layout.
    names_in, names_out : str
        The names as strings.
    """

    symbols: str
    pointers: str
    single: str
    lanes: str
    names_in: str
    names_out: str


@dataclass(frozen=True, slots=True)
class KernelView:
    """One kernel.

    Parameters
    ----------
    name : str
        As in the kernel.
    heading : tuple of str
        Package, kernel and title, in lines that fit.
    summary : str
        First line of a docstring.
    about : tuple of str
        Lines of the formula and its source.
    cost : tuple of str
        Count of operations, and what it would be without sharing.
    inputs, outputs : tuple of ArgumentView
        In the order of the arguments.
    calls : CallsView
        Arguments that differ only in where they come from.
    c, numpy : tuple of BodyView
        The code for all outputs first, then, if there are several, for each alone.
    is_polynomial : bool
        Whether Python's floats give what arrays give.
    """

    name: str
    heading: tuple[str, ...]
    summary: str
    about: tuple[str, ...]
    cost: tuple[str, ...]
    inputs: tuple[ArgumentView, ...]
    outputs: tuple[ArgumentView, ...]
    calls: CallsView
    c: tuple[BodyView, ...]
    numpy: tuple[BodyView, ...]
    is_polynomial: bool


@dataclass(frozen=True, slots=True)
class PackageView:
    """What the templates of all files get.

    Parameters
    ----------
    name, title, regenerate, version, digest : str
        As in the manifest.
    kernels : tuple of KernelView
        In the order of the text.
    loads, stores : tuple of RowsView
        How rows of each size of the inputs become lanes, and lanes rows of the outputs.
    functions : tuple of (str, int)
        C name and count of operands of each function that the kernels call.
    """

    name: str
    title: str
    regenerate: str
    version: str
    digest: str
    kernels: tuple[KernelView, ...]
    loads: tuple[RowsView, ...]
    stores: tuple[RowsView, ...]
    functions: tuple[tuple[str, int], ...]
