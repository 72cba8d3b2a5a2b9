/* Assembly: the position of the scene, from its approximate one. */
#ifndef KOUSOKU_KINEMATICS_ASSEMBLY_H
#define KOUSOKU_KINEMATICS_ASSEMBLY_H

#include "newton.h"

/* a step of damped Newton, halved until the residual falls enough */
static int damped_step(size_t number, Workspace *w, double *correction, double residual)
{
    const size_t n = blocks[number].size;
    double *x = looked_at(number, w);
    double before[LARGEST_BLOCK], epsilon[LARGEST_BLOCK];
    solve_block(number, w, correction);
    copy(before, x, n);
    for (double part = 1.0; part >= SMALLEST_STEP; part *= 0.5) {
        for (size_t i = 0; i < n; ++i) {
            x[i] = before[i] - part * correction[i];
        }
        find_residuals(number, w, epsilon);
        if (largest_residual(n, epsilon) <= (1.0 - 0.25 * part) * residual) {
            return GOOD;
        }
    }
    return NOT_ASSEMBLED;
}

/* one block at the position of the scene, and its assembly mode; the blocks before are assembled */
static int assemble_block(const Run *run, size_t number, Workspace *w, Convergence *convergence)
{
    const size_t n = blocks[number].size;
    double correction[LARGEST_BLOCK];
    const double given = evaluate(number, w, correction);
    double pivot = given, residual = largest_residual(n, correction);
    for (int k = 0; k < 200 && residual > SETTLED * LENGTH; ++k) {
        if (!(residual < HUGE_VAL)) {
            return NOT_FINITE;
        }
        if (!(fabs(pivot) > SINGULAR)) {
            return k == 0 ? ON_DEAD_CENTRE : NOT_ASSEMBLED;
        }
        if (damped_step(number, w, correction, residual) != GOOD) {
            return NOT_ASSEMBLED;
        }
        pivot = evaluate(number, w, correction);
        residual = largest_residual(n, correction);
    }
    w->orientation[number] = 0.0; /* not known before: either side is good */
    const int status = newton(run, number, w, convergence);
    if (status == DEAD_CENTRE) {
        return residual <= SETTLED * LENGTH ? ON_DEAD_CENTRE : NOT_ASSEMBLED;
    }
    if (status != GOOD) {
        return status;
    }
    pivot = evaluate(number, w, correction);
    w->orientation[number] = pivot;
    return fabs(given) > 0.01 && given * pivot < 0.0 ? OTHER_SIDE : GOOD;
}

/* the position of the scene, block after block */
static int assemble(Run *run, Workspace *w, Convergence *convergence)
{
    int status = GOOD;
    for (size_t i = 0; i < UNKNOWNS; ++i) {
        w->x[i] = unknowns[i].start;
    }
    look_at(w, w->alpha, w->x);
    for (size_t number = 0; number < BLOCKS && status == GOOD; ++number) {
        status = assemble_block(run, number, w, convergence);
        run->block = number;
    }
    copy(w->x, w->w + W_X, UNKNOWNS);
    return status;
}

#endif
