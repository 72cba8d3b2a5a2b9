/* Approach: from the inputs of the scene, where it is assembled, to those where rows begin. */
#ifndef KOUSOKU_KINEMATICS_APPROACH_H
#define KOUSOKU_KINEMATICS_APPROACH_H

#include "continuation.h"

/* straight to other inputs, on the branch */
static int walk(Run *run, Workspace *w, const double *to, Convergence *convergence)
{
    double ignored[2][UNKNOWNS], far = 0.0;
    Run way = *run; /* one division, which ends at division 0: these inputs to the last digit */
    way.divisions = 1;
    way.times = NULL;
    for (size_t i = 0; i < INPUTS; ++i) {
        way.origin[i] = to[i];
        way.span[i] = to[i] - w->alpha[i];
        way.turns[i] = 0;
        far = larger(far, fabs(way.span[i]));
    }
    if (far == 0.0) {
        return GOOD;
    }
    w->step = HUGE_VAL;
    motion_at(&way, w, 0, ignored[0], ignored[1]);
    const int status = advance(&way, w, 0, convergence);
    run->block = way.block;
    return status;
}

/* straight to other inputs, by at most a turn at once, or as much as moves LENGTH as far: the
 * shortest steps are a part of that */
static int walk_on(Run *run, Workspace *w, const double *to, Convergence *convergence)
{
    double from[INPUTS], part[INPUTS], far = 0.0;
    for (size_t i = 0; i < INPUTS; ++i) {
        from[i] = w->alpha[i];
        far = larger(far, fabs(to[i] - from[i]) * input_scales[i] / LENGTH);
    }
    const double pieces = ceil(far / TWO_PI);
    int status = pieces < MOST_TRIES ? GOOD : TOO_FAR;
    for (double k = 1.0; status == GOOD && k < pieces; k += 1.0) {
        for (size_t i = 0; i < INPUTS; ++i) part[i] = from[i] + (to[i] - from[i]) * (k / pieces);
        status = walk(run, w, part, convergence);
    }
    return status == GOOD ? walk(run, w, to, convergence) : status;
}

/* to where the run begins: whole turns with it, for they need not lead back; so many as do are made
 * once */
static int approach(Run *run, Workspace *w, Convergence *convergence)
{
    const double far = run->origin[0] - w->alpha[0], turn = copysign(TWO_PI, far);
    double left = INPUTS == 1 && run->turns[0] ? floor(far / turn) : 0.0;
    double home[UNKNOWNS], to[INPUTS] = { 0.0 };
    copy(home, w->x, UNKNOWNS);
    int status = left < MOST_TRIES ? GOOD : TOO_FAR;
    for (double gone = 1.0; status == GOOD && left > 0.0; gone += 1.0) {
        to[0] = w->alpha[0] + turn;
        status = walk(run, w, to, convergence);
        left -= 1.0;
        if (status == GOOD && is_at(w, home)) {
            const double rest = fmod(left, gone);
            w->alpha[0] += turn * (left - rest);
            left = rest;
        }
    }
    return status == GOOD ? walk_on(run, w, run->origin, convergence) : status;
}

#endif
