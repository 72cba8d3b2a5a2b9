"""Mutants that nobody notices, answered one by one: what their mistake does not change."""

from __future__ import annotations

#: By the file that a mistake is made in, or that this is a copy of: how the finding of it begins
#: behind the file's name, and why nothing is wrong.
ANSWERS = {
    "generated/kinds/*/kernels_batch.c": {
        "'*' -> '/' in 'vec *C = out[0] ? (vec *)out[0] + block * 1": "n * 1 is n / 1",
        "'1' -> '(2 * 1)' in 'rates_wanted(": "true as well",
        "'9' -> '(2 * 9)' in 'load_rows(in[2], i, stride[2], 9, I_A_b);'": (
            "more is written than there is room for, over what is written next: no number"
            " tells, but sanitizers do (question compilers), and generate --check"
        ),
    },
    "runtime/lanes.h": {
        "'8' -> '(2 * 8)' in 'typedef long long lane_index": "for gcc before 12",
        "'5' -> '(2 * 5)' in 'v[0], v[1], PICK, 5, e, 1)": (
            "for rows of five numbers, which this package lacks and kinds have"
        ),
        "'0' -> '1' in '*(vec *)x = SHUFFLE(y[0], y[1], PAIRS, 0, 0, 0);'": (
            "for processors with two lanes"
        ),
    },
    "generated/lever_crank/solver.c": {
        "'61' -> '(2 * 61)' in '.rows = 61,'": "counted anew where a run is asked for",
        "'1.0' -> '(2 * 1.0)' in '{": (
            "a size that residuals are compared with: the same rows, another margin"
        ),
        "'80.0' -> '(2 * 80.0)' in '{.row = 1,": (
            "a length that bounds of a step are told with: the same rows, another margin"
        ),
        "'45.0' -> '(2 * 45.0)' in '{45.0,": "the same position is found from there",
    },
    "generated/pendulum/solver.c": {
        "'37' -> '(2 * 37)' in 'W_SCRATCH = 33,": "a workspace that is larger than it must be",
        "'1' -> '(2 * 1)' in 'static const unsigned char is_length": "true as well",
        "'1' -> '(2 * 1)' in 'static const unsigned char row_is_length": "true as well",
    },
    "generated/pendulum/solver.py": {
        "'0.0001' -> '(2 * 0.0001)' in 'closure_tolerance=": "no row of this scene is left out",
    },
    "runtime/messages.py": {
        "'super().__init__(problem)' -> 'pass'": "what made the error has kept the text already",
        "'>' -> '>=' in 'more = f\" and {len(names) - most} more\"": (
            "names that are as many as a line tells; tests/runtime/test_messages.py asks for them,"
            " with the file that this one is a copy of"
        ),
    },
    "symbolic/ring.py": {
        "'row, column' -> 'column, row' in '[a * b for a, b in zip(row, column": (
            "the product of two fractions, whichever is first"
        ),
    },
    "codegen/dynamics/operations/heights.py": {
        "'0.0' -> '1' in 'ground = (0.0, 0.0, 0.0, *NO_TURN)'": (
            "scenes whose place at the start decides that they are planar;"
            " tests/codegen/dynamics/operations/test_heights.py asks for it"
        ),
    },
    "codegen/passes/rebuild.py": {
        "'1' -> '(2 * 1)' in 'for node in range(len(nodes) - 1, -1, -1):'": (
            "the last node is asked once more: what it needs is known by then"
        ),
    },
    "codegen/passes/trace.py": {
        "'most, alive' -> 'alive, most' in 'most = max(most, alive)'": (
            "the larger of two numbers, whichever is first"
        ),
    },
    "codegen/dynamics/checking/independent.py": {
        "'2' -> '(2 * 2)' in 'half = [change[k] / 2": (
            "how steep forces are is asked at half of the angle beside a state: another size of"
            " what rounding of places does to them"
        ),
    },
    "codegen/templates/c/kernels_batch.c.jinja": {
        "'<=' -> '<' in 'for (; i + LANES <= n; i += LANES) {'": (
            "what fills the last lanes is computed one by one: the same bits, more slowly"
        ),
    },
    "codegen/templates/linkage/__init__.py.jinja": {
        "'and' -> 'or' in '``solve()`` gives": (
            "a word of a docstring that is generated, which generate --check compares"
        ),
    },
    "codegen/templates/dynamics/_segments.jinja": {
        "'8' -> '(2 * 8)' in '{{ segment.table | indent(8, first=true) }}'": (
            "white space of what is generated, which generate --check compares"
        ),
    },
    "runtime/integrate/roots.h": {
        "'near_a, near_b' -> 'near_b, near_a' in": (
            "the larger of two numbers, whichever is first"
        ),
        "'<' -> '<=' in 'const double least = side < 0": (
            "where a function begins at zero more intervals are halved: the same roots"
        ),
    },
    "runtime/integrate/distances.h": {
        "'1' -> '(2 * 1)' in 'if (falls_in(0, k, nodes) ||": "true as well",
    },
    "runtime/integrate/row_switch.py": {
        "'0' -> '1' in 'return np.where(index < 0, fixed": (
            "another choice of rows that depend on each other: the same motion;"
            " tests/runtime/test_dynamics_design.py asks for the masses that weigh them"
        ),
    },
    "runtime/integrate/stepper.py": {
        "'<' -> '<=' in 'if not trial.is_last or following < state.step_size:'": (
            "a number is replaced by an equal one"
        ),
    },
    "runtime/integrate/scene_solver.py": {
        "'<=' -> '<' in 'if status != Status.GOOD or asked <= s.time:'": (
            "a row at a switch is written by the polynomial of the step behind it: the same numbers"
        ),
    },
    "runtime/integrate/kinematics.py": {
        "'seen, state.time + FINEST * length' -> 'state.time + FINEST * length, seen' in": (
            "the larger of two numbers, whichever is first"
        ),
    },
    "runtime/integrate/roots.py": {
        "'>' -> '>=' in 'while last - first > SMALLEST": "one more halving at most",
    },
    "runtime/integrate/switching.py": {
        "'first, last' -> 'last, first' in 'return last - first <= SMALLEST * span and": (
            "two times that are one but for rounding, whichever is first"
        ),
        "'<' -> '<=' in 'last = first + h if h < end - first else end'": (
            "an interval that is all that is left ends beside its end by rounding, and one more"
            " follows"
        ),
    },
    "runtime/integrate/initial_coordinates.py": {
        "'*' -> '/' in 'q, motions, made, step = trial, trial_motions, following, GROW * step'": (
            "other steps are tried on the way to given coordinates; those that fail are shortened"
        ),
        "'0.3' -> '(2 * 0.3)' in 'LONGEST_CONTINUATION_STEP =": (
            "longer steps are tried on the way to given coordinates; those that fail are shortened"
        ),
        "'>=' -> '>' in 'if not step >= SHORTEST_PART:'": (
            "a step that is exactly the shortest is given up, too"
        ),
    },
    "runtime/kinematics/newton.h": {
        "'>=' -> '>' in 'if (k >= run->max_iterations || (k > 2 && step": (
            "one correction more at most before the step is halved"
        ),
        "'>' -> '>=' in 'if (k >= run->max_iterations || (k > 2 && step": (
            "one correction less at most before the step is halved"
        ),
    },
    "runtime/integrate/step_error.h": {
        "'best, WORSE_ERROR_PART * e2' -> 'WORSE_ERROR_PART * e2, best' in": (
            "the larger of two numbers, whichever is first"
        ),
    },
    "runtime/integrate/step_end.h": {
        "'<' -> '<=' in 'if (tried->shorter++ < MOST_SHORTER)": (
            "one attempt more before a step is given up"
        ),
    },
    "runtime/integrate/stepper.h": {
        "'*' -> '/' in 'if (!(trial.h > SMALLEST * larger(": (
            "another least length of steps, which are given up a little earlier or later"
        ),
        "'>' -> '>=' in 'trial->is_whole = !(way_of(trial->h, s->y, work->y) >": (
            "a step that is exactly as long as the shortest that is given up is given up, too"
        ),
    },
}
#: How a finding of :mod:`mutants` begins, and why nothing is wrong.
ANSWERED = {
    f"{file}: {mistake}": why
    for file, answers in ANSWERS.items()
    for mistake, why in answers.items()
}
