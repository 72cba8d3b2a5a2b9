"""Explanations of solvers, and the verification of emitted code against its derivation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, overload

from kousoku.loading import GivenScene, cached_solver_folder, naming
from kousoku.mechanism import Mechanism
from kousoku.model.errors import DerivationError, LoadError
from kousoku.own_kinds import own_kinds
from kousoku.runtime.messages import shown
from kousoku.runtime.sources import folder_of

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from typing import Any

    from kousoku.codegen.dynamics.explanation.explain import Explanation
    from kousoku.codegen.linkage.explain import LinkageExplanation
    from kousoku.model.reading.builder import SceneBuilder
    from kousoku.model.records.scene import Scene
    from kousoku.own_kinds import Kind
    from kousoku.runtime.choice import Target
    from kousoku.runtime.library import Library
    from kousoku.runtime.report import Report
    from kousoku.stages import KernelExplanation
    from kousoku.symbolic.derivation import Derivation


@overload
def explain(mechanism: Derivation) -> KernelExplanation: ...
@overload
def explain(
    mechanism: Mechanism | str | Path | Mapping[str, Any] | Scene | SceneBuilder,
    *,
    kinds: Sequence[Kind] | None = None,
) -> Explanation | LinkageExplanation: ...
def explain(
    mechanism: Derivation | Mechanism | str | Path | Mapping[str, Any] | Scene | SceneBuilder,
    *,
    kinds: Sequence[Kind] | None = None,
) -> Explanation | LinkageExplanation | KernelExplanation:
    """Explain what a solver leaves out, what each step saves, and what remains.

    Parameters
    ----------
    mechanism : Mechanism, what :func:`kousoku.load` takes, or Derivation
        The mechanism; or the derivation of a constraint.
    kinds : sequence of Derivation, Library or path, optional
        Kinds of one's own that are types of joints of a scene, as of :func:`kousoku.load`.

    Returns
    -------
    Explanation
        ``print`` shows it as tables; it has the degrees of freedom and the rows of constraints
        that depend on others, by the names of their joints. Of a derivation: the operations of its
        kernels, stage by stage, and their graphs.

    Raises
    ------
    SceneError, AssemblyError
        As of :func:`kousoku.load`.
    """
    from kousoku.symbolic.derivation import Derivation

    outputs = None
    if isinstance(mechanism, Derivation):
        from kousoku.stages import KernelExplanation

        return KernelExplanation(mechanism)
    if isinstance(mechanism, Mechanism):
        scene, outputs = mechanism.scene, mechanism.outputs
        file = mechanism.file
    else:
        given = GivenScene.of(mechanism, own_kinds(kinds))
        scene, file = given.read(), given.file
    with naming(file):
        if not scene.is_spatial:
            from kousoku.codegen.linkage.explain import explain_linkage

            return explain_linkage(scene)
        from kousoku.codegen.dynamics.explanation.explain import explain as explained

        return explained(scene, outputs)


def verify(
    what: Mechanism | Derivation | Library | str | Path | Mapping[str, Any] | Scene | SceneBuilder,
    *,
    target: Target = "auto",
    kinds: Sequence[Kind] | None = None,
) -> Report:
    """Recompute the 50-digit reference values of emitted code on this machine.

    Parameters
    ----------
    what : Mechanism, Derivation, Library, name of a kind, path of a folder, or a scene
        A scene is what :func:`kousoku.load` takes; its file ends in ``.toml``. Of a mechanism the
        solver is generated again with its reference values, which takes about a second for ten
        bodies; of a derivation of one's own the kernels are generated.
    target : {"auto", "c", "numpy"}
        What to check: all that this machine can run, or one target.
    kinds : sequence of Derivation, Library or path, optional
        Kinds of one's own that are types of joints of a scene, as of :func:`kousoku.load`.

    Returns
    -------
    Report
        ``report.ok`` says whether all is within 4 units of rounding; ``print`` shows the worst.

    Raises
    ------
    LoadError
        There is no generated folder.
    """
    from kousoku.model.files.manifest import MANIFEST_FILE
    from kousoku.runtime.library import Library
    from kousoku.runtime.verify import verify as verified
    from kousoku.symbolic.derivation import Derivation

    if isinstance(what, Derivation) or (
        isinstance(what, str) and _is_kind(what) and not Path(what).exists()
    ):
        from kousoku.deriving import kernels

        what = kernels(what, target=target)
    if isinstance(what, Mechanism):
        source = GivenScene.of(what.scene)
        with cached_solver_folder(source, what.outputs, references=True) as folder:
            return verified(folder, target=target)
    if isinstance(what, Library):
        return verified(what, target=target)
    if not isinstance(what, str | Path) or "\n" in str(what) or str(what).endswith(".toml"):
        with cached_solver_folder(GivenScene.of(what, own_kinds(kinds)), references=True) as folder:
            return verified(folder, target=target)
    if not (folder_of(what) / MANIFEST_FILE).is_file():
        raise LoadError(
            f"{shown(str(what))} is no generated folder, which has a {MANIFEST_FILE}; wanted one,"
            " the name of a kind, or a scene file, *.toml"
        )
    return verified(what, target=target)


def _is_kind(name: str) -> bool:
    from kousoku.symbolic import packages_of

    try:
        return bool(packages_of(name))
    except DerivationError:
        return False
