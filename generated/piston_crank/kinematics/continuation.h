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

/* one step of the inputs: predict by (26), correct, and halve the step where that fails;
 * `delta` is the whole step, which ends at `target` */
static int advance(
    Run *run, Workspace *w, const double *target, const double *delta, Convergence *convergence)
{
    const double none[INPUTS] = { 0.0 };
    double left = 1.0, step = 1.0;
    int iterations = 0;
    for (int tries = 0; left > 0.0; ++tries) {
        double alpha[INPUTS], predicted[UNKNOWNS], moved = 0.0;
        step = step < left ? step : left;
        for (size_t i = 0; i < INPUTS; ++i) {
            alpha[i] = target[i] - (left - step) * delta[i];
            moved = fmax(moved, fabs(step * delta[i]) * input_scales[i]);
        }
        for (size_t i = 0; i < UNKNOWNS; ++i) {
            predicted[i] = w->x[i] + step * (w->x1[i] + 0.5 * step * w->x2[i]);
            w->trial[i] = predicted[i];
        }
        *convergence = (Convergence){ 0, 0.0 };
        const int status = run->method ? modified_newton(run, w, alpha, convergence)
                                       : full_newton(run, w, alpha, convergence);
        iterations += convergence->iterations;
        if (status != GOOD || !is_near(w, predicted, moved)) {
            step *= 0.5;
            if (step < SMALLEST_STEP || tries > 1000) {
                return status == GOOD ? DEAD_CENTRE : status;
            }
            continue;
        }
        accept_step(w, alpha);
        left -= step;
        step *= 2.0;
        if (left > 0.0) {
            differentiate(w, delta, none, w->x1, w->x2);
        }
    }
    convergence->iterations = iterations;
    return GOOD;
}

#endif
