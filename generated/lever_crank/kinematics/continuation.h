/* Continuation: from one position to the next, by predictor and corrector. */
#ifndef KOUSOKU_KINEMATICS_CONTINUATION_H
#define KOUSOKU_KINEMATICS_CONTINUATION_H

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

/* whether the corrections stayed small beside the motion: else another branch may be near */
static int is_near(const Workspace *w, const double *predicted, double moved)
{
    double most = moved, corrected = 0.0;
    for (size_t i = 0; i < UNKNOWNS; ++i) {
        most = fmax(most, fabs(predicted[i] - w->x[i]) * unknowns[i].scale);
        corrected = fmax(corrected, fabs(w->trial[i] - predicted[i]) * unknowns[i].scale);
    }
    return corrected <= 0.25 * most + SETTLED * LENGTH;
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
 * correct, and halve the step where that fails */
static int advance(Run *run, Workspace *w, long long row, Convergence *convergence)
{
    const double none[INPUTS] = { 0.0 };
    double target[INPUTS], delta[INPUTS], left = run->times ? run->times[row] - w->time : 1.0;
    const double *pace = run->times ? w->rate : delta;
    const double *pace_dot = run->times ? run->rate_dot : none;
    double step = left;
    int iterations = 0;
    inputs_of(run, row, target, delta);
    for (int tries = 0; left > 0.0; ++tries) {
        double alpha[INPUTS], rate[INPUTS], predicted[UNKNOWNS], moved = 0.0, part = 0.0;
        const double end = run->times ? end_of(run, w->time, run->times[row]) : left;
        const double rest = end - w->time, time = step < rest ? w->time + step : end;
        step = step < rest ? step : rest;
        laws_at(run, time, alpha, rate);
        for (size_t i = 0; i < INPUTS; ++i) {
            double change = alpha[i] - w->alpha[i];
            if (!run->times) {
                alpha[i] = target[i] - (left - step) * delta[i];
                change = step * delta[i];
            }
            const double whole = delta[i] != 0.0 ? delta[i] : LENGTH / input_scales[i];
            part = fmax(part, run->times ? fabs(change / whole) : step);
            moved = fmax(moved, fabs(change) * input_scales[i]);
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
            iterations += convergence->iterations;
            status = status == GOOD && !is_near(w, predicted, moved) ? DEAD_CENTRE : status;
        }
        if (status != GOOD) {
            step *= 0.5;
            if (0.5 * part < SMALLEST_STEP || tries > MOST_TRIES) {
                return tries > MOST_TRIES ? TOO_FAR : status;
            }
            continue;
        }
        accept_step(w, alpha);
        left -= step;
        step *= 2.0;
        if (run->times) {
            laws_at(run, time, w->alpha, w->rate);
            w->time = time;
            left = run->times[row] - time;
        }
        if (left > 0.0) {
            differentiate(w, pace, pace_dot, w->x1, w->x2);
        }
    }
    convergence->iterations = iterations;
    return GOOD;
}

#endif
