/* Assembly: the first position, from the approximate one of the scene. */
#ifndef KOUSOKU_KINEMATICS_ASSEMBLY_H
#define KOUSOKU_KINEMATICS_ASSEMBLY_H

#include "newton.h"

/* a step of damped Newton, halved until the residual falls enough; w->x moves */
static int damped_step(size_t number, Workspace *w, double *correction, double residual)
{
    const size_t first = blocks[number].first, n = blocks[number].size;
    const Coordinates position = { w->alpha, w->x };
    double before[LARGEST_BLOCK], epsilon[LARGEST_BLOCK];
    solve_block(number, w, correction);
    for (size_t i = 0; i < n; ++i) {
        before[i] = w->x[first + i];
    }
    for (double part = 1.0; part >= SMALLEST_STEP; part *= 0.5) {
        for (size_t i = 0; i < n; ++i) {
            w->x[first + i] = before[i] - part * correction[i];
        }
        position_equations(number, position, epsilon, NULL);
        if (largest_residual(n, epsilon) <= (1.0 - 0.25 * part) * residual) {
            return GOOD;
        }
    }
    return NOT_ASSEMBLED;
}

/* one block at the first position, and its assembly mode; the blocks before are assembled */
static int assemble_block(const Run *run, size_t number, Workspace *w, Convergence *convergence)
{
    const size_t n = blocks[number].size;
    const Coordinates position = { w->alpha, w->x };
    double correction[LARGEST_BLOCK];
    const double given = evaluate(number, position, w, correction);
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
        pivot = evaluate(number, position, w, correction);
        residual = largest_residual(n, correction);
    }
    w->orientation[number] = 0.0; /* not known before: either side is good */
    const int status = newton(run, number, w->alpha, w->x, w, convergence);
    if (status == DEAD_CENTRE) {
        return residual <= SETTLED * LENGTH ? ON_DEAD_CENTRE : NOT_ASSEMBLED;
    }
    if (status != GOOD) {
        return status;
    }
    pivot = evaluate(number, position, w, correction);
    w->orientation[number] = pivot;
    return fabs(given) > 0.01 && given * pivot < 0.0 ? OTHER_SIDE : GOOD;
}

/* the first position, block after block */
static int assemble(Run *run, Workspace *w, Convergence *convergence)
{
    for (size_t i = 0; i < UNKNOWNS; ++i) {
        w->x[i] = unknowns[i].start;
    }
    for (size_t number = 0; number < BLOCKS; ++number) {
        const int status = assemble_block(run, number, w, convergence);
        run->block = number;
        if (status != GOOD) {
            return status;
        }
    }
    return GOOD;
}

#endif
