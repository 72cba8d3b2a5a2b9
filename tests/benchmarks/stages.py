"""From a chain to its first step, in a process of its own.

``python -m tests.benchmarks.stages HOW BARS BEGAN FILE`` prints what each stage took, as JSON. The
caller says when the process began, gives it an empty cache or a full one, and ends it when it is
late. HOW is ``empty``, ``warm``, ``found`` or ``steps`` for kousoku, or the name of a peer.
"""

from __future__ import annotations

import builtins
import json
import statistics
import sys
import time
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tests.benchmarks.kit import PeerMissingError, required

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

#: What belongs to which stage: functions by the modules that call them. What none of them does is
#: part of the stage around it; of loading a scene, that is to look for it in the cache.
STAGES: dict[str, dict[str, tuple[str, ...]]] = {
    "read": {
        "kousoku.model.reading.read": ("scene_text", "scene_from_toml"),
        "kousoku.loading": ("_text",),
    },
    "analyse": {
        "kousoku.codegen.dynamics.generate": (
            *("assemble_scene", "analyse", "written_start", "require_driven"),
            *("changes_of_assembly", "notes_of_freedom"),
        ),
    },
    "compose": {
        "kousoku.codegen.dynamics.generate": ("choice_of", "inline"),
        "kousoku.loading": ("generated",),
    },
    "print": {
        "kousoku.codegen.dynamics.generate": ("emit_dynamics",),
        "kousoku.loading": ("_written",),
    },
    "compile": {
        "kousoku.runtime.build": ("_compile",),
        "kousoku.runtime.toolchain": ("find_toolchain",),
    },
    "load": {"kousoku.loading": ("load_solver",)},
}
#: In the order in which they run.
ORDER = ("start", "import", "look up", *STAGES, "first step")
#: Bars of the chain that a warm process has loaded before.
WARMED = 2
#: A time that the first step reaches, and two later ones [s]; between these the steps are as long
#: as they may be, for every number of bars.
FIRST_TIME, EARLY_TIME, LATE_TIME = 1e-6, 0.2, 0.6
TOLERANCE, STEP = 1e-6, 4e-3
#: So many bars are moved at least when a step is timed, by a short chain again and again.
BARS = 1000


class Clock:
    """Seconds of each stage; while one runs inside of another, that one waits."""

    def __init__(self) -> None:
        self.seconds: dict[str, float] = {}
        self._running: list[str] = []
        self._since = 0.0

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        """Count what is done to a stage."""
        self._turn()
        self._running.append(name)
        try:
            yield
        finally:
            self._turn()
            self._running.pop()

    def _turn(self) -> None:
        now = time.perf_counter()
        if self._running:
            name = self._running[-1]
            self.seconds[name] = self.seconds.get(name, 0.0) + now - self._since
        self._since = now

    def watch(self, stage: str, owner: Any, name: str) -> None:
        """Count a function to a stage, wherever its module is asked for it."""
        function = getattr(owner, name)

        def watched(*given: Any, **options: Any) -> Any:
            with self.stage(stage):
                return function(*given, **options)

        setattr(owner, name, watched)


def memory() -> dict[str, float]:
    """Most memory that this process and the largest of its children had [bytes].

    On Linux a process begins with what the one that started it had, as ``getrusage`` tells it; of
    its own ``/proc`` tells more, a child that needs less than this process counts as large.
    """
    try:
        import resource
    except ImportError:
        return {}
    unit = 1 if sys.platform == "darwin" else 1024
    own, children = (
        float(unit * resource.getrusage(who).ru_maxrss)
        for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    )
    status = Path("/proc/self/status")
    if status.exists():
        lines = dict(line.split(":", 1) for line in status.read_text().splitlines() if ":" in line)
        own = 1024.0 * int(lines["VmHWM"].split()[0])
    return {"memory": own, "memory of the compiler": children}


def kousoku(how: str, file: str, clock: Clock) -> dict[str, float]:
    """Load the chain in a scene file, make its first step, and return sizes."""
    with clock.stage("import"):
        import kousoku as ks
    if how != "found":
        _watch(clock)
    clock.watch("import", builtins, "__import__")
    if how == "warm":
        _move(ks.load(Path(file).with_name(f"chain_{WARMED}.toml").read_text(encoding="utf-8")))
        clock.seconds.clear()
    imported = memory().get("memory", 0.0)
    with clock.stage("look up" if how != "found" else "load"):
        mechanism = ks.load(file)
    with clock.stage("first step"):
        _move(mechanism)
    found = memory() | {"memory before": imported}
    text = sum(len(text) for name, text in mechanism.files.items() if name.endswith((".c", ".h")))
    solver: Any = mechanism.solver
    numbers = solver.target.state_size + solver.target.work_size
    return found | {"bytes of C": float(text), "bytes of a run": 8.0 * numbers}


def _watch(clock: Clock) -> None:
    """Count the stages of loading, and all imports."""
    with clock.stage("import"):
        modules = {name: import_module(name) for own in STAGES.values() for name in own}
    for stage, own in STAGES.items():
        for module, names in own.items():
            for name in names:
                clock.watch(stage, modules[module], name)


def _move(mechanism: Any, end: float = FIRST_TIME) -> Any:
    """Move a chain on; its bars are as fast as they fall."""
    return mechanism.simulate(
        times=[end], tolerance=TOLERANCE, largest_step=STEP, method="dop853", checks=False
    )


def steps(file: str) -> None:
    """Say when the first step is made; then, for each line of input, what a step takes per bar."""
    import kousoku as ks

    mechanism = ks.load(file)
    solver: Any = mechanism.solver
    count = len(solver.bodies)

    def timed(end: float) -> tuple[float, int]:
        start = time.perf_counter()
        motion = _move(mechanism, end)
        return time.perf_counter() - start, motion.ledger.steps

    timed(FIRST_TIME)
    print("moved", flush=True)
    for _ in sys.stdin:
        found = []
        for _ in range(max(1, BARS // count)):
            (long, more), (short, few) = timed(LATE_TIME), timed(EARLY_TIME)
            found.append((long - short) / (more - few) / count)
        print(statistics.median(found), flush=True)


def exudyn(count: int, clock: Clock) -> None:
    """Build a chain as a kinematic tree, which suits it best, and make one step."""
    with clock.stage("import"):
        np, exu = required("numpy"), required("exudyn")
        items = required("exudyn.itemInterface")
    from tests.benchmarks.chains import ALONG, CENTRE, GRAVITY, MASS, MOMENTS

    with clock.stage("build"):
        container = exu.SystemContainer()
        system, zero = container.AddSystem(), [0.0] * count
        node = system.AddNode(
            items.NodeGenericODE2(
                referenceCoordinates=zero,
                initialCoordinates=zero,
                initialCoordinates_t=zero,
                numberOfODE2Coordinates=count,
            )
        )
        turns = (exu.JointType.RevoluteY, exu.JointType.RevoluteZ)
        places = [ALONG * bool(k) for k in range(count)]
        system.AddObject(
            items.ObjectKinematicTree(
                nodeNumber=node,
                jointTypes=[turns[k % 2] for k in range(count)],
                linkParents=list(range(-1, count - 1)),
                jointTransformations=exu.Matrix3DList([np.eye(3)] * count),
                jointOffsets=exu.Vector3DList(places),
                linkInertiasCOM=exu.Matrix3DList([np.diag(MOMENTS)] * count),
                linkCOMs=exu.Vector3DList([CENTRE] * count),
                linkMasses=[MASS] * count,
                baseOffset=[0.0, 0.0, 0.0],
                gravity=list(GRAVITY),
                linkForces=exu.Vector3DList([np.zeros(3)] * count),
                linkTorques=exu.Vector3DList([np.zeros(3)] * count),
                jointForceVector=zero,
            )
        )
        system.Assemble()
    with clock.stage("first step"):
        settings = exu.SimulationSettings()
        settings.timeIntegration.endTime = FIRST_TIME
        settings.timeIntegration.numberOfSteps = 1
        settings.timeIntegration.verboseMode = 0
        settings.solutionSettings.writeSolutionToFile = False
        system.SolveDynamic(settings, solverType=exu.DynamicSolverType.RK44)


def mujoco(count: int, clock: Clock) -> None:
    """Build a chain body by body, since XML may not be nested so deeply, and evaluate it once."""
    with clock.stage("import"):
        program = required("mujoco")
    from tests.benchmarks.aba import mujoco_model

    with clock.stage("build"):
        model = mujoco_model(count)
        data = program.MjData(model)
    with clock.stage("first step"):
        program.mj_forward(model, data)


def pinocchio(count: int, clock: Clock) -> None:
    """Build a chain joint by joint and evaluate it once."""
    with clock.stage("import"):
        np, program = required("numpy"), required("pinocchio")
    from tests.benchmarks.aba import model_of

    with clock.stage("build"):
        model = model_of(count)
        data = model.createData()
    with clock.stage("first step"):
        program.aba(model, data, np.zeros(count), np.zeros(count), np.zeros(count))


PEERS: dict[str, Callable[[int, Clock], None]] = {
    "Exudyn": exudyn,
    "MuJoCo": mujoco,
    "Pinocchio": pinocchio,
}


def main() -> None:
    """Do what the command line asks for, and print what it took."""
    how, count, began = sys.argv[1:4]
    clock = Clock()
    clock.seconds["start"] = time.time() - float(began)
    if how == "steps":
        steps(sys.argv[4])
        return
    more = {}
    if how in PEERS:
        try:
            PEERS[how](int(count), clock)
        except PeerMissingError as error:
            print(json.dumps({"missing": str(error)}))
            return
        more = memory()
    else:
        more = kousoku(how, sys.argv[4], clock)
    print(json.dumps({"seconds": clock.seconds, "sizes": more}), flush=True)


if __name__ == "__main__":
    main()
