"""Mutants that nobody notices, answered one by one: what their mistake does not change."""

from __future__ import annotations

#: How a finding of :mod:`mutants` begins, and why nothing is wrong.
ANSWERED = {
    "batch_numpy.py: 'value.place = place' -> 'pass'": (
        "a result is computed elsewhere and copied: the same numbers, slower"
    ),
    "batch_numpy.py: '<' -> '<=' in 'if result.place < 0:'": (
        "a result is computed elsewhere and copied: the same numbers, slower"
    ),
    "batch_numpy.py: '0' -> '1' in 'if result.place < 0:'": (
        "a result is computed elsewhere and copied: the same numbers, slower"
    ),
    "batch_numpy.py: '<=' -> '<' in 'if len(results) < len(kernel.outputs)": (
        "all outputs are computed where some would do: the same numbers, slower"
    ),
    "batch_numpy.py: 'or' -> 'and' in 'if array.shape != shapes[name] or": (
        "arrays that do not fit are taken: verify calls with none; tests/runtime/test_arguments.py"
        " does, with the file that this one is a copy of"
    ),
    "kernels_batch.c: '*' -> '/' in 'vec *C = out[0] ? (vec *)out[0] + block * 1": "n * 1 is n / 1",
    "kernels_batch.c: '9' -> '(2 * 9)' in 'load_rows(in[2], i, stride[2], 9, I_A_b);'": (
        "more is written than there is room for, over what is written next: no number tells, but"
        " sanitizers do (question compilers), and generate --check"
    ),
    "kernels.c: '0' -> '1' in '.x = {{1, 1.0}, {0, 0.0}},'": "the place of a factor that is zero",
    "lanes.h: '8' -> '(2 * 8)' in 'typedef long long lane_index": "for gcc before 12",
    "lanes.h: '5' -> '(2 * 5)' in 'v[0], v[1], PICK, 5, e, 1)": (
        "for rows of five numbers, which this package lacks and kinds have"
    ),
    "lanes.h: '0' -> '1' in '*(vec *)x = SHUFFLE(y[0], y[1], PAIRS, 0, 0, 0);'": (
        "for processors with two lanes"
    ),
    "solver.py: '61' -> '(2 * 61)' in 'rows=61,'": "counted anew where a run is asked for",
    "solver.py: '1.0' -> '(2 * 1.0)' in 'Unknown(": (
        "a size that residuals are compared with: the same rows, another margin"
    ),
    "solver.c: '0' -> '1' in 'N_SWITCHES = 0, N_FEATURES = 0,": (
        "narrow parts are looked for in each step, and there are none"
    ),
    "solver.c: '0' -> '1' in 'HAS_REFINEMENT = 0, HAS_ROW_SWITCH = 0,": (
        "forces of joints are found for no joint"
    ),
    "solver.c: '0' -> '1' in 'TURNS = 1, DRIVERS = 0,": "rates of drivers are looked at, of none",
    "solver.c: '37' -> '(2 * 37)' in 'W_C_DOT = 29,": "a workspace that is larger than it must be",
    "solver.c: '1' -> '(2 * 1)' in 'W_T = 0, W_PARAMETERS = 1,": "the place of no parameters",
    "solver.c: '0' -> '1' in 'W_LAM = 0, W_FREE = 0,": "the place of what the scene lacks",
    "solver.c: '1' -> '(2 * 1)' in 'static const unsigned char is_length": "true as well",
    "stepper.py: '<' -> '<=' in 'if not trial.is_last or following < state.step_size:'": (
        "a number is replaced by an equal one"
    ),
    "solver.py: '<=' -> '<' in 'if status != Status.GOOD or asked <= s.time:'": (
        "a row at a switch is written by the polynomial of the step behind it: the same numbers"
    ),
    "crossing.py: '>' -> '>=' in 'while last - first > SMALLEST": "one more halving at most",
    "stepper.h: '*' -> '/' in 'if (!(h > SMALLEST * larger(": (
        "another least length of steps, which are given up a little earlier or later"
    ),
    "certificate.py: '*' -> '/' in 'sums[:, 1] +=": (
        "another bound for blocks with angles and distances; bounds have slack, and what they"
        " certify is compared with samples: no place is known where that tells"
    ),
    "certificate.h: 'sum.off += fabs(factor) * way->radius[place];' -> ';'": (
        "a smaller bound, where what is known is off by rounding; bounds have slack"
    ),
}
