/* Trial: a step that is tried, and its stages by an explicit Runge-Kutta method. */

/* largest constraint correction that may be left at a stage inside of a step, in units of the
 * tolerance */
#define STAGE_RESIDUAL 1e-3
/* how often a step is made again at most for each of three reasons: samples do not resolve a part
 * that varies with the state, a stage lies beyond a switch that the polynomial does not meet, or
 * samples are few for how a part varies */
#define MOST_SHORTER 8
/* reject a step if a stage with zero weight at its end has accelerations more than this many times
 * those of the other stages, and the speeds at its end over its length */
#define THROWN_OFF 10.0
/* earliest part of a step at which a stage gives the third point of a parabola through the branch
 * ratios at its ends: branch ratios go with the square of the distance from a place where branches
 * meet */
#define INNER_STAGE_PART 0.25
/* number of stages from which on a method has many: they lie twice as densely in a step */
#define MANY_STAGES 12

/* whether roots of the branch ratio are tracked from stage to stage, to tell where they change
 * sign */
enum { TRACKS_ROOTS = HAS_REFINEMENT && !IS_DRIVEN };

/* a step of length h that is tried */
typedef struct {
    double h, end;                  /* its length, and the time of its end [s] */
    double drift, error;            /* correction of its end; error / tolerance */
    double error_if_blind;          /* error where estimates may be blind */
    double moved;                   /* energy moved to its end, for works or checks [J] */
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

/* the n-th stage of a step: y on the manifold, or near enough to it, and its derivative; 0 where
 * that is impossible */
static int stage(const Method *m, size_t n, double h, double enough, double *y, double *low,
    Work *work, State *s, double *drift)
{
    combine(n, m->a + n * (n - 1) / 2, s->low, h, work->k, y);
    add_to_start(s->y, y, low);
    return project(s->time + m->c[n] * h, enough, y, low, work->k[n], work, s, drift);
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
