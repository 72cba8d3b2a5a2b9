/* Continuation of parameters: a start that the scene gives becomes that with the parameters of a
 * run. */

/* the largest correction with which parameters are changed at the start */
#define CLOSE 0.02
/* the smallest part of the way from the parameters of the scene to those of the run */
#define SHORTEST 1e-9

/* whether the numbers of the design in the workspace are possible */
static int is_possible(const double *w)
{
    for (size_t k = 0; k != POSITIVE; ++k) {
        if (!(w[W_DESIGN + positive[k]] > 0.0)) return 0;
    }
    return are_finite(w + W_DESIGN, N_DESIGN);
}

/* computes the numbers of the design anew, and moves a state as they move the start */
static void follow_design(double *y, double *w)
{
    for (size_t k = 0; k != STARTS; ++k) y[starts[k][0]] -= w[W_DESIGN + starts[k][1]];
    if (HAS_DESIGN) setup(w);
    for (size_t k = 0; k != STARTS; ++k) y[starts[k][0]] += w[W_DESIGN + starts[k][1]];
}

/* turns the parameters of the scene into those that are given by a part of the way */
static void set_parameters(const double *given, double part, double *w)
{
    for (size_t k = 0; k != N_PARAMETERS; ++k) {
        w[W_PARAMETERS + k] = part < 1.0 ? values[k] + part * (given[k] - values[k]) : given[k];
    }
}

/* brings positions to where bodies fit and drivers begin with the parameters of the run. That
 * may be far from where it is with those of the scene, so these become the others by small
 * steps: 0 if they cannot */
static int continue_parameters(State *s, Work *work)
{
    const double *given = s->parameters;
    double *w = work->w, *y = work->k[0], drift = 0.0, reached = 0.0, part = 1.0;
    memcpy(y, s->y, NY * sizeof *y);
    if (project(s->time, 0.0, y, NULL, NULL, work, s, &drift) && drift <= CLOSE) return 1;
    set_parameters(given, 0.0, w);
    follow_design(s->y, w);
    if (!project(s->time, 0.0, s->y, NULL, NULL, work, s, NULL)) return 0;
    while (reached < 1.0) {
        const double next = smaller(reached + part, 1.0);
        memcpy(y, s->y, NY * sizeof *y);
        set_parameters(given, reached, w);
        if (HAS_DESIGN) setup(w);
        set_parameters(given, next, w);
        follow_design(y, w);
        if (project(s->time, 0.0, y, NULL, NULL, work, s, &drift) && drift <= CLOSE) {
            memcpy(s->y, y, NY * sizeof *y);
            reached = next;
            part = 2.0 * part;
        } else {
            part = 0.5 * part;
            if (part < SHORTEST) return 0;
        }
    }
    return 1;
}
