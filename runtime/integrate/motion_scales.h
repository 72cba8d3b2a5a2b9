/* Scales of a motion so far: its largest rate, its extent, the energy that moves. Errors of
 * steps, of works and of the balance of energy are relative to these. */

/* scale of velocity errors, beside the velocities: the running maximum speed, clamped to between
 * NOTHING_MOVES over the longest step so far and this number over the step, in lengths of the scene
 * or radians. Below the lower bound speeds are rounding; it is no larger in a short step, as the
 * rates of what does move are not */
#define USUAL_STEP_MOTION 0.05

/* the largest speed so far and at the end of a step, in lengths of the scene and radians [1/s] */
static double fastest(const double *end, const State *s)
{
    return larger(larger(s->fastest, size_of(s->y + NQ)), size_of(end + NQ));
}

/* what the rates of a step are compared with, in lengths of the scene and radians [1/s]: told by
 * the motion, in other units of time it is the same */
static double usual_rate(double h, const double *end, const State *s)
{
    const double known = fastest(end, s);
    return smaller(USUAL_STEP_MOTION / h, larger(NOTHING_MOVES / larger(s->stride, h), known));
}

/* notes what later steps are compared with */
static void note_motion(double h, const double *end, State *s)
{
    s->fastest = fastest(end, s);
    s->stride = larger(s->stride, h);
}

/* notes how far coordinates go, those too that rows show, which were found there */
static void note_extent(const double *end, const double *w, State *s)
{
    for (size_t k = 0; k != NQ + N_SHOWN; ++k) {
        const double x = k < NQ ? end[k] : w[W_COORDINATES + PER_SHOWN * (k - NQ)];
        if (x < s->lowest[k]) s->lowest[k] = x;
        if (x > s->highest[k]) s->highest[k] = x;
    }
}

/* the energy of all bodies where they move at such a rate */
static double usual_energy(double rate) { return MASS * (LENGTH * rate) * (LENGTH * rate) / 2.0; }

/* energy that errors of works are compared with, where so much has moved in a step of length h. It
 * is that of all bodies at the usual rate up to the end, or the energy that has moved if that is
 * less: where one body is fast, heavy ones may stand. It is no less than that of all bodies at a
 * rate that counts as rest */
static double energy_of_works(double h, const double *end, double moved, const State *s)
{
    const double usual = usual_energy(usual_rate(h, end, s));
    const double least = usual_energy(NOTHING_MOVES / larger(s->stride, h));
    return smaller(usual, larger(least, moved));
}

/* the change of energy since the start that no work explains; works are in q */
static double energy_balance(const double *w, const double *q, const State *s)
{
    double balance = w[W_ENERGIES] + w[W_ENERGIES + 1] - s->energy;
    for (size_t k = NQ - WORKS; k != NQ; ++k) balance -= q[k];
    return balance;
}

/* kinetic energy, change of potential energy since the start, and all works, which are in q; that
 * of every step counts, whatever rows are written */
static double energy_moved(const double *w, const double *q, const State *s)
{
    double moved = w[W_ENERGIES] + fabs(w[W_ENERGIES + 1] - s->potential);
    for (size_t k = NQ - WORKS; k != NQ; ++k) moved += fabs(q[k]);
    return moved;
}

/* notes the energy that has moved at the end of a step that is kept */
static void note_moved(const Settings *settings, double moved, State *s)
{
    s->moved = larger(s->moved, moved);
    if (settings->checks) s->energy_moved = larger(s->energy_moved, moved);
}
