/* Continuation: from one position to the next, by predictor and corrector. */
#ifndef KOUSOKU_KINEMATICS_CONTINUATION_H
#define KOUSOKU_KINEMATICS_CONTINUATION_H

#include "certificate.h"
#include "newton.h"

#define TWO_PI 6.283185307179586

/* the inputs of a division, each turn from the same numbers, and how far one division goes */
static void inputs_of(const Run *run, long long division, double *alpha, double *delta)
{
    for (size_t i = 0; i < INPUTS; ++i) {
        const double divisions = (double)run->divisions;
        if (run->turns[i]) {
            const long long part = run->turns[i] % run->divisions * (division % run->divisions);
            alpha[i] = run->origin[i] + TWO_PI * ((double)(part % run->divisions) / divisions);
            delta[i] = TWO_PI * ((double)run->turns[i] / divisions);
        } else {
            alpha[i] = run->origin[i] + run->span[i] * ((double)division / divisions);
            delta[i] = run->span[i] / divisions;
        }
    }
}

/* by how much inputs, counted on over the turns, are beyond those of a division */
static double whole_turns(const Run *run, size_t input, long long division)
{
    const long long divisions = run->divisions, turns = run->turns[input];
    const long long part = turns % divisions * (division % divisions) % divisions;
    const double gone = (double)turns * (double)division - (double)part;
    return run->times ? 0.0 : TWO_PI * rint(gone / (double)divisions);
}

/* the inputs by their laws in time, and their rates */
static void laws_at(const Run *run, double time, double *alpha, double *rate)
{
    for (size_t i = 0; i < INPUTS; ++i) {
        alpha[i] = run->origin[i] + (run->rate[i] + 0.5 * run->rate_dot[i] * time) * time;
        rate[i] = run->rate[i] + run->rate_dot[i] * time;
    }
}

/* where a step in time ends at the latest: at a time, or before it where an input turns back */
static double end_of(const Run *run, double now, double time)
{
    for (size_t i = 0; i < INPUTS; ++i) {
        const double turn = -run->rate[i] / run->rate_dot[i]; /* not finite: never */
        time = now < turn && turn < time ? turn : time;
    }
    return time;
}

/* how far the Jacobians turn along a step from w->x to w->trial, the most of all blocks; above
 * MOST_TILT it may have left its branch */
static double step_tilt(Run *run, const Workspace *w, double step, const double *pace,
    const double *pace_dot, const double *predicted, double residual)
{
    const double half = 0.5 * step * step;
    double most = 0.0;
    CubicTube way;
    for (size_t i = 0; i < INPUTS; ++i) {
        way.first[i] = step * pace[i];
        way.second[i] = half * pace_dot[i];
        way.third[i] = way.radius[i] = 0.0;
    }
    for (size_t i = 0; i < UNKNOWNS; ++i) {
        way.first[INPUTS + i] = step * w->x1[i];
        way.second[INPUTS + i] = half * w->x2[i];
        way.third[INPUTS + i] = w->trial[i] - predicted[i];
        way.radius[INPUTS + i] = 0.0;
    }
    for (size_t number = 0; number < BLOCKS && most <= MOST_TILT; ++number) {
        most = larger(most, tilt_of(number, w, &way, residual));
        run->block = number;
    }
    return most;
}

/* the corrected position becomes that of the workspace, angles next to zero */
static void accept_step(Workspace *w, const double *alpha)
{
    for (size_t i = 0; i < INPUTS; ++i) {
        w->alpha[i] = alpha[i];
    }
    for (size_t i = 0; i < UNKNOWNS; ++i) {
        const double turns = unknowns[i].is_angle ? rint(w->trial[i] / TWO_PI) : 0.0;
        w->x[i] = w->trial[i] - TWO_PI * turns;
    }
}

/* to a division, or to the time of a row, in steps of at most a division: predict by (26),
 * correct, and halve the step where that fails, or where no certificate tells that it stays on its
 * branch */
static int advance(Run *run, Workspace *w, long long row, Convergence *convergence)
{
    const double none[INPUTS] = { 0.0 };
    double target[INPUTS], delta[INPUTS], left = run->times ? run->times[row] - w->time : 1.0;
    const double *pace = run->times ? w->rate : delta;
    const double *pace_dot = run->times ? run->rate_dot : none;
    double residual = convergence->residual;
    int iterations = 0;
    inputs_of(run, row, target, delta);
    for (int tries = 0; left > 0.0; ++tries) {
        double alpha[INPUTS], rate[INPUTS], predicted[UNKNOWNS], part = 0.0, tilt = 0.0;
        double step = w->step < left ? w->step : left;
        const double end = run->times ? end_of(run, w->time, run->times[row]) : left;
        const double rest = end - w->time, time = step < rest ? w->time + step : end;
        step = step < rest ? step : rest;
        laws_at(run, time, alpha, rate);
        for (size_t i = 0; i < INPUTS; ++i) {
            const double whole = delta[i] != 0.0 ? delta[i] : LENGTH / input_scales[i];
            part = fmax(part, run->times ? fabs((alpha[i] - w->alpha[i]) / whole) : step);
            alpha[i] = run->times ? alpha[i] : target[i] - (left - step) * delta[i];
        }
        for (size_t i = 0; i < UNKNOWNS; ++i) {
            predicted[i] = w->x[i] + step * (w->x1[i] + 0.5 * step * w->x2[i]);
            w->trial[i] = predicted[i];
        }
        *convergence = (Convergence){ 0, 0.0 };
        int status = TOO_FAR;
        if (part <= 1.0) {
            status = run->method ? modified_newton(run, w, alpha, convergence)
                                 : full_newton(run, w, alpha, convergence);
        }
        if (status == GOOD) {
            const double worse = larger(residual, convergence->residual);
            tilt = step_tilt(run, w, step, pace, pace_dot, predicted, worse);
            status = tilt <= MOST_TILT ? GOOD : DEAD_CENTRE;
        }
        if (status != GOOD) {
            w->step = 0.5 * step;
            if (0.5 * part < SMALLEST_STEP || tries > MOST_TRIES) {
                return tries > MOST_TRIES ? TOO_FAR : status;
            }
            continue;
        }
        const double next = fmax(w->step, 2.0 * step);
        w->step = 2.0 * tilt <= MOST_TILT ? next : step;
        left -= step;
        iterations += convergence->iterations;
        residual = convergence->residual;
        accept_step(w, alpha);
        w->division = row;
        if (run->times) {
            laws_at(run, time, w->alpha, w->rate);
            w->time = time;
            left = run->times[row] - time;
        }
        if (left > 0.0) {
            differentiate(w, pace, pace_dot, w->x1, w->x2);
        }
    }
    w->division = row;
    *convergence = (Convergence){ iterations, residual };
    return GOOD;
}

/* derivatives in time for the row, and along the way for the next prediction: in time, too, or
 * along one division */
static void motion_at(
    const Run *run, Workspace *w, long long division, double *x_dot, double *x_ddot)
{
    const double none[INPUTS] = { 0.0 };
    double alpha[INPUTS], delta[INPUTS];
    inputs_of(run, division, alpha, delta);
    if (INPUTS > 1 || run->times) {
        differentiate(w, w->rate, run->rate_dot, x_dot, x_ddot);
        for (size_t i = 0; i < UNKNOWNS; ++i) {
            w->x1[i] = x_dot[i];
            w->x2[i] = x_ddot[i];
        }
        if (!run->times) {
            differentiate(w, delta, none, w->x1, w->x2);
        }
        return;
    }
    /* one input: both follow from the derivatives by it */
    const double one[INPUTS] = { 1.0 }, rate = run->rate[0], rate_dot = run->rate_dot[0];
    differentiate(w, one, none, w->x1, w->x2);
    for (size_t i = 0; i < UNKNOWNS; ++i) {
        x_dot[i] = w->x1[i] * rate;
        x_ddot[i] = w->x2[i] * rate * rate + w->x1[i] * rate_dot;
        w->x1[i] *= delta[0];
        w->x2[i] *= delta[0] * delta[0];
    }
}

/* whether unknowns are those of the position, angles up to whole turns; two assemblies are not as
 * near as that where pivots are above SINGULAR */
static int is_at(const Workspace *w, const double *x)
{
    double off[UNKNOWNS];
    for (size_t i = 0; i < UNKNOWNS; ++i) {
        off[i] = w->x[i] - x[i];
        off[i] -= unknowns[i].is_angle ? TWO_PI * rint(off[i] / TWO_PI) : 0.0;
    }
    return largest_correction(UNKNOWNS, off, unknowns) <= SETTLED * LENGTH;
}

#endif
