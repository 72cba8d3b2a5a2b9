/* Newton's method: full, block after block, and with the Jacobian of a reference position. */
#ifndef KOUSOKU_KINEMATICS_NEWTON_H
#define KOUSOKU_KINEMATICS_NEWTON_H

#include "block_equations.h"
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

/* Newton's method on one block, where it is looked at */
static int newton(const Run *run, size_t number, Workspace *w, Convergence *convergence)
{
    const size_t first = blocks[number].first, n = blocks[number].size;
    double *x = looked_at(number, w);
    double correction[LARGEST_BLOCK], last = HUGE_VAL;
    for (int k = 0; k <= run->max_iterations; ++k) {
        const double pivot = evaluate(number, w, correction);
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
        /* corrections may grow while it is far from a solution, but no more after three */
        if (k > 2 && step >= 2.0 * last) {
            return DEAD_CENTRE;
        }
        for (size_t i = 0; i < n; ++i) {
            x[i] -= correction[i];
        }
        last = step;
    }
    return DEAD_CENTRE;
}

/* all blocks by full Newton from the predicted w->trial */
static int full_newton(Run *run, Workspace *w, const double *alpha, Convergence *convergence)
{
    look_at(w, alpha, w->trial);
    for (size_t number = 0; number < BLOCKS; ++number) {
        const int status = newton(run, number, w, convergence);
        if (status != GOOD) {
            run->block = number;
            return status;
        }
    }
    copy(w->trial, w->w + W_X, UNKNOWNS);
    return GOOD;
}

/* residuals become corrections of all blocks, with the Jacobian at w->x */
static void correct_from_reference(Run *run, Workspace *w, double *correction)
{
    const double none[INPUTS] = { 0.0 };
    look_at(w, w->alpha, w->x);
    copy(w->w + W_ALPHA_DOT, none, INPUTS);
    for (size_t number = 0; number < BLOCKS; ++number) {
        const size_t first = blocks[number].first, n = blocks[number].size;
        /* what the corrections of the blocks before add to this one */
        run_segment(number, VELOCITY, w);
        for (size_t i = 0; i < n; ++i) {
            correction[first + i] += w->w[W_NU + i];
        }
        solve_block(number, w, correction + first);
        copy(w->w + W_X_DOT + first, correction + first, n);
        run->block = number;
    }
}

/* all blocks by the iteration of the paper, (27) and (28): a modified Newton method, whose
 * Jacobian stays that of the reference position w->x */
static int modified_newton(Run *run, Workspace *w, const double *alpha, Convergence *convergence)
{
    double correction[UNKNOWNS], ignored[LARGEST_BLOCK], last = HUGE_VAL;
    look_at(w, w->alpha, w->x);
    for (size_t number = 0; number < BLOCKS; ++number) {
        evaluate(number, w, ignored);
    }
    for (int k = 0;; ++k) {
        look_at(w, alpha, w->trial);
        for (size_t number = 0; number < BLOCKS; ++number) {
            find_residuals(number, w, correction + blocks[number].first);
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
        if (step >= last && last <= ROUNDING_OF_POSITIONS * LENGTH) {
            return LIMIT_TOO_SMALL;
        }
        /* as above, corrections grow no more after three */
        if (k >= run->max_iterations || (k > 2 && step >= 2.0 * last)) {
            return DEAD_CENTRE;
        }
        for (size_t i = 0; i < UNKNOWNS; ++i) {
            w->trial[i] -= correction[i];
        }
        last = step;
    }
    for (size_t number = 0; number < BLOCKS; ++number) {
        if (is_dead_centre(evaluate(number, w, ignored), w->orientation[number])) {
            run->block = number;
            return DEAD_CENTRE;
        }
    }
    return GOOD;
}

#endif
