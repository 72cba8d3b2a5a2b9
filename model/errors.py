"""The errors that a user can meet, one class for each stage."""


class KousokuError(Exception):
    """Base of all errors that kousoku raises on purpose; the message says what to do."""


class SceneError(KousokuError):
    """A scene file or a built scene is not valid.

    Parameters
    ----------
    problem : str
        What is wrong, what was wanted, and what to do.
    file : str, optional
        The scene file.
    key : str, optional
        The dotted key, such as ``links.l1.length``.
    """

    def __init__(self, problem: str, *, file: str = "", key: str = "") -> None:
        self.problem = problem
        self.file = file
        self.key = key
        super().__init__(": ".join(part for part in (file, key, problem) if part))


class ExpressionError(KousokuError):
    """A formula cannot be read.

    Parameters
    ----------
    problem : str
        What is wrong, and what was wanted.
    column : int
        Where in the formula, counted from 1.
    """

    def __init__(self, problem: str, *, column: int) -> None:
        self.problem = problem
        self.column = column
        super().__init__(f"column {column}: {problem}")


class DerivationError(KousokuError):
    """A kind is unknown, or its derivation does not end in a linear form."""


class FreezeError(KousokuError):
    """An expression holds something that the graph cannot represent."""


class EmitError(KousokuError):
    """A program cannot be emitted for a target."""


class LoadError(KousokuError):
    """A generated folder or its compiled library cannot be loaded."""


class CompilerError(LoadError):
    """The C compiler is missing or refused the source; its own output is part of the message."""


class NoCompilerError(CompilerError):
    """There is no C compiler that works, or ``KOUSOKU_CC=none``; the NumPy kernels need none."""


class TargetError(LoadError):
    """The folder was generated without the target that is asked for."""


class CacheError(LoadError):
    """The cache of compiled libraries cannot be written: it is full, read-only or not ours."""


class VerifyError(KousokuError):
    """Emitted code does not compute what was derived."""


class SolveError(KousokuError):
    """A scene cannot be assembled or moved; what was computed is kept by the caller."""


class AssemblyError(SolveError):
    """A linkage does not fit together; the message names the links and by how much."""


class MotionError(SolveError):
    """A linkage cannot be moved on.

    Parameters
    ----------
    problem : str
        Where it stopped, what holds it, and what to do.
    trajectory : kousoku.runtime.linkage.Trajectory
        All good positions up to there.
    """

    def __init__(self, problem: str, trajectory: object) -> None:
        self.trajectory = trajectory
        super().__init__(problem)


class LedgerError(KousokuError):
    """A statement of the ledger is not what its entry claims, or there is no such entry."""


class FormulaError(LedgerError):
    """A printed formula cannot be read, or what it says cannot be formed."""
