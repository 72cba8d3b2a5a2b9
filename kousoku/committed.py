"""The verified kernels that come with kousoku, by attribute: ``kinds.p2_z.constraint``."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Any

__all__ = ["kinds"]


class KindModule(ModuleType):
    """The kernels of a kind as a module that pickles: by its name."""

    def __reduce__(self) -> tuple[Any, ...]:
        return import_module, (self.__name__,)


class Kinds:
    """The kernels of the kinds: ``kinds.n1``, ``kinds.p2_z``; NumPy is all that they need.

    A kind with a choice of rows has a package for each, ``p2_x``, ``p2_y`` and ``p2_z``, with the
    names of any constraint, and one with all, ``p2``.
    """

    def __getattr__(self, name: str) -> ModuleType:
        if name not in _packages():
            raise AttributeError(f"no kernels of {name!r}; there are {', '.join(_packages())}")
        module = import_module(f"kousoku.generated.kinds.{name}")
        module.__class__ = KindModule
        return module

    def __reduce__(self) -> str:
        return "kinds"

    def __dir__(self) -> list[str]:
        return [*object.__dir__(self), *_packages()]

    def __repr__(self) -> str:
        return f"<kinds: {', '.join(_packages())}; print() shows what they are>"

    def __str__(self) -> str:
        from kousoku.cataloging import catalog

        return repr(catalog()["kinds"])

    def _repr_html_(self) -> str:
        from kousoku.cataloging import catalog

        return catalog()["kinds"]._repr_html_()


def _packages() -> tuple[str, ...]:
    from kousoku.symbolic import KINDS

    names = ((kind, *entry.packages) for kind, entry in KINDS.items())
    return tuple(dict.fromkeys(name for group in names for name in group))


kinds = Kinds()
