/* The stepper: an explicit Runge-Kutta step is tried until it is kept. */

/* how often a step is shortened at most because rows are nearly dependent at one of its stages;
 * then the length with the largest pivot ratio is taken */
#define MOST_AVOIDED 8
/* factor by which such a step is shortened each time, so that its stages lie elsewhere */
#define AVOIDING_STEP_PART 0.9
/* largest constraint correction of a step with drivers, in lengths of the scene or radians: no
 * error tells how far drivers led */
#define MOST_DRIVEN_CORRECTION 1e-3
/* motion of bodies in a step, in lengths of the scene or radians, below which it is not shortened
 * any more to find its branch */
#define SHORTEST_BRANCH_WAY 1e-4
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
/* error, in units of the tolerance, of a trial that cannot be kept and whose error tells nothing:
 * the next one is much shorter */
#define REFUSED_ERROR 1e3
/* motion of bodies in the Euler step that precedes the first step, in lengths of the scene or
 * radians: it tells how derivatives change. Also the factor of the tolerance from which the length
 * of the first step follows. The same book, II.4 */
#define FIRST_STEP_MOTION 0.01
/* length of this Euler step where nothing moves yet, relative to the whole time */
#define FIRST_STEP_SPAN_PART 1e-6
/* largest ratio of the first step to this Euler step */
#define MOST_FIRST_FACTOR 100.0

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
