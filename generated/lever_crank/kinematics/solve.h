/* Position, velocity and acceleration analysis of a mechanism whose equations are
 * block-triangular: M. Yamada and S. Tatsumi (1981), with full Newton beside their iteration.
 *
 * There is no heap and no global state. The file that includes this defines before
 *     PUBLIC(name)      the exported name of a function
 *     DIGEST            of all that it was made of
 *     Run, Workspace    as in its own solver.h
 *     INPUTS, UNKNOWNS, BLOCKS, NODES, LINKS, SEGMENTS, LARGEST_BLOCK
 *     WANTS_ANGLES      whether the angles of links are wanted, 0 or 1
 *     LENGTH            the largest length
 *     W_ALPHA ...       places of the regions of the workspace
 *     unknowns, blocks, curves, input_scales
 *     defaults          the run that the scene asks for
 *     segments          of each block position, velocity and acceleration; then the results
 */
#ifndef KOUSOKU_KINEMATICS_SOLVE_H
#define KOUSOKU_KINEMATICS_SOLVE_H

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) ||     \
    defined(__NO_SIGNED_ZEROS__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "kousoku: verified numbers need IEEE arithmetic; compile without -ffast-math and its parts"
#endif

#include "approach.h"
#include "assembly.h"
#include "rows.h"

/* from division to division, beginning at that of w->x; rows are written from run->first on */
static int follow(Run *run, Workspace *w, Convergence convergence)
{
    double x_dot[UNKNOWNS], x_ddot[UNKNOWNS], home[UNKNOWNS];
    const long long begin = w->division;
    int status = GOOD;
    if (run->times) {
        motion_at(run, w, begin, x_dot, x_ddot);
        status = advance(run, w, 0, &convergence);
    }
    for (size_t i = 0; i < UNKNOWNS; ++i) {
        home[i] = w->x[i];
    }
    while (status == GOOD) {
        motion_at(run, w, w->division, x_dot, x_ddot);
        if (w->division >= run->first) {
            write_row(run, w, w->division, run->done, x_dot, x_ddot, convergence);
            ++run->done;
        }
        if (run->done == run->rows) {
            break;
        }
        status = advance(run, w, w->division + 1, &convergence);
        const long long gone = w->division - begin;
        if (status == GOOD && w->division < run->first && gone % run->divisions == 0 &&
            is_at(w, home)) {
            /* so many turns lead back, and so do as many more */
            w->division += (run->first - w->division) / gone * gone;
        }
    }
    return stop(run, w, status);
}

/* whether a run can be made at all */
static int is_possible(const Run *run)
{
    for (size_t i = 0; i < INPUTS; ++i) {
        if (!(fabs(run->origin[i]) < HUGE_VAL && fabs(run->span[i]) < HUGE_VAL &&
                fabs(run->rate[i]) < HUGE_VAL && fabs(run->rate_dot[i]) < HUGE_VAL)) {
            return 0;
        }
    }
    for (size_t row = 0; run->times && row < run->rows; ++row) {
        if (!(run->times[row] >= (row ? run->times[row - 1] : 0.0) && run->times[row] < HUGE_VAL)) {
            return 0;
        }
    }
    return (!run->times || run->first == 0) && run->divisions >= 1 && run->rows >= 1 &&
           run->start >= 0 && run->first >= run->start && run->max_iterations >= 1 &&
           run->limit > 0.0 && (run->method == 0 || run->method == 1);
}

const char *PUBLIC(digest)(void) { return DIGEST; }

size_t PUBLIC(run_size)(void) { return sizeof(Run); }

size_t PUBLIC(workspace_size)(void) { return sizeof(Workspace); }

void PUBLIC(defaults)(Run *run) { *run = defaults; }

int PUBLIC(solve)(Run *run, Workspace *workspace)
{
    Convergence convergence = { 0, 0.0 };
    int is_periodic = 1;
    run->done = 0;
    run->block = 0;
    if (!is_possible(run)) {
        return BAD_ARGUMENT;
    }
    laws_at(run, 0.0, workspace->alpha, workspace->rate);
    workspace->time = 0.0;
    for (size_t i = 0; i < INPUTS; ++i) {
        is_periodic = is_periodic && run->turns[i];
    }
    copy(workspace->alpha, defaults.origin, INPUTS); /* where the positions of the scene are */
    int status = assemble(run, workspace, &convergence);
    if (status == GOOD) {
        status = approach(run, workspace, &convergence);
    }
    workspace->step = HUGE_VAL;
    /* whole turns lead to the same inputs: the first position may be that of any */
    workspace->division = is_periodic ? run->start - run->start % run->divisions : 0;
    if (status != GOOD) {
        return stop(run, workspace, status);
    }
    convergence.iterations = 0; /* counted are those that lead from row to row */
    return follow(run, workspace, convergence);
}

const char *PUBLIC(message)(int status) { return message_of(status); }

void PUBLIC(evaluate)(size_t segment, double *w)
{
    if (segment < SEGMENTS) segments[segment](w);
}

#endif
