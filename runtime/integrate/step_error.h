/* Error of a step, in units of the tolerance, and the step length that it asks for. */

/* a rejected step is cut for a crossing no earlier than at this part of its length: what its
 * polynomial shows before that is not believed. A step of fixed length is treated alike if its
 * relative error is larger than this number */
#define LEAST_PART 0.02
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
/* factor of the estimated error where the two results that an estimate compares are off alike. They
 * are from a place on where a force goes with t^p: the error is 64 times the estimate for p = 0.1,
 * 37 times for a square root and 11 times for p = 1.5. Over steep rises of forces the error of one
 * step in 200 is more than 100 times the estimate without this factor */
#define BLIND_ERROR 40.0
/* the same factor for methods with many stages, where the error is 7, 5 and 3 times the estimate
 * for these p */
#define BLIND_ERROR_OF_MANY_STAGES 5.0
/* safety factor of the step-size control h SAFETY error^(-0.8 / k) error_before^(0.2 / k) with the
 * order k, see docs/dynamics.md. It is the PI controller of Gustafsson, ACM Trans. Math. Softw. 17
 * (1991), with k_P = 0.2 / k and k_I + k_P = 0.8 / k */
#define SAFETY 0.8
/* smallest ratio of a step length to the one before */
#define LEAST_STEP_FACTOR 0.2
/* weight of the estimate e_2 of order 3 beside e of order 5 in the error of DOP853, e^2 / sqrt(e^2
 * + 0.01 e_2^2): it goes with h^8 as the error does. Hairer, Norsett, Wanner, II.10 */
#define WORSE_ESTIMATE_PART 0.01

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
