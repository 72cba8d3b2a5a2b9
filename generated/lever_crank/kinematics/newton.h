/* Newton's method: full, block after block, and with the Jacobian of a reference position. */
#ifndef KOUSOKU_KINEMATICS_NEWTON_H
#define KOUSOKU_KINEMATICS_NEWTON_H

#include "equations.h"
#include "status.h"

/* How positions converged: the most of all blocks. */
typedef struct Convergence {
    int iterations;
    double residual;
} Convergence;

/* whether the Jacobian is singular, or its determinant has the sign of another assembly mode */
static int is_dead_centre(double pivot, double orientation)
{
    return !(fabs(pivot) > SINGULAR) || pivot * orientation < 0.0;
}

/* Newton's method on one block from x */
static int newton(const Run *run, size_t number, const double *alpha, double *x, Workspace *w,
    Convergence *convergence)
{
    const size_t first = blocks[number].first, n = blocks[number].size;
    const Coordinates position = { alpha, x };
    double correction[LARGEST_BLOCK], last = HUGE_VAL;
    for (int k = 0; k <= run->max_iterations; ++k) {
        const double pivot = evaluate(number, position, w, correction);
        const double residual = largest_residual(n, correction);
        if (!(residual < HUGE_VAL)) {
            return NOT_FINITE;
        }
        if (is_dead_centre(pivot, w->orientation[number])) {
            return DEAD_CENTRE;
        }
        solve_block(number, w, correction);
        const double step = largest_correction(n, correction, unknowns + first);
        const int is_settled = last <= SETTLED * LENGTH, is_stalled = step >= 0.5 * last;
        if (residual <= run->limit && (is_settled || is_stalled)) {
            convergence->iterations = k > convergence->iterations ? k : convergence->iterations;
            convergence->residual = larger(convergence->residual, residual);
            return GOOD;
        }
        if (is_settled && is_stalled) {
            return LIMIT_TOO_SMALL;
        }
        if (k > 2 && step >= 2.0 * last) {
            return DEAD_CENTRE;
        }
        for (size_t i = 0; i < n; ++i) {
            x[first + i] -= correction[i];
        }
        last = step;
    }
    return DEAD_CENTRE;
}

/* all blocks by full Newton from the predicted w->trial */
static int full_newton(Run *run, Workspace *w, const double *alpha, Convergence *convergence)
{
    for (size_t number = 0; number < BLOCKS; ++number) {
        const int status = newton(run, number, alpha, w->trial, w, convergence);
        if (status != GOOD) {
            run->block = number;
            return status;
        }
    }
    return GOOD;
}

/* residuals become corrections of all blocks, with the Jacobian at w->x */
static void correct_from_reference(Run *run, const Workspace *w, double *correction)
{
    const double none[INPUTS] = { 0.0 };
    const Coordinates position = { w->alpha, w->x }, corrected = { none, correction };
    for (size_t number = 0; number < BLOCKS; ++number) {
        const size_t first = blocks[number].first, n = blocks[number].size;
        double coupling[LARGEST_BLOCK];
        /* what the corrections of the blocks before add to this one */
        velocity_equations(number, position, corrected, coupling);
        for (size_t i = 0; i < n; ++i) {
            correction[first + i] += coupling[i];
        }
        solve_block(number, w, correction + first);
        run->block = number;
    }
}

/* all blocks by the iteration of the paper, (27) and (28): a modified Newton method, whose
 * Jacobian stays that of the reference position w->x */
static int modified_newton(Run *run, Workspace *w, const double *alpha, Convergence *convergence)
{
    const Coordinates reference = { w->alpha, w->x }, trial = { alpha, w->trial };
    double correction[UNKNOWNS], ignored[LARGEST_BLOCK], last = HUGE_VAL;
    for (size_t number = 0; number < BLOCKS; ++number) {
        evaluate(number, reference, w, ignored);
    }
    for (int k = 0;; ++k) {
        for (size_t number = 0; number < BLOCKS; ++number) {
            position_equations(number, trial, correction + blocks[number].first, NULL);
        }
        convergence->residual = largest_residual(UNKNOWNS, correction);
        if (convergence->residual <= run->limit) {
            convergence->iterations = k;
            break;
        }
        if (!(convergence->residual < HUGE_VAL)) {
            return NOT_FINITE;
        }
        correct_from_reference(run, w, correction);
        const double step = largest_correction(UNKNOWNS, correction, unknowns);
        if (step >= last && last <= ROUNDING * LENGTH) {
            return LIMIT_TOO_SMALL;
        }
        if (k >= run->max_iterations || (k > 2 && step >= 2.0 * last)) {
            return DEAD_CENTRE;
        }
        for (size_t i = 0; i < UNKNOWNS; ++i) {
            w->trial[i] -= correction[i];
        }
        last = step;
    }
    for (size_t number = 0; number < BLOCKS; ++number) {
        if (is_dead_centre(evaluate(number, trial, w, ignored), w->orientation[number])) {
            run->block = number;
            return DEAD_CENTRE;
        }
    }
    return GOOD;
}

#endif
