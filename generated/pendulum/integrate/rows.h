/* The rows that are written, at steps and between them, and what the ledger of a run notes of
 * them. */

/* whether misses of rows are at most so many times CLOSURE_TOLERANCE, relative to LENGTH. Rows that
 * are left out miss by some of it; where these took over, so do the rows that were kept */
static int are_closed(const double *misses, double times)
{
    for (size_t k = 0; k != NCHECK; ++k) {
        const double most = times * CLOSURE_TOLERANCE * (row_is_length[k] ? LENGTH : 1.0);
        if (!(fabs(misses[k]) <= most)) return 0;
    }
    return 1;
}

/* notes residuals of the constraints, and changes of energy and of momenta */
static void note_checks(double *w, State *s)
{
    /* residuals of all rows: those of rows that are left out stand behind C; NaNs are ignored */
    const double *left[3] = { w + W_C, w + W_C_DOT, w + W_C_DDOT };
    check(w);
    for (size_t level = 0; level < 3; ++level) {
        double *worst = s->violations[level];
        for (size_t k = 0; k != NCHECK; ++k) worst[k] = larger(fabs(left[level][k]), worst[k]);
    }
    s->energy_error = larger(s->energy_error, fabs(energy_balance(w, w + W_Q, s)));
    s->energy_moved = larger(s->energy_moved, energy_moved(w, w + W_Q, s));
    if (MOMENTA > 0) momentum(w);
    for (size_t k = 0; k != MOMENTA; ++k) {
        const double change = fabs(w[W_MOMENTA + k] - s->momenta[k]);
        s->momentum_errors[k] = larger(change, s->momentum_errors[k]);
    }
}

/* puts the interpolated state at a time into the workspace; whether rows are dependent. Dependent
 * rows determine neither a projection nor the accelerations */
static int interpolate_position(
    const Method *m, double t, double x, double *y, Work *work, State *s)
{
    double *w = work->w;
    interpolate(m, x, s, y);
    w[W_T] = t;
    memcpy(w + W_V, y + NQ, NV * sizeof *w);
    const double ratio = ratio_at(y, work, s);
    memcpy(y, w + W_Q, NQ * sizeof *w);
    return ratio < WEAK_PIVOT_RATIO * s->largest_pivot_ratio;
}

/* takes the accelerations of a row from the polynomial; the forces of joints are unknown */
static void interpolate_accelerations(
    const Method *m, double t, double x, double h, Work *work, State *s)
{
    double *w = work->w, *rate = work->k[2];
    differentiate(m, x, h, s, work->k[1], rate);
    memcpy(w + W_V_DOT, rate + NQ, NV * sizeof *w);
    for (size_t k = 0; HAS_REACTIONS && k != NC; ++k) w[W_LAM + k] = (double)NAN;
    s->passed += 1;
    s->passed_time = t;
}

/* notes that a row has numbers that are not finite, and when the first such row is */
static void note_not_finite(const double *row, size_t n, State *s)
{
    if (are_finite(row, n)) return;
    if (s->not_finite == 0.0) s->not_finite_time = row[0];
    s->not_finite += 1;
}

/* finds the forces and torques of joints, those of least norm where rows are dependent; scenes with
 * many dependent rows share them out here, others in their own code */
static void find_reactions(Work *work, int is_passed)
{
    const int has_all = HAS_REACTIONS && HAS_ROW_SWITCH && work->row_switch.is_active != 0.0;
    if (SHARES_OUT && is_passed) {
        for (size_t k = 0; k != NCHECK; ++k) work->w[W_ALL_LAM + k] = (double)NAN;
        wrench(work->w);
        return;
    }
    if (SHARES_OUT && !has_all) take_multipliers(work);
    if ((SHARES_OUT || has_all) && !is_passed) least_norm_reactions(work);
    else reaction(work->w);
}

/* writes the state at a time of the last step, projected onto the constraints */
static int write_row(
    const Method *m, const Settings *settings, double t, State *s, Work *work, double *row)
{
    double *w = work->w, *y = work->k[0];
    const double h = s->time - s->time_before, x = (t - s->time_before) / h;
    const int is_driven = settings->method == METHODS;
    int is_passed = 0;
    forget_trials(work);
    if (t == s->time || h == 0.0) {
        memcpy(y, s->y, NY * sizeof *y);
        place(t, y, w);
        if (ACCELERATES || settings->checks) find_geometry(work, s);
    } else {
        interpolate(m, x, s, y);
        if (has_driven_works(m) && !is_driven) add_driven_works(x, s, y);
        const double vague = (is_driven ? WEAK_PIVOT_RATIO : VAGUE_PIVOT_RATIO) *
                             s->largest_pivot_ratio;
        double drift = 0.0;
        const int can = project(t, 0.0, y, NULL, NULL, work, s, &drift);
        is_passed = !can || pivot_ratio(work, s) < vague;
        if (is_passed && !interpolate_position(m, t, x, y, work, s) && !can) return NOT_PROJECTED;
        if (is_passed) interpolate_accelerations(m, t, x, h, work, s);
        else s->row_drift = larger(s->row_drift, drift);
    }
    if ((ACCELERATES || settings->checks) && !is_passed) accelerate(work, s);
    if (HAS_ENERGIES || settings->checks) energy(w);
    if (settings->checks) note_checks(w, s);
    const int watches = settings->checks && NCHECK > NC;
    if (watches && !is_passed && !are_closed(w + W_C, CLEARLY)) return NOT_CLOSED;
    find_reactions(work, is_passed);
    coordinate(w);
    double *next = row;
    *next++ = t;
    memcpy(next, y, NY * sizeof *next);
    next += NY;
    for (size_t k = 0; k != PARTS; ++k) {
        memcpy(next, w + parts[k][0], parts[k][1] * sizeof *next);
        next += parts[k][1];
    }
    if (!is_passed) note_not_finite(row, (size_t)(next - row), s);
    return GOOD;
}
