/* Rows of results: what is wanted of a position. */
#ifndef KOUSOKU_KINEMATICS_ROWS_H
#define KOUSOKU_KINEMATICS_ROWS_H

#include "continuation.h"

/* what is wanted of a row of a result */
static void keep(double *wanted, size_t row, const double *found, size_t n)
{
    if (wanted) {
        copy(wanted + n * row, found, n);
    }
}

/* the position of the workspace goes into a row */
static void write_row(const Run *run, Workspace *w, long long division, size_t row,
    const double *x_dot, const double *x_ddot, Convergence convergence)
{
    look_at(w, w->alpha, w->x);
    copy(w->w + W_ALPHA_DOT, w->rate, INPUTS);
    copy(w->w + W_X_DOT, x_dot, UNKNOWNS);
    copy(w->w + W_ALPHA_DDOT, run->rate_dot, INPUTS);
    copy(w->w + W_X_DDOT, x_ddot, UNKNOWNS);
    segments[RESULTS](w->w);
    keep(run->position, row, w->w + W_POSITION, 2 * NODES);
    keep(run->velocity, row, w->w + W_VELOCITY, 2 * NODES);
    keep(run->acceleration, row, w->w + W_ACCELERATION, 2 * NODES);
#if WANTS_ANGLES
    segments[RESULTS + 1](w->w);
    keep(run->angle, row, w->w + W_ANGLE, LINKS);
    keep(run->angle_dot, row, w->w + W_ANGLE_DOT, LINKS);
    keep(run->angle_ddot, row, w->w + W_ANGLE_DDOT, LINKS);
#endif
    for (size_t i = 0; run->alpha && i < INPUTS; ++i) {
        const double turns = (double)run->turns[i], divisions = (double)run->divisions;
        const double gone = run->turns[i] ? TWO_PI * (turns * (double)division / divisions)
                                          : run->span[i] * ((double)division / divisions);
        run->alpha[INPUTS * row + i] = run->times ? w->alpha[i] : run->origin[i] + gone;
    }
    if (run->iterations) {
        run->iterations[row] = convergence.iterations;
    }
    if (run->residual) {
        run->residual[row] = convergence.residual;
    }
    if (run->condition) { /* where it stops there may be no factors */
        run->condition[row] = convergence.residual < HUGE_VAL ? condition_of(w) : HUGE_VAL;
    }
}

/* the inputs that were reached; after a failure the next row is where it stopped */
static int stop(Run *run, Workspace *w, int status)
{
    const double none[UNKNOWNS] = { 0.0 };
    for (size_t i = 0; i < INPUTS; ++i) {
        run->reached[i] = w->alpha[i] + whole_turns(run, i, w->division);
    }
    if (status != GOOD && run->done < run->rows) {
        write_row(run, w, 0, run->done, none, none, (Convergence){ 0, HUGE_VAL });
        for (size_t i = 0; run->alpha && i < INPUTS; ++i) {
            run->alpha[INPUTS * run->done + i] = run->reached[i];
        }
    }
    return status;
}

#endif
