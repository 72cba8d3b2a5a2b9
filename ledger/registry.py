"""The vocabularies and the proofs that entries may ask for, each by its name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, NamedTuple, TypeVar

from kousoku.model.errors import LedgerError
from kousoku.model.text import near_name

if TYPE_CHECKING:
    from kousoku.ledger.vocabulary import Vocabulary

Words = Callable[[], "Vocabulary"]
#: Finding of a proof, in one line; or statements, each with whether it is true.
Evidence = str | Mapping[str, bool]

_Known = TypeVar("_Known")
_Words = TypeVar("_Words", bound=Words)
_Proof = TypeVar("_Proof", bound=Callable[..., Evidence])


class ProofMethod(NamedTuple):
    """A way of proving: a function that raises where something is not so.

    Parameters
    ----------
    function : callable
        It takes by name what the entry says, and returns what it saw.
    statement : str
        What it shows, its arguments in braces; empty where each entry says that itself.
    """

    function: Callable[..., Evidence]
    statement: str


class Names:
    """The names that the entries of a document know: those of their functions.

    Parameters
    ----------
    known : Names, optional
        Other names that they know too.
    """

    def __init__(self, known: Names | None = None) -> None:
        self._words: dict[str, Words] = {} if known is None else dict(known._words)
        self._methods: dict[str, ProofMethod] = {} if known is None else dict(known._methods)

    def words(self, function: _Words) -> _Words:
        """Enter a function that gives a vocabulary by its name: a decorator."""
        self._words[function.__name__] = function
        return function

    def proof(self, statement: str = "") -> Callable[[_Proof], _Proof]:
        """Enter a function that proves something by its name: a decorator.

        Parameters
        ----------
        statement : str
            What is shown, with arguments in braces, where an entry does not say that itself.
        """

        def entered(function: _Proof) -> _Proof:
            self._methods[function.__name__] = ProofMethod(function, statement)
            return function

        return entered

    def vocabulary(self, name: str) -> Words:
        """Function that gives the vocabulary of a name.

        Raises
        ------
        LedgerError
            There is none; the message says which is near.
        """
        return _looked_up("words", name, self._words)

    def method(self, name: str) -> ProofMethod:
        """Method of proving of a name.

        Raises
        ------
        LedgerError
            There is none; the message says which is near.
        """
        return _looked_up("proof", name, self._methods)


def _looked_up(noun: str, name: str, table: Mapping[str, _Known]) -> _Known:
    if name not in table:
        raise LedgerError(f"no {noun} {name!r}{near_name(name, table)}")
    return table[name]
