/* Continuation of parameters: a start that the scene gives becomes that with the parameters of a
 * run. */

/* the largest correction with which parameters are changed at the start */
#define LARGEST_CORRECTION 0.02
/* the smallest part of the way from the parameters of the scene to those of the run */
#define SHORTEST_PARAMETER_STEP 1e-9
/* the least square of Euler parameters that are all there, and the cosine of half a jump */
#define ALL_OF_IT 0.999999
#define JUMP 0.5
/* positions that are looked at to see whether joints come open, how far bodies move from one to the
 * next, relative to LENGTH or in radians, and how often that is tried, each time half as far; a
 * direction that is smaller than this is none */
#define MOST_CLOSURE_CHECKS 24
#define STEP_ASIDE 0.25
#define MOST_HALVINGS 5
#define SMALLEST_DIRECTION 1e-6
/* at a pivot ratio so much smaller than the largest on the way a singular configuration is near */
#define NEAR_SINGULAR 0.25

/* whether parameters may change where bodies or drivers begin */
enum { HAS_CONTINUATION = HAS_DESIGN || (HAS_DRIVERS && N_PARAMETERS > 0) };

/* whether the numbers of the design in the workspace are possible */
static int is_possible(const double *w)
{
    for (size_t k = 0; k != POSITIVE; ++k) {
        if (!(w[W_DESIGN + positive[k]] > 0.0)) return 0;
    }
    return are_finite(w + W_DESIGN, N_DESIGN);
}

/* whether the principal axes of a body become others, as beside equal moments: its Euler parameters
 * at the start are then far from those before. All that are not zero vary */
static int axes_jump(size_t n, const double *before, const double *after)
{
    double sizes[3] = { 0.0 };
    for (size_t k = 0; k != n; ++k) {
        sizes[0] += before[k] * before[k];
        sizes[1] += after[k] * after[k];
        sizes[2] += before[k] * after[k];
    }
    return sizes[0] > ALL_OF_IT && sizes[1] > ALL_OF_IT && fabs(sizes[2]) < JUMP;
}

/* the product of Euler parameters; those of a turn in a plane are two */
static void turned_by(size_t n, const double *q, double *p)
{
    const double a = p[0], b = p[1], c = n == 2 ? 0.0 : p[2], d = n == 2 ? 0.0 : p[3];
    if (n == 2) {
        p[0] = a * q[0] - b * q[1];
        p[1] = a * q[1] + b * q[0];
        return;
    }
    p[0] = a * q[0] - b * q[1] - c * q[2] - d * q[3];
    p[1] = a * q[1] + b * q[0] + c * q[3] - d * q[2];
    p[2] = a * q[2] - b * q[3] + c * q[0] + d * q[1];
    p[3] = a * q[3] + b * q[2] - c * q[1] + d * q[0];
}

/* computes the numbers of the design anew, and moves a state as they move the start */
static void follow_design(double *y, double *w)
{
    double before[ROOM(NY)] = { 0.0 }, after[ROOM(NY)] = { 0.0 };
    for (size_t k = 0; k != STARTS; ++k) before[starts[k][0]] = w[W_DESIGN + starts[k][1]];
    if (HAS_DESIGN) setup(w);
    for (size_t k = 0; k != STARTS; ++k) after[starts[k][0]] = w[W_DESIGN + starts[k][1]];
    for (size_t k = 0; STARTS != 0 && k != ORIENTATIONS; ++k) {
        const size_t first = orientations[k][0], n = orientations[k][2];
        if (!axes_jump(n, before + first, after + first)) continue;
        for (size_t i = first + 1; i != first + n; ++i) before[i] = -before[i];
        turned_by(n, before + first, y + first);
        turned_by(n, after + first, y + first);
        for (size_t i = first; i != first + n; ++i) before[i] = after[i] = 0.0;
    }
    for (size_t k = 0; k != STARTS; ++k) y[starts[k][0]] -= before[starts[k][0]];
    for (size_t k = 0; k != STARTS; ++k) y[starts[k][0]] += after[starts[k][0]];
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
 * steps: 0 if they cannot. Velocities stay as they are given, however many steps it takes: they are
 * projected once, at the end of the way */
static int continue_parameters(State *s, Work *work)
{
    const double *given = s->parameters;
    double *w = work->w, *y = work->k[0], *v = work->k[1];
    double drift = 0.0, reached = 0.0, part = 1.0;
    memcpy(y, s->y, NY * sizeof *y);
    if (project(s->time, 0.0, y, NULL, NULL, work, s, &drift) && drift <= LARGEST_CORRECTION)
        return 1;
    memcpy(v, s->y + NQ, NV * sizeof *v);
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
        if (project(s->time, 0.0, y, NULL, NULL, work, s, &drift) && drift <= LARGEST_CORRECTION) {
            memcpy(s->y, y, NY * sizeof *y);
            reached = next;
            part = 2.0 * part;
        } else {
            part = 0.5 * part;
            if (part < SHORTEST_PARAMETER_STEP) return 0;
        }
    }
    memcpy(s->y + NQ, v, NV * sizeof *v);
    return 1;
}

/* whether the parameters of a run are others than those of the scene */
static int are_changed(const double *given)
{
    for (size_t k = 0; k != N_PARAMETERS; ++k) {
        if (given[k] != values[k]) return 1;
    }
    return 0;
}

/* moves positions along a displacement and back onto the rows: 0 if that is impossible */
static int step_along(const double *u, double *y, Work *work, State *s)
{
    double *w = work->w, *there = work->y, drift = 0.0, way = STEP_ASIDE;
    for (int n = 0; n < MOST_HALVINGS; ++n) {
        place(s->time, y, w);
        for (size_t k = 0; k < NV; ++k) w[W_DQ + k] = way * u[k];
        displace(w, NULL);
        memcpy(there, w + W_Q, NQ * sizeof *there);
        memcpy(there + NQ, y + NQ, NV * sizeof *there);
        if (project(s->time, 0.0, there, NULL, NULL, work, s, &drift) &&
            drift <= LARGEST_CORRECTION) {
            memcpy(y, there, NY * sizeof *there);
            return 1;
        }
        way *= 0.5;
    }
    return 0;
}

/* whether rows that are left out depend on others where bodies may move. Rows may miss
 * CLOSURE_TOLERANCE where the run starts, and per unit of motion there and along the way, which is
 * the root of the sum of squares over all bodies; what that adds up to ends a run only where it is
 * clearly more. Near a singular configuration one freedom more is nearly open, and what rows miss
 * along it tells nothing. What is too much takes the place of residuals. */
static int stay_closed_along(State *s, Work *work)
{
    double *w = work->w, *y = work->k[0], *u = work->k[1];
    double still[NCHECK + 1], usual = 0.0;
    memcpy(y, s->y, NY * sizeof *y);
    if (!project(s->time, 0.0, y, NULL, NULL, work, s, NULL)) return 1;
    for (size_t k = 0; k < NV; ++k) { /* no special direction */
        const double x = 0.6180339887498949 * (double)(k + 1);
        u[k] = (x - floor(x) - 0.5) * (is_length[k] ? LENGTH : 1.0);
    }
    for (int attempt = 0; attempt < MOST_CLOSURE_CHECKS; ++attempt) {
        const double ratio = pivot_ratio(work, s);
        const int is_regular = ratio >= NEAR_SINGULAR * usual;
        usual = larger(usual, ratio);
        check(w);
        if (is_regular && !are_closed(w + W_C, attempt ? CLEARLY : 1.0)) return 0;
        take_normal_part(1.0, y + NQ, work, u);
        const double size = size_of(u);
        if (ratio < WEAK_PIVOT_RATIO || !(size > SMALLEST_DIRECTION)) return 1;
        double motion = 0.0;
        for (size_t k = 0; k < NV; ++k) {
            u[k] /= size;
            const double part = u[k] / (is_length[k] ? LENGTH : 1.0);
            motion += part * part;
        }
        memset(w + W_V, 0, NV * sizeof *w);
        check(w);
        memcpy(still, w + W_C_DOT, NCHECK * sizeof *still);
        memcpy(w + W_V, u, NV * sizeof *w);
        check(w);
        for (size_t k = 0; k != NCHECK; ++k) {
            w[W_C + k] = (w[W_C_DOT + k] - still[k]) / sqrt(motion);
        }
        if (is_regular && !are_closed(w + W_C, 1.0)) return 0;
        if (!step_along(u, y, work, s)) return 1;
    }
    return 1;
}

/* whether rows that are left out, because they depend on others with the parameters of the scene,
 * do so with those of the run. All rows are looked at, as many as are independent, whichever are
 * kept: so a file with these parameters is looked at. The state stays as it is. */
static int stay_closed(State *s, Work *work)
{
    enum { SINGLE = offsetof(State, y) / sizeof(double) };
    double counts[SINGLE];
    memcpy(counts, s, sizeof counts);
    s->largest_pivot_ratio = ALL_OF_THEM;
    const int is_good = stay_closed_along(s, work);
    memcpy(s, counts, sizeof counts);
    return is_good;
}
