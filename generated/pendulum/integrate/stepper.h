/* The stepper: an explicit Runge-Kutta step, its error, and how long the next one is. */

/* largest constraint correction that may be left at a stage inside of a step, in units of the
 * tolerance */
#define STAGE_RESIDUAL 1e-3
/* how often a step is shortened at most because rows are nearly dependent at one of its stages;
 * then the length with the largest pivot ratio is taken */
#define MOST_AVOIDED 8
/* factor by which such a step is shortened each time, so that its stages lie elsewhere */
#define AVOIDING_STEP_PART 0.9
/* how often a step is made again at most for each of three reasons: samples do not resolve a part
 * that varies with the state, a stage lies beyond a switch that the polynomial does not meet, or
 * samples are few for how a part varies */
#define MOST_SHORTER 8
/* reject a step if a stage with zero weight at its end has accelerations more than this many times
 * those of the other stages, and the speeds at its end over its length */
#define THROWN_OFF 10.0
/* a rejected step is cut for a crossing no earlier than at this part of its length: what its
 * polynomial shows before that is not believed. A step of fixed length is treated alike if its
 * relative error is larger than this number */
#define LEAST_PART 0.02
/* largest number of re-locations of an event that cuts a step */
#define MOST_POLISHED 3
/* largest constraint correction of a step with drivers, in lengths of the scene or radians: no
 * error tells how far drivers led */
#define MOST_DRIVEN_CORRECTION 1e-3
/* part of the constraint-normal error that is discounted. All of it is with drivers, which are
 * exact, and near a singularity, where it is rounding */
#define FORGIVEN_NORMAL_PART 0.5
/* pivot ratio, relative to the largest so far, below which a step counts as near a singularity: its
 * constraint-normal error and its drift are rounding there */
#define CLEAR_PIVOT_RATIO 1e-3
/* largest drift of a step off the constraints, in tolerances: half of what the verdict on a run
 * trusts. Estimates can be blind where bodies turn by some radians in a step, the drift is not */
#define MOST_DRIFT 50.0
/* smallest tolerance that this limit of the drift is computed with */
#define LEAST_DRIFT 1e-11
/* weight of the worse of the two estimates of DOP853 where the better one may be blind. Steps from
 * a switch to the next begin and end at the same phases of a periodic force, so that their errors
 * have one sign and add up. For a half-wave of a sine in one step of DOP853 the better estimate is
 * 4 times too small; the weighted worse one is 10 times too large. Over a steep rise of a force
 * both have been blind */
#define WORSE_ERROR_PART 4e-3
/* earliest part of a step at which a stage gives the third point of a parabola through the branch
 * ratios at its ends: branch ratios go with the square of the distance from a place where branches
 * meet */
#define INNER_STAGE_PART 0.25
/* check a step for other branches if its smallest branch ratio, by this parabola or at a stage, is
 * below this part of the larger ratio at its ends */
#define FALLEN_RATIO_PART 0.1
/* check a step for other branches, too, if a stage has a branch ratio below this part of the
 * smaller ratio at its ends */
#define DIPPED_RATIO_PART 0.75
/* check a step for other branches, too, if a branch ratio at its ends is below this part of the
 * largest so far and the step is long in the sense of FAR_WAY_PART */
#define SMALL_RATIO_PART 1e-3
/* a step is long if bodies move in it by more than this part of the distance to the place where
 * branches meet, taken as the root of the larger branch ratio at its ends over the largest so
 * far */
#define FAR_WAY_PART 0.5
/* longest motion of bodies in a step that is checked for other branches, in lengths of the scene or
 * radians: how branch ratios vary is not known over longer ones */
#define LONGEST_NEAR_BRANCHES 0.75
/* tolerance above which the motion in every step is limited, so that no stages pass by a place
 * where branches meet. Where drivers determine the motion it is so at every tolerance */
#define LOOSE_TOLERANCE 1e-3
/* longest motion of bodies in a step that is limited for this reason, in lengths of the scene or
 * radians */
#define LONGEST_IF_LOOSE 1.2
/* number of stages from which on a method has many: they lie twice as densely in a step */
#define MANY_STAGES 12
/* longest motion of bodies, instead of LONGEST_IF_LOOSE, where drivers determine it and the method
 * has many stages. Two bodies turn towards each other by twice as much, which is less than half a
 * turn: no step passes two places where branches meet */
#define LONGEST_OF_MANY_STAGES 1.5
/* these limits do not apply where the smallest branch ratio in a step exceeds this part of the
 * largest: no place where branches meet is passed by if ratios are as level as that */
#define LEVEL_RATIO_PART 0.999
/* factor of the estimated error where the two results that an estimate compares are off alike. They
 * are from a place on where a force goes with t^p: the error is 64 times the estimate for p = 0.1,
 * 37 times for a square root and 11 times for p = 1.5. Over steep rises of forces the error of one
 * step in 200 is more than 100 times the estimate without this factor */
#define BLIND_ERROR 40.0
/* the same factor for methods with many stages, where the error is 7, 5 and 3 times the estimate
 * for these p */
#define BLIND_ERROR_OF_MANY_STAGES 5.0
/* the root of the branch ratio may have changed its sign between two stages if a line through the
 * roots at one of them and at the stage beyond it leads to less than this part of the root at the
 * other one */
#define SIGN_CHANGE_PART 0.2
/* safety factor of a step length that follows from a longest motion of bodies */
#define LIMITED_STEP_PART 0.98
/* motion of bodies in a step, in lengths of the scene or radians, below which it is not shortened
 * any more to find its branch */
#define SHORTEST_BRANCH_WAY 1e-4
/* safety factor of the step-size control h SAFETY error^(-0.8 / k) error_before^(0.2 / k) with the
 * order k, see docs/dynamics.md. It is the PI controller of Gustafsson, ACM Trans. Math. Softw. 17
 * (1991), with k_P = 0.2 / k and k_I + k_P = 0.8 / k */
#define SAFETY 0.8
/* exponent of the error of a step, times -k: (k_I + k_P) k */
#define ERROR_EXPONENT 0.8
/* exponent of the error of the step before, times k: k_P k. It damps steps whose lengths swing
 * about a bound of stability */
#define EARLIER_ERROR_EXPONENT 0.2
/* lower bound of the error of the step before, in units of the tolerance: one that is zero by
 * chance would make the next step short */
#define LEAST_EARLIER_ERROR 1e-4
/* largest ratio of a step length to the one before, 1 after a rejected step: error estimates are
 * local and tell nothing further on. See Hairer, Norsett, Wanner, Solving Ordinary Differential
 * Equations I, II.4 */
#define MOST_STEP_FACTOR 10.0
/* smallest ratio of a step length to the one before */
#define LEAST_STEP_FACTOR 0.2
/* error, in units of the tolerance, of a trial that cannot be kept and whose error tells nothing:
 * the next one is much shorter */
#define REFUSED_ERROR 1e3
/* weight of the estimate e_2 of order 3 beside e of order 5 in the error of DOP853, e^2 / sqrt(e^2
 * + 0.01 e_2^2): it goes with h^8 as the error does. The same book, II.10 */
#define WORSE_ESTIMATE_PART 0.01
/* scale of velocity errors, beside the velocities: the running maximum speed, clamped to between
 * NOTHING_MOVES over the longest step so far and this number over the step, in lengths of the scene
 * or radians. Below the lower bound speeds are rounding; it is no larger in a short step, as the
 * rates of what does move are not */
#define USUAL_STEP_MOTION 0.05
/* motion of bodies in the Euler step that precedes the first step, in lengths of the scene or
 * radians: it tells how derivatives change. Also the factor of the tolerance from which the length
 * of the first step follows. The same book, II.4 */
#define FIRST_STEP_MOTION 0.01
/* length of this Euler step where nothing moves yet, relative to the whole time */
#define FIRST_STEP_SPAN_PART 1e-6
/* largest ratio of the first step to this Euler step */
#define MOST_FIRST_FACTOR 100.0

/* whether roots of the branch ratio are tracked from stage to stage, to tell where they change
 * sign */
enum { TRACKS_ROOTS = HAS_REFINEMENT && !IS_DRIVEN };

/* a step of length h that is tried */
typedef struct {
    double h, end;                  /* its length, and the time of its end [s] */
    double drift, error;            /* correction of its end; error / tolerance */
    double error_if_blind;          /* error where estimates may be blind */
    double moved;                   /* energy moved up to its end, if rows are checked [J] */
    double least_ratio, most_ratio; /* smallest, largest pivot ratio of its stages */
    double inner_ratio, inner;      /* branch ratio of a stage inside; its part of the step */
    double dip_ratio, dip;          /* smallest branch ratio inside; its part of the step */
    /* parts of the step in order, with that of a stage of the step before, which is negative, and
     * roots of the branch ratio there */
    double parts[ROOM(TRACKS_ROOTS * (STAGES + 2))], roots[ROOM(TRACKS_ROOTS * (STAGES + 2))];
    size_t count;
    double last_ratio;           /* pivot ratio of its end */
    double end_ratio, top_ratio; /* branch ratio there, see pivot_monitor.h; largest one */
    int branch;                  /* whether it may end on another branch, see branches.h */
    double longest;              /* length at which ratios tell of branches, if it is longer [s] */
    int is_last;                 /* whether it ends at the latest time that the step may reach */
    int is_good, is_whole; /* whether its stages exist; it may be kept if its error is small */
    int is_vague;          /* whether its length is fixed and its error beyond LEAST_PART */
} Trial;

/* the attempts to make a step */
typedef struct {
    const Method *m;
    const Settings *settings;
    int is_fixed;             /* whether its length is asked for */
    double asked, end, limit; /* next time to be written; latest end, now and uncut [s] */
    /* largest pivot ratio of a trial with nearly dependent rows, each taken at its worst stage;
     * length of this trial [s] */
    double best, best_h;
    int avoided;     /* number of trials with nearly dependent rows */
    int is_beyond;   /* whether the step is to go beyond its latest end */
    int is_rejected; /* whether a trial had too large an error */
    int is_guessed;  /* whether a trial was cut short for anything but a distance or a jump */
    /* how often samples of parts that vary with the state were looked at to shorten a trial; how
     * often it was shortened for a stage beyond a switch that its polynomial misses */
    int shorter, thrown;
    int coarse;    /* how often samples were few for how a part varies in a trial */
    int polished;  /* how often an event was located again */
    int status;    /* GOOD, or why there is no step */
    Search search; /* for what crosses in the last one */
} Attempts;

/* whether a trial meets the tolerance */
static int is_kept(const Trial *trial) { return trial->error <= 1.0; }

/* adds y to what it starts from: a small sum, so that y is rounded once; what that leaves over goes
 * to low if it is not NULL */
static void add_to_start(const double *start, double *y, double *low)
{
    for (size_t i = 0; i < NY; ++i) {
        const double small = y[i];
        y[i] = start[i] + small;
        if (low) low[i] = rounding_of_sum(start[i], small, y[i]);
    }
}

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

/* the root mean square of one estimate of the error, in units of the tolerance */
static double estimate(const Method *m, const double *row, const Trial *trial, const State *s,
    Work *work, double tolerance)
{
    const double *now = s->y, *end = work->y;
    double *error = work->scratch, *u = work->u, sum = 0.0;
    const double rate = usual_rate(trial->h, end, s);
    const int is_clear = !HAS_DRIVERS &&
                         trial->least_ratio >= CLEAR_PIVOT_RATIO * s->largest_pivot_ratio;
    const double forgiven = is_clear ? FORGIVEN_NORMAL_PART : 1.0;
    combine(m->stages + 1, row, NULL, trial->h, work->k, error);
    for (int part = 0; part < 2; ++part) {
        if (part == 0) displacement_of(end, error, u);
        else memcpy(u, error + NQ, NV * sizeof *u);
        take_normal_part(forgiven, end + NQ, work, u);
        for (size_t i = 0; i < NV; ++i) {
            double size = is_length[i] ? LENGTH : 1.0;
            if (part) size = rate * size + larger(fabs(now[NQ + i]), fabs(end[NQ + i]));
            sum += (u[i] / size) * (u[i] / size);
        }
    }
    /* work is compared with the energy that moves */
    for (size_t i = NQ - WORKS; i != NQ; ++i) {
        const double moved = m->work_scale * larger(s->moved, trial->moved);
        const double moving = energy_of_works(trial->h, end, moved, s);
        const double least = moving + work->w[W_ENERGIES];
        const double size = least + larger(fabs(now[i]), fabs(end[i]));
        sum += (error[i] / size) * (error[i] / size);
    }
    return sqrt(sum / (double)(2 * NV)) / tolerance;
}

/* whether the drift of a step off the constraints is due to its error. It is not where drivers or
 * rows that take over cause it, or near a singularity, by rounding */
static int tells_drift(const Trial *trial, const State *s)
{
    if (HAS_DRIVERS || HAS_ROW_SWITCH) return 0;
    return trial->least_ratio >= CLEAR_PIVOT_RATIO * s->largest_pivot_ratio;
}

/* the error of a step, in units of the tolerance, and the same where the better of two estimates
 * may be blind */
static double local_error(const Method *m, const Trial *trial, const State *s, Work *work,
    double tolerance, double *worse)
{
    const double e = *worse = estimate(m, m->error, trial, s, work, tolerance);
    if (!m->error_2 || e * e == 0.0) return e;
    const double e2 = estimate(m, m->error_2, trial, s, work, tolerance);
    const double best = e * e / sqrt(e * e + WORSE_ESTIMATE_PART * e2 * e2);
    *worse = larger(best, WORSE_ERROR_PART * e2);
    return best;
}

/* the n-th stage of a step: y on the manifold, or near enough to it, and its derivative; 0 where
 * that is impossible */
static int stage(const Method *m, size_t n, double h, double enough, double *y, double *low,
    Work *work, State *s, double *drift)
{
    combine(n, m->a + n * (n - 1) / 2, s->low, h, work->k, y);
    add_to_start(s->y, y, low);
    return project(s->time + m->c[n] * h, enough, y, low, work->k[n], work, s, drift);
}

/* by how much a step of such a length takes Euler parameters from norm one, before they are brought
 * back: where steps are fixed no other error tells that bodies turn too far in one */
static double norm_error(const Method *m, double h, const State *s, Work *work)
{
    double *y = work->scratch, most = 0.0;
    combine(m->stages, m->a + m->stages * (m->stages - 1) / 2, s->low, h, work->k, y);
    add_to_start(s->y, y, NULL);
    for (size_t k = 0; k != ORIENTATIONS; ++k) {
        const double *p = y + orientations[k][0];
        double square = 0.0;
        for (size_t i = 0; i != orientations[k][2]; ++i) square += p[i] * p[i];
        most = larger(most, fabs(sqrt(square) - 1.0));
    }
    return most;
}

/* notes the root of the branch ratio at a part of a step, in order */
static void note_root(double part, double root, Trial *trial)
{
    size_t n = trial->count;
    while (n > 0 && trial->parts[n - 1] >= part) n -= 1;
    if (n == trial->count || trial->parts[n] != part) {
        for (size_t k = trial->count++; k != n; --k) {
            trial->parts[k] = trial->parts[k - 1];
            trial->roots[k] = trial->roots[k - 1];
        }
    }
    trial->parts[n] = part;
    trial->roots[n] = root;
}

/* notes the pivot ratio and the branch ratio of a stage at a part of a step */
static void note_stage_ratios(double part, Trial *trial, const Work *work, const State *s)
{
    trial->last_ratio = last_ratio(work, s);
    trial->least_ratio = smaller(trial->least_ratio, trial->last_ratio);
    trial->most_ratio = larger(trial->most_ratio, trial->last_ratio);
    trial->end_ratio = IS_DRIVEN ? branch_ratio(work, s) : trial->last_ratio;
    if (!HAS_REFINEMENT) return;
    trial->top_ratio = larger(trial->top_ratio, trial->end_ratio);
    if (TRACKS_ROOTS) note_root(part, sqrt(trial->end_ratio), trial);
    if (trial->inner == 0.0 && part >= INNER_STAGE_PART) {
        trial->inner_ratio = trial->end_ratio;
        trial->inner = part;
    }
    if (part < 1.0 && trial->end_ratio < trial->dip_ratio) {
        trial->dip_ratio = trial->end_ratio;
        trial->dip = part;
    }
}

/* the stages from which the end of the step is made; 0 where one is impossible */
static int make_stages(const Method *m, double tolerance, Trial *trial, Work *work, State *s)
{
    int good = 1;
    if (TRACKS_ROOTS) note_root(0.0, sqrt(s->position_ratio), trial);
    if (TRACKS_ROOTS && s->stage_before > 0.0)
        note_root(-s->stage_before / trial->h, s->root_before, trial);
    for (size_t n = 1; good && n <= m->stages; ++n) {
        const int is_inner = n < m->stages;
        good = stage(m, n, trial->h, is_inner ? STAGE_RESIDUAL * tolerance : 0.0, work->y,
            is_inner ? NULL : work->low, work, s, &trial->drift);
        if (good && !is_inner) check_digits(work->k[n], work, s);
        note_stage_ratios(m->c[n], trial, work, s);
    }
    return good;
}

/* the stages that only the interpolating polynomial wants; 0 where one is impossible */
static int make_dense_stages(const Method *m, Trial *trial, Work *work, State *s)
{
    int good = 1;
    for (size_t n = m->stages + 1; good && n < m->all; ++n) {
        good = stage(m, n, trial->h, 0.0, work->scratch, NULL, work, s, NULL);
        trial->least_ratio = good ? smaller(trial->least_ratio, last_ratio(work, s)) : 0.0;
    }
    return good;
}

/* whether stages with zero weight at its end meet a force that the others of a trial miss. The
 * force makes its polynomial useless, and its error does not tell of it: it is too long */
static int is_thrown_off(const Method *m, const Trial *trial, const Work *work)
{
    const double *weights = m->a + m->stages * (m->stages - 1) / 2;
    double most = size_of(work->y + NQ) / trial->h, beside = 0.0;
    for (size_t n = 0; n != m->all; ++n) {
        const double size = size_of(work->k[n] + NQ);
        if (n == m->stages || (n < m->stages && weights[n] != 0.0)) most = larger(most, size);
        else beside = larger(beside, size);
    }
    return beside > THROWN_OFF * most;
}

/* minimum of a parabola through branch ratios of a step, and of those at its stages */
static double least_of_parabola(const Trial *trial, const State *s)
{
    const double first = s->position_ratio, last = trial->end_ratio, x = trial->inner;
    const double quadratic = ((trial->inner_ratio - first) / x - (last - first)) / (x - 1.0);
    const double slope = last - first - quadratic;
    const int is_inside = slope < 0.0 && 0.0 < 2.0 * quadratic + slope;
    const double least = is_inside ? first - slope * slope / (4.0 * quadratic) : last;
    return smaller(least, smaller(trial->dip_ratio, last));
}

/* whether the smallest branch ratio of a step is below a part of the larger one at its ends */
static int falls_to(double part, const Trial *trial, const State *s)
{
    const double ends = larger(s->position_ratio, trial->end_ratio);
    return least_of_parabola(trial, s) < part * smaller(ends, usual_ratio(s));
}

/* part of a step at which branches seem to meet, from roots of branch ratios at its ends. These
 * roots go with the distance from the place where branches meet */
static double meeting_part(double first, double last)
{
    return first + last > 0.0 ? first / (first + last) : 0.5;
}

/* part at which branches seem to meet, before or behind a stage with a small branch ratio */
static double dipping_part(double first, double last, const Trial *trial)
{
    const double dip = sqrt(trial->dip_ratio), x = trial->dip;
    return meeting_part(first, last) > x ? x + (1.0 - x) * dip / (dip + last)
                                         : x * first / (first + dip);
}

/* part of a step at which roots of branch ratios change their sign, and their slope there. These
 * roots go with the distance from a place where branches meet, but are known without a sign: lines
 * through two of them tell the sign of the next. The slope is 0 if none changes its sign */
static double sign_change(const Trial *trial, double *slope)
{
    const double *x = trial->parts, *r = trial->roots;
    double part = 0.0, least = HUGE_VAL;
    *slope = 0.0;
    for (size_t k = 0; k + 1 < trial->count; ++k) {
        const double width = x[k + 1] - x[k], both = r[k] + r[k + 1];
        double ahead = HUGE_VAL, back = HUGE_VAL;
        if (!(x[k + 1] > 0.0) || !(both < least)) continue;
        if (k > 0) ahead = r[k] + width * (r[k] - r[k - 1]) / (x[k] - x[k - 1]);
        if (k + 2 < trial->count)
            back = r[k + 1] - width * (r[k + 2] - r[k + 1]) / (x[k + 2] - x[k + 1]);
        if (!(ahead < SIGN_CHANGE_PART * r[k + 1]) && !(back < SIGN_CHANGE_PART * r[k])) continue;
        part = x[k] + width * meeting_part(r[k], r[k + 1]);
        *slope = both / width;
        least = both;
    }
    return part;
}

/* longest motion of a step whose stages show branches, in lengths and rad, or infinite */
static double longest_way(const Attempts *tried, const Trial *trial, const State *s)
{
    const int is_loose = IS_DRIVEN || tried->settings->tolerance > LOOSE_TOLERANCE;
    if (!HAS_REFINEMENT || !is_loose || tried->is_fixed) return HUGE_VAL;
    const double top = larger(s->position_ratio, trial->top_ratio);
    if (smaller(trial->dip_ratio, trial->end_ratio) > LEVEL_RATIO_PART * top) return HUGE_VAL;
    return IS_DRIVEN && tried->m->stages >= MANY_STAGES ? LONGEST_OF_MANY_STAGES : LONGEST_IF_LOOSE;
}

/* whether bodies move in a step by no more than the longest way: else it is made again. Where
 * bodies are free it is made much shorter: they pass places where branches meet by momentum */
static int is_short(double longest, Trial *trial, const State *s, const Work *work)
{
    const double way = longest < HUGE_VAL ? way_of(trial->h, s->y, work->y) : 0.0;
    if (!(way > longest)) return 1;
    if (IS_DRIVEN) trial->longest = LIMITED_STEP_PART * trial->h * (longest / way);
    return 0;
}

/* whether a step may end on another branch: BRANCH_LOST, ON_BRANCH or BIFURCATION */
static int branch_of(const Attempts *tried, Trial *trial, Work *work, State *s)
{
    if (!HAS_REFINEMENT) return ON_BRANCH;
    const double first = s->position_ratio, last = trial->end_ratio, most = usual_ratio(s);
    if (!is_short(longest_way(tried, trial, s), trial, s, work)) return BRANCH_LOST;
    const int is_dip = trial->dip_ratio < DIPPED_RATIO_PART * smaller(first, last);
    double slope = 0.0, part = TRACKS_ROOTS ? sign_change(trial, &slope) : 0.0;
    const int is_falling = is_dip || slope > 0.0 || falls_to(FALLEN_RATIO_PART, trial, s);
    if (!is_falling && !(smaller(first, last) < SMALL_RATIO_PART * most)) return ON_BRANCH;
    const double far = FAR_WAY_PART * sqrt(larger(first, last) / most);
    if (!is_falling && !(way_of(trial->h, s->y, work->y) > far)) return ON_BRANCH;
    if (!tried->is_fixed && !is_short(LONGEST_NEAR_BRANCHES, trial, s, work)) return BRANCH_LOST;
    const double before = sqrt(first), after = sqrt(last), *f = work->k[tried->m->stages];
    if (!(slope > 0.0)) {
        part = is_dip ? dipping_part(before, after, trial) : meeting_part(before, after);
        slope = before + after;
    }
    return follow_branch(trial->h, work->y, f, part, slope, work, s);
}

/* keeps a step, and says how long the next one is: a proportional and integral controller */
static void accept(const Attempts *tried, const Trial *trial, Work *work, State *s)
{
    const double h = trial->h, error = trial->error, exponent = 1.0 / (double)tried->m->order;
    const double before = larger(s->error, LEAST_EARLIER_ERROR);
    const double most = tried->is_rejected ? 1.0 : MOST_STEP_FACTOR;
    double factor = MOST_STEP_FACTOR;
    if (error != 0.0)
        factor = SAFETY * pow(error, -ERROR_EXPONENT * exponent) *
                 pow(before, EARLIER_ERROR_EXPONENT * exponent);
    double next = h * smaller(most, larger(LEAST_STEP_FACTOR, factor));
    const double way = longest_way(tried, trial, s); /* what is longer is made in vain */
    if (IS_DRIVEN && way < HUGE_VAL)
        next = smaller(next, LIMITED_STEP_PART * way / size_of(work->y + NQ));
    /* over a jump its error tells nothing of what is behind: that is tried before a run stops */
    next = larger(next, ONWARD * SMALLEST * larger(fabs(trial->end), fabs(tried->limit)));
    if (!trial->is_last || next < s->step_size) s->step_size = next;
    s->error = larger(error, LEAST_EARLIER_ERROR);
    s->drift = larger(s->drift, trial->drift);
    note_moved(tried->settings, trial->moved, s);
    s->largest_pivot_ratio = larger(s->largest_pivot_ratio, trial->last_ratio);
    note_pivot_ratio(trial->least_ratio, s->time + 0.5 * h, s);
    s->time_before = s->time;
    s->time = trial->end;
    s->steps += 1;
    note_branch(s->time, trial->branch, s);
    if (TRACKS_ROOTS) {
        s->stage_before = h * (1.0 - trial->parts[trial->count - 2]);
        s->root_before = trial->roots[trial->count - 2];
    }
    s->position_ratio = trial->end_ratio;
    s->usual_ratio = larger(s->usual_ratio, trial->end_ratio);
    note_motion(h, work->y, s);
    note_extent(work->y, work->w, s);
    note_misses(tried->settings, work, s);
    memcpy(s->y_before, s->y, NY * sizeof *s->y);
    memcpy(s->y, work->y, NY * sizeof *s->y);
    memcpy(s->low, work->low, NY * sizeof *s->y);
    memcpy(s->f, work->k[tried->m->stages], NY * sizeof *s->y);
}

/* a trial of the length that is to be tried next, no longer than to where the step ends at most */
static Trial next_trial(Attempts *tried, const State *s)
{
    Trial trial = { .least_ratio = 1.0, .last_ratio = 1.0, .branch = ON_BRANCH };
    trial.dip_ratio = HUGE_VAL;
    trial.h = smaller(s->step_size, tried->settings->largest_step);
    if (tried->is_fixed && tried->avoided == 0) trial.h = tried->settings->fixed_step;
    trial.is_last = !tried->is_beyond && s->time + STRETCH_TO_END * trial.h >= tried->end;
    if (trial.is_last) trial.h = tried->end - s->time;
    trial.end = trial.is_last ? tried->end : s->time + trial.h;
    if (!(trial.h > SMALLEST * larger(fabs(s->time), fabs(tried->end)))) {
        tried->status = STEP_TOO_SMALL;
    }
    return trial;
}

/* whether rows are nearly dependent at a pivot ratio */
static int is_weak(double ratio, const Attempts *tried, const State *s)
{
    return ratio <
           (tried->is_fixed ? VAGUE_PIVOT_RATIO : WEAK_PIVOT_RATIO) * s->largest_pivot_ratio;
}

/* makes the stages of a trial. 0 where Newton has gone far away in a step that cannot be shorter,
 * or where the end is no place to stop at: it is to lie inside of a longer step then */
static int is_made(Attempts *tried, Trial *trial, Work *work, State *s)
{
    forget_trials(work);
    trial->is_good = make_stages(tried->m, tried->settings->tolerance, trial, work, s);
    /* no error tells how far drivers led */
    if (HAS_DRIVERS && !tried->is_fixed && trial->drift > MOST_DRIVEN_CORRECTION)
        trial->is_good = 0;
    if (tried->is_fixed && !trial->is_good) {
        const double there = smaller(trial->least_ratio, ratio_at(work->y, work, s));
        if (!is_weak(there, tried, s)) {
            tried->status = NOT_PROJECTED;
            return 0;
        }
        trial->least_ratio = 0.0;
    }
    if (trial->is_last && is_weak(trial->least_ratio, tried, s)) {
        tried->is_beyond = 1;
        s->avoided += 1;
        return 0;
    }
    return 1;
}

/* whether a trial is beside a fractional power of what is zero: a force has no two derivatives
 * there, and estimates of errors from there on are too small */
static int is_near_power(const Attempts *tried, const Trial *trial, const State *s)
{
    if (!HAS_FRACTIONAL_POWERS) return 0;
    return s->time - s->switched < trial->h || trial->end == tried->search.cut;
}

/* the error of a trial in which samples are few for how a part varies: as if estimates were blind.
 * Beside an infinite force, and where rounding decides, samples are few in every step, however
 * short. So this is done a limited number of times, and not in a step that is a tiny part of the
 * time */
static double error_where_coarse(Attempts *tried, const Trial *trial)
{
    const double tiny = FINEST * larger(fabs(trial->end), fabs(tried->limit));
    if (!(tried->coarse++ < MOST_SHORTER && trial->h > tiny)) return trial->error;
    return larger(trial->error, trial->error_if_blind);
}

/* finds the error of a trial whose stages are all there, and what else its end tells: its geometry
 * is in the workspace */
static void find_error(Attempts *tried, Trial *trial, Work *work, State *s)
{
    const Method *m = tried->m;
    const Settings *settings = tried->settings;
    if (tried->is_fixed) trial->drift = larger(trial->drift, norm_error(m, trial->h, s, work));
    if (WORKS > 0 || settings->checks) {
        energy(work->w);
        trial->moved = energy_moved(work->w, work->y, s);
    }
    if (tried->is_fixed) {
        double worse;
        trial->is_vague = N_FUNCTIONS > 0 &&
                          !(local_error(m, trial, s, work, LEAST_PART, &worse) <= 1.0);
    } else {
        const int is_behind = s->time == s->switched;
        const int is_locked = trial->is_last && is_behind &&
                              (tried->end == s->limit || tried->end == tried->search.cut);
        const int is_close = is_locked || (is_behind && N_FUNCTIONS > 0 && N_BREAKS == 0);
        const double tolerance = is_close ? smaller(settings->tolerance, LOOSEST_AT_SWITCH)
                                          : settings->tolerance;
        const double blind = m->stages >= MANY_STAGES ? BLIND_ERROR_OF_MANY_STAGES : BLIND_ERROR;
        double worse;
        const double best = local_error(m, trial, s, work, tolerance, &worse);
        trial->error = (is_locked ? worse : best) * (is_near_power(tried, trial, s) ? blind : 1.0);
        trial->error_if_blind = blind * worse;
        /* of what varies with the state the polynomial is asked, later */
        if (N_FEATURES > 0 && is_kept(trial) && trial->error_if_blind > 1.0 &&
            sampling_in(settings->tolerance, s->time, trial->end, work->w) == COARSE)
            trial->error = error_where_coarse(tried, trial);
        if (tells_drift(trial, s)) {
            const double most = MOST_DRIFT * larger(settings->tolerance, LEAST_DRIFT);
            trial->error = larger(trial->drift / most, trial->error);
        }
    }
    if (is_kept(trial)) {
        note_largest_pivot(work, s);
        coordinate(work->w);
        check_misses(settings, work);
    }
}

/* whether rows are independent enough at the stages of a trial. Else it is made a little shorter,
 * rounding is large there and other stages lie elsewhere; at last it is the best of those */
static int is_clear(Attempts *tried, Trial *trial, State *s)
{
    if (!(trial->is_good || tried->is_fixed)) return 1;
    if (!is_weak(trial->least_ratio, tried, s)) return 1;
    if (trial->least_ratio > 0.0 && is_weak(trial->most_ratio, tried, s)) {
        /* it is so everywhere: shorter steps stay there */
        s->largest_pivot_ratio = trial->least_ratio /
                                 (tried->is_fixed ? VAGUE_PIVOT_RATIO : WEAK_PIVOT_RATIO);
    } else if (tried->avoided <= MOST_AVOIDED) {
        if (trial->least_ratio > tried->best) {
            tried->best = trial->least_ratio;
            tried->best_h = trial->h;
        }
        s->step_size = tried->avoided++ < MOST_AVOIDED ? AVOIDING_STEP_PART * trial->h
                                                       : tried->best_h;
        s->avoided += 1;
        return 0;
    }
    trial->is_whole = trial->least_ratio > 0.0;
    return 1;
}

/* tries a step, but for what is seen in it; 0 where that tells nothing: it is to be tried again, or
 * there is none. Its error is large where it may not be kept */
static int is_tried(Attempts *tried, Trial *trial, Work *work, State *s)
{
    /* rows that are asked for make stages, too, and no step shorter */
    const int is_searched = N_SWITCHING > 0 && !tried->is_fixed;
    if (!is_made(tried, trial, work, s)) return 0;
    if (trial->is_good) find_error(tried, trial, work, s);
    trial->is_whole = trial->is_good;
    if (trial->is_good && is_kept(trial) && (N_SWITCHING > 0 || tried->asked < trial->end)) {
        trial->is_whole = make_dense_stages(tried->m, trial, work, s) &&
                          !(is_searched && is_thrown_off(tried->m, trial, work));
    }
    if (!is_clear(tried, trial, s)) return 0;
    if (tried->is_fixed && !trial->is_whole) {
        tried->status = NOT_PROJECTED;
        return 0;
    }
    if (trial->is_whole && is_kept(trial)) {
        trial->branch = branch_of(tried, trial, work, s);
        if (trial->branch == BRANCH_LOST && !tried->is_fixed)
            trial->is_whole = !(way_of(trial->h, s->y, work->y) > SHORTEST_BRANCH_WAY);
    }
    if (!trial->is_whole) trial->error = REFUSED_ERROR;
    return 1;
}

/* where a trial must end by what crosses in it. Poles of forces and distances are looked for once
 * more where its polynomial has not all of its stages */
static double crossing_in(Attempts *tried, Trial *trial, Work *work, State *s)
{
    const Method *m = tried->m;
    Search *search = &tried->search;
    const double *f = work->k[m->stages];
    int has_stages = N_SWITCHING > 0 && is_kept(trial);
    /* one that leads beyond its end stays as it is */
#ifdef HAS_DISTANCE
    const int reverses = !tried->is_beyond && may_reverse(s->time, trial->h, work->y, f, s, work);
    if (!reverses && N_FUNCTIONS == 0) return trial->end;
    if (reverses && is_kept(trial) && !has_stages)
        has_stages = make_dense_stages(m, trial, work, s);
#endif
    begin_search(tried->settings, m, has_stages, trial->h, work->y, s->f, f, search, s, work);
    search->least_part = is_kept(trial) && !trial->is_vague ? 0.0 : LEAST_PART;
    search->is_kept = is_kept(trial);
#ifdef HAS_BREAKS
    const int is_leading = leads_over(trial->end, search);
#endif
#ifdef HAS_DISTANCE
    const double reversal = reverses ? reversal_end(trial->end, search, s, work) : HUGE_VAL;
#endif
    const int is_bare = tried->is_beyond || N_FUNCTIONS == 0;
    double seen = is_bare ? trial->end : crossing_end(trial->end, search, s, work);
    if (search->pole && !has_stages && make_dense_stages(m, trial, work, s)) {
        begin_search(tried->settings, m, 1, trial->h, work->y, s->f, f, search, s, work);
        seen = crossing_end(trial->end, search, s, work);
    }
    if (search->pole) return end_before_pole(search, s);
    if (search->undefined) return seen;
    double broken = seen;
#ifdef HAS_BREAKS
    if (!is_bare) broken = break_end(trial->end, seen, is_leading, search, s, work);
#endif
#ifdef HAS_DISTANCE
    if (reversal < broken) return cut_for_place(reversal, seen, search);
#endif
#ifdef HAS_BREAKS
    if (broken < seen) return broken_in(broken, search);
#endif
    return broken;
}

/* time at which a trial must end so that samples up to a time resolve parts of formulas; noted
 * where it cannot be shorter for that. If samples are few, the trial gets the error of blind
 * estimates. In a step that ended beside the middle of a steep rise, with stages on both sides, the
 * estimate was a hundredth of a tolerance and the error 500 */
static double resolved_in(double until, Attempts *tried, Trial *trial, Work *work, State *s)
{
    Search *search = &tried->search;
    double to = trial->end;
    if (N_NARROW == 0 || !is_kept(trial)) return trial->end;
    if (search->is_over && until <= search->place_cut) return trial->end;
    search->is_coarse = 0;
    if (tried->shorter++ < MOST_SHORTER) {
        /* for less the next trial has no digits */
        const double tiny = SMALLEST * larger(fabs(s->time), fabs(tried->end));
        const double there = larger(resolved_end(until, search, s, work), s->time + ONWARD * tiny);
        to = there < until ? there : trial->end;
    } else {
        search->is_unresolved = search->is_unresolved ||
                                (!are_narrow_resolved(s->time, until, search, s, work) &&
                                    !is_at_pole(1, s->time, until, search, s, work));
    }
    if (search->is_coarse && until == trial->end && to == until && !tried->is_fixed)
        trial->error = error_where_coarse(tried, trial);
    return to;
}

/* time at which a trial must end so that its polynomial meets what its stages do. If it has been
 * shortened for that too often, a switch that a stage of the dense output alone meets is noted as
 * unresolved: of those that other stages meet the error tells. At a cut rounding decides */
static double met_in(double until, Attempts *tried, const Trial *trial, Work *work, State *s)
{
    Search *search = &tried->search;
    if (N_SWITCHING == 0 || !is_kept(trial)) return trial->end;
    if (tried->is_beyond || trial->end == search->cut) return trial->end;
    const size_t first = tried->thrown < MOST_SHORTER ? 1 : tried->m->stages + 1;
    const double beyond = stage_beyond(first, until, search, s, work);
    if (!(beyond < until)) return trial->end;
    if (tried->thrown++ < MOST_SHORTER) return beyond;
    search->is_unresolved = 1;
    return trial->end;
}

/* whether a trial that was cut for an event ends there, as its own polynomial tells: else the cut
 * is there */
static int is_at_event(Attempts *tried, const Trial *trial, Work *work, State *s)
{
    Search *search = &tried->search;
    if (EVENTS == 0 || !is_kept(trial) || trial->end != search->cut) return 1;
    if (!(tried->polished++ < MOST_POLISHED)) return 1;
    const double there = smaller(polished_cut(search, s, work), tried->limit);
    if (!(fabs(there - trial->end) > 4.0 * SMALLEST * fabs(trial->end))) return 1;
    tried->end = search->cut = there;
    s->step_size = larger(s->step_size, there - s->time);
    return 0;
}

/* how long a step is that meets the tolerance, where a trial does not, or tells its branch */
static double length_by_error(const Method *m, const Trial *trial)
{
    double factor = LEAST_STEP_FACTOR;
    if (trial->longest > 0.0) return trial->longest;
    if (isfinite(trial->error)) {
        factor = larger(factor, SAFETY * pow(trial->error, -1.0 / (double)m->order));
    }
    return factor * trial->h;
}

/* has a step end at a time when it is tried again: one that could be longer and is cut can so
 * still, however short it gets */
static void end_at(double to, Attempts *tried, const Trial *trial, State *s)
{
    const double way = to - s->time;
    tried->is_guessed = tried->is_guessed || to != tried->search.place_cut;
    if (tried->is_fixed) {
        tried->end = to;
        tried->is_beyond = 0;
    }
    s->rejected += 1;
    const double size = is_kept(trial) ? s->step_size : length_by_error(tried->m, trial);
    s->step_size = to == tried->search.cut ? larger(size, way) : way;
}

/* whether a trial ends where it may by what is seen in it: else it is to end there */
static int ends_well(Attempts *tried, Trial *trial, Work *work, State *s)
{
    Search *search = &tried->search;
    if (N_SEARCHED == 0 || !trial->is_whole || !(is_kept(trial) || !tried->is_guessed)) return 1;
    const double seen = crossing_in(tried, trial, work, s);
    tried->status = why_stopped(seen, search, s);
    if (tried->status != GOOD) return 0;
    const double until = smaller(seen, trial->end); /* what follows a cut is seen later */
    const double narrow = resolved_in(until, tried, trial, work, s);
    double to = smaller(narrow, met_in(until, tried, trial, work, s));
    if (seen <= to && seen < trial->end) to = tried->end = cut_at(seen, search);
    else if (!is_at_event(tried, trial, work, s)) return 0;
    if (!(to < trial->end && (is_kept(trial) || to == search->cut))) return 1;
    end_at(to, tried, trial, s);
    return 0;
}

/* keeps a trial, and notes what was seen in it */
static void keep(const Attempts *tried, const Trial *trial, Work *work, State *s)
{
    const Search *search = &tried->search;
    const double before = s->step_size;
    accept(tried, trial, work, s);
    if (N_SEARCHED == 0) return;
    if (N_FUNCTIONS > 0) note_crossings(trial->end, search, s, work);
    if (search->is_unresolved) note_unresolved(s->time_before, s);
    if (s->time == search->cut) {
        s->step_size = larger(s->step_size, before);
        s->switched = s->time;
    }
}

/* one step with error control, or of the length that was asked for, to the end at most unless rows
 * are nearly dependent there. If the next time to be written lies inside of it, it has the stages
 * that its polynomial wants. GOOD, or why there is none */
static int step(
    const Method *m, const Settings *settings, double asked, double end, State *s, Work *work)
{
    Attempts tried = { .m = m, .settings = settings, .asked = asked, .end = end, .limit = end };
    tried.is_fixed = settings->fixed_step > 0.0;
    tried.best = -1.0;
    tried.search.cut = s->time;
    tried.search.place_cut = HUGE_VAL;
    tried.search.has_error = N_SWITCHING > 0 && !tried.is_fixed;
    memcpy(work->k[0], s->f, NY * sizeof *s->f);
    for (;;) {
        Trial trial = next_trial(&tried, s);
        if (tried.status == GOOD && is_tried(&tried, &trial, work, s) &&
            ends_well(&tried, &trial, work, s)) {
            if (is_kept(&trial)) {
                keep(&tried, &trial, work, s);
                return GOOD;
            }
            tried.is_rejected = 1;
            s->rejected += 1;
            s->step_size = length_by_error(m, &trial);
        }
        if (tried.status != GOOD) return tried.status;
    }
}

/* a first step for which an Euler step changes the derivative little */
static int first_step(const Method *m, const Settings *settings, double end, State *s, Work *work)
{
    double *f = work->k[0], *y = work->k[1];
    forget_trials(work);
    const double span = end - s->time;
    const double speed = size_of(s->y + NQ);
    /* rates of what moves already are known */
    if (speed * span > NOTHING_MOVES) s->stride = smaller(FIRST_STEP_MOTION / speed, span);
    double rate = larger(speed, sqrt(size_of(s->f + NQ)));
    const double h = smaller(
        rate > 0.0 ? FIRST_STEP_MOTION / rate : FIRST_STEP_SPAN_PART * span, span);
    for (size_t i = 0; i < NY; ++i) y[i] = s->y[i] + h * s->f[i];
    if (!project(s->time + h, 0.0, y, NULL, f, work, s, NULL)) return STEP_TOO_SMALL;
    for (size_t i = NQ; i < NY; ++i) f[i] = f[i] - s->f[i];
    /* powers of numbers without a unit: in other units of time bits are the same */
    const double jerk = size_of(f + NQ) / h, unit = larger(rate, 1.0 / span);
    rate = larger(rate, unit * pow(jerk / unit / unit / unit, 1.0 / 3.0));
    double by_order = span;
    if (rate > 0.0)
        by_order = pow(FIRST_STEP_MOTION * settings->tolerance, 1.0 / (double)m->order) / rate;
    s->step_size = smaller(smaller(MOST_FIRST_FACTOR * h, by_order), span);
    return GOOD;
}
