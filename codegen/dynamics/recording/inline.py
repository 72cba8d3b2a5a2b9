"""Straight-line code for small scenes: all tasks of a segment on one graph, all numbers folded.

A segment is cut into functions of a few hundred statements, because a compiler's time grows faster
than the size of a function. What one function computes and another needs passes through the
workspace. Every function takes the whole workspace as its one input.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from kousoku.codegen.dynamics.recording.counts import operations
from kousoku.codegen.dynamics.recording.program import (
    AFTER_GEOMETRY,
    ON_DEMAND,
    Region,
    Segment,
    Task,
    writes,
)
from kousoku.codegen.passes.rebuild import copy_node, substitute
from kousoku.model.files.quantity import Quantity
from kousoku.model.operations.graph import Graph, Op
from kousoku.model.operations.kernel import Kernel

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from kousoku.codegen.dynamics.recording.program import BodyCoordinates, CoordinatePlace, Program

#: Programs with more operations stay tasks: these are as fast then, and much faster to compile.
LIMIT = 2_500
#: Statements in one function.
STATEMENTS = 500
#: Segments after the geometry that every stage of a step runs; the others run for rows.
RUN_AT_STAGES = frozenset({"position", "velocity", "acceleration"})


def inline(program: Program, *, limit: int = LIMIT, statements: int = STATEMENTS) -> Program:
    """Program of straight-line functions that computes the same.

    Parameters
    ----------
    program : Program
        Tasks, as composed.
    limit : int
        A program whose tasks hold more operations is returned as it is.
    statements : int
        The most operations in one function.
    """
    if operations(program) > limit:
        return program
    return _Inliner(program, statements).program()


class _Inliner:
    """A program while its tasks become one graph."""

    def __init__(self, program: Program, statements: int) -> None:
        self.old = program
        self.statements = statements
        self.graph = Graph()
        self.kernels: list[Kernel] = []
        self.regions: list[Region] = []
        self.moved: dict[int, int] = {}
        size = 0
        for region in program.regions:
            if region.name == "constants":
                continue
            self.regions.append(Region(region.name, size, region.size))
            for k in range(region.size):
                self.moved[region.base + k] = size + k
            size += region.size
        self.size = self.scratch = size

    def program(self) -> Program:
        """Inline all segments."""
        values = self._initial_nodes()
        written: dict[str, dict[int, int]] = {}
        self._expand("geometry", values)
        shared = len(self.graph.nodes)
        written["geometry"] = self._written("geometry", values)
        for segment in (*self.old.segments, *self.old.on_demand):
            if segment.name != "geometry" and (self.old.rows or segment.name != "position"):
                local = dict(values) if segment.name in AFTER_GEOMETRY else self._initial_nodes()
                self._expand(segment.name, local)
                written[segment.name] = self._written(segment.name, local)
        passed = self._passed(written, shared)
        segments = [self._segment("geometry", written["geometry"], {}, passed)]
        self.scratch = self.size
        stored = {node: slot for slot, node in written["geometry"].items()} | passed
        for name, outputs in written.items():
            if name != "geometry":
                known = stored if name in AFTER_GEOMETRY else {}
                segments.append(self._segment(name, outputs, known, {}))
        regions = [*self.regions, Region("constants", self.size, 0)]
        kernels = (
            replace(kernel, inputs=(replace(kernel.inputs[0], shape=(self.size,)),))
            for kernel in self.kernels
        )
        return replace(
            self.old,
            kernels=tuple(kernels),
            segments=tuple(x for x in segments if x.name not in ON_DEMAND),
            on_demand=tuple(x for x in segments if x.name in ON_DEMAND),
            regions=tuple(regions),
            constants=(),
            is_inlined=True,
            size=self.size,
            bodies=tuple(self._moved_body(body) for body in self.old.bodies),
            design=self.old.design.moved(self.moved),
            auxiliary=tuple(
                replace(entry, place=replace(entry.place, slot=self.moved[entry.place.slot]))
                for entry in self.old.auxiliary
            ),
        )

    def _initial_nodes(self) -> dict[int, int]:
        """Nodes of the slots that are in the workspace before any task has run."""
        base = self.old.region("constants").base
        nodes = {base + k: self.graph.const(value) for k, value in enumerate(self.old.constants)}
        for slot, moved in self.moved.items():
            nodes[slot] = self.graph.input("x0", moved)
        return nodes

    def _expand(self, segment: str, values: dict[int, int]) -> None:
        """Run the tasks of a segment on nodes; ``values`` holds the node of each slot."""
        for task in self.old.segment(segment).tasks:
            kernel = self.old.kernels[task.kernel]
            inputs = {
                quantity.name: [values[base + k] for k in range(quantity.size)]
                for quantity, base in zip(kernel.inputs, task.inputs, strict=True)
            }
            results = substitute(self.graph, kernel, inputs).values()
            for base, result in zip(task.outputs, results, strict=True):
                values.update((base + k, node) for k, node in enumerate(result))

    def _written(self, segment: str, values: Mapping[int, int]) -> dict[int, int]:
        """Node of each slot in a region that a segment writes, by its new place."""
        return {
            self.moved[slot]: values[slot]
            for task in self.old.segment(segment).tasks
            for base, length in writes(self.old, task)
            for slot in range(base, base + length)
            if slot in self.moved
        }

    def _passed(self, written: Mapping[str, Mapping[int, int]], shared: int) -> dict[int, int]:
        """Slots for results of the geometry that the segments after it need.

        Results for rows alone, such as the matrix of a momentum, are computed by their segments.
        """
        passed: dict[int, None] = {}
        at_stages = (written[name].values() for name in written if name in RUN_AT_STAGES)
        rows = (written[x].values() for x in written if x in AFTER_GEOMETRY - RUN_AT_STAGES)
        for outputs in at_stages:
            order = self._order(outputs, lambda x: self._is_passed(x, shared))
            passed |= dict.fromkeys(node for node in order if self._is_passed(node, shared))
        stored = set(written["geometry"].values())
        computed = set(self._order((*stored, *passed), lambda _: False))
        for outputs in rows:
            order = self._order(outputs, lambda x: x in computed and self._is_passed(x, shared))
            passed |= dict.fromkeys(
                node for node in order if node in computed and self._is_passed(node, shared)
            )
        return {node: self._new_slot() for node in passed if node not in stored}

    def _is_passed(self, node: int, shared: int) -> bool:
        """Whether a node is read where it is needed: computed by the geometry, and no mere sign."""
        operation = self.graph.nodes[node]
        return node < shared and bool(operation.args) and operation.op is not Op.NEG

    def _order(self, roots: Iterable[int], is_known: Callable[[int], bool]) -> list[int]:
        """Nodes that ``roots`` need, each after its operands, without operands of known nodes."""
        done: dict[int, None] = {}
        stack = list(reversed(list(roots)))
        while stack:
            node = stack[-1]
            args = () if is_known(node) else self.graph.nodes[node].args
            missing = [arg for arg in reversed(args) if arg not in done]
            if missing:
                stack.extend(missing)
            else:
                done[stack.pop()] = None
        return list(done)

    def _new_slot(self) -> int:
        slot = self.scratch
        self.scratch += 1
        self.size = max(self.size, self.scratch)
        return slot

    def _segment(
        self,
        name: str,
        outputs: Mapping[int, int],
        known: Mapping[int, int],
        passed: Mapping[int, int],
    ) -> Segment:
        """Cut a segment into functions.

        Parameters
        ----------
        name : str
            The segment.
        outputs : mapping of int to int
            The node of each slot that it writes.
        known : mapping of int to int
            The slot of each node that was stored before.
        passed : mapping of int to int
            The slot of each node that it stores for others.
        """
        base = self.scratch
        order = self._order((*outputs.values(), *passed), known.__contains__)
        work = [node for node in order if self.graph.nodes[node].args and node not in known]
        starts = list(range(0, max(len(work), 1), self.statements))
        last_use = {
            arg: k // self.statements
            for k, node in enumerate(work)
            for arg in self.graph.nodes[node].args
        }
        targets: dict[int, list[int]] = {node: [slot] for node, slot in passed.items()}
        for slot, node in outputs.items():
            targets.setdefault(node, []).append(slot)
        slots = dict(known)
        tasks = []
        for number, start in enumerate(starts):
            chunk = work[start : start + self.statements]
            for node in chunk:
                if node not in targets and last_use.get(node, number) > number:
                    targets[node] = [self._new_slot()]
            written = {slot: node for node in chunk for slot in targets.get(node, ())}
            if start == starts[-1]:
                computed = set(work)
                written |= {slot: node for slot, node in outputs.items() if node not in computed}
            if not written:
                continue
            tasks.append(self._function(f"{name}_{number}", chunk, written, slots))
            slots |= {node: targets[node][0] for node in chunk if node in targets}
        self.scratch = base
        return Segment(name, tuple(tasks), self._contents(name))

    def _contents(self, name: str) -> tuple[str, ...]:
        """Titles of the tasks of a segment, by the element that they belong to."""
        titles: dict[str, dict[str, None]] = {}
        for task in self.old.segment(name).tasks:
            if task.owner:
                titles.setdefault(task.owner, {})[self.old.kernels[task.kernel].title] = None
        return tuple(f"{owner}: {', '.join(kinds)}" for owner, kinds in titles.items())

    def _function(
        self, name: str, chunk: Sequence[int], written: Mapping[int, int], slots: Mapping[int, int]
    ) -> Task:
        """Task of a function that computes the nodes of ``chunk`` and writes some of them."""
        graph = Graph()
        ids: dict[int, int] = {}
        for node in (*chunk, *written.values()):
            self._copy(graph, node, ids, slots)
        ordered = sorted(written.items())
        runs: list[tuple[int, list[int]]] = []
        for slot, node in ordered:
            if not runs or slot != runs[-1][0] + len(runs[-1][1]):
                runs.append((slot, []))
            runs[-1][1].append(ids[node])
        self.kernels.append(
            Kernel(
                name=name,
                title=name.rpartition("_")[0],
                formula="",
                source="",
                inputs=(Quantity("x0", (0,), "", "the workspace"),),
                outputs=tuple(
                    Quantity(f"y{k}", (len(nodes),), "", "run of slots")
                    for k, (_, nodes) in enumerate(runs)
                ),
                nodes=tuple(graph.nodes),
                results=tuple(tuple(nodes) for _, nodes in runs),
            )
        )
        return Task(len(self.kernels) - 1, (0,), tuple(slot for slot, _ in runs))

    def _copy(self, graph: Graph, node: int, ids: dict[int, int], slots: Mapping[int, int]) -> None:
        """Rebuild a node in a function, with its operands."""
        if node in ids:
            return
        if node in slots:
            ids[node] = graph.input("x0", slots[node])
            return
        for arg in self.graph.nodes[node].args:
            self._copy(graph, arg, ids, slots)
        ids[node] = copy_node(graph, self.graph.nodes[node], ids)

    def _moved_body(self, body: BodyCoordinates) -> BodyCoordinates:
        def moved(places: tuple[CoordinatePlace, ...]) -> tuple[CoordinatePlace, ...]:
            return tuple(
                replace(place, slot=self.moved[place.slot]) if place.slot >= 0 else place
                for place in places
            )

        return replace(
            body,
            r=moved(body.r),
            p=moved(body.p),
            v=moved(body.v),
            omega_b=moved(body.omega_b),
        )
