/* The functions that solver.h declares. */

enum { STATE_SIZE = sizeof(State) / sizeof(double), WORK_SIZE = sizeof(Work) / sizeof(double) };

const char *PUBLIC(digest)(void) { return DIGEST; }
size_t PUBLIC(state_size)(void) { return STATE_SIZE; }
size_t PUBLIC(work_size)(void) { return WORK_SIZE; }
size_t PUBLIC(row_size)(void) { return ROW_SIZE; }

/* whether time, coordinates, velocities and parameters are numbers */
static int are_numbers(double time, const double *q, const double *v, const double *parameters)
{
    return isfinite(time) && are_finite(q, NQ) && are_finite(v, NV) &&
           are_finite(parameters, N_PARAMETERS);
}

int PUBLIC(start)(double time, const double *q, const double *v, const double *parameters,
    double *state, double *workspace)
{
    State *s = (State *)state;
    Work *work = (Work *)workspace;
    memset(s, 0, sizeof *s);
    if (!parameters) parameters = values;
    if (!are_numbers(time, q, v, parameters)) return BAD_ARGUMENT;
    memcpy(s->parameters, parameters, N_PARAMETERS * sizeof *s->parameters);
    prepare(s->parameters, work->w);
    if (HAS_DESIGN && !is_possible(work->w)) return BAD_ARGUMENT;
    s->key = -KEY; /* not started */
    s->time = s->time_before = time;
    s->error = 1e-4;
    if (N_SWITCHES > 0 || N_LAWS > 0) s->limit = s->behind = time;
    for (size_t k = 0; k != EVENTS; ++k) s->crossed[k] = -HUGE_VAL;
    s->least_pivot_ratio_time = time;
    memcpy(s->y, q, NQ * sizeof *q);
    memcpy(s->y + NQ, v, NV * sizeof *v);
    if (HAS_ROW_SWITCH) note_first_pivot_ratio(work, s);
    if (HAS_CONTINUATION && !continue_parameters(s, work)) return NOT_ASSEMBLED;
    if (!project(time, 0.0, s->y, s->low, s->f, work, s, NULL)) return NOT_ASSEMBLED;
    note_lost_digits(work, s);
    note_largest_pivot(work, s);
    s->least_pivot_ratio = pivot_ratio(work, s);
    s->position_ratio = s->usual_ratio = branch_ratio(work, s);
    s->largest_pivot_ratio = larger(s->largest_pivot_ratio, s->least_pivot_ratio);
    energy(work->w);
    s->energy = energy_balance(work->w, work->w + W_Q, s);
    s->potential = work->w[W_ENERGIES + 1];
    s->moved = work->w[W_ENERGIES];
    if (MOMENTA > 0) {
        momentum(work->w);
        memcpy(s->momenta, work->w + W_MOMENTA, MOMENTA * sizeof *s->momenta);
    }
    coordinate(work->w);
    for (size_t k = 0; k != NQ + N_SHOWN; ++k) s->lowest[k] = HUGE_VAL, s->highest[k] = -HUGE_VAL;
    note_extent(s->y, work->w, s);
    if (NCHECK > NC && are_changed(s->parameters) && !stay_closed(s, work)) return NOT_CLOSED;
#if HAS_RANK
    if (are_changed(s->parameters) && !keep_rank(s, work)) return DEPENDENT;
#endif
    s->event = first_without_value(s, work);
    if (s->event > 0.0) return NO_VALUE;
    s->key = KEY;
    return GOOD;
}

/* whether a state is one that a run goes on from: none that was cut, forged or damaged */
static int is_sound(const State *s, size_t n_times)
{
    if (!(s->next_row >= 0.0 && s->next_row <= (double)n_times)) return 0;
    if (s->next_row != floor(s->next_row)) return 0;
    if (!(isfinite(s->time_before) && s->time_before <= s->time && isfinite(s->time))) return 0;
    return isfinite(s->step_size) && are_finite(s->y, NY) && are_finite(s->low, NY) &&
           are_finite(s->f, NY) && are_finite(s->parameters, N_PARAMETERS);
}

/* whether a run may be made so, and goes on with the method that it began with */
static int are_possible(const Settings *settings, const State *s)
{
    const int is_kinematic = IS_DRIVEN && settings->method == METHODS;
    if (!(settings->tolerance >= LEAST_TOLERANCE && settings->tolerance < 1.0)) return 0;
    if (!(settings->largest_step > 0.0)) return 0;
    if (!(settings->fixed_step >= 0.0 && settings->fixed_step <= settings->largest_step)) return 0;
    if (!isfinite(settings->fixed_step)) return 0;
    if (settings->method < 0 || settings->method >= METHODS + IS_DRIVEN) return 0;
    if (is_kinematic && settings->fixed_step > 0.0) return 0;
    return s->method == 0.0 || s->method == 1.0 + settings->method;
}

/* one step towards the time that is asked for */
static int advance(
    const Method *m, const Settings *settings, double asked, double end, State *s, Work *work)
{
    int status = GOOD;
    const int is_fixed = settings->fixed_step > 0.0;
    double target = end;
    s->method = 1.0 + settings->method;
    if (N_SWITCHES > 0 || N_LAWS > 0) {
        status = meet_switches(end, s, work);
        if (status != GOOD || asked <= s->time) return status;
        target = smaller(s->limit, end);
    }
#if IS_DRIVEN
    if (settings->method == METHODS) {
        double h = settings->largest_step;
        if (s->step_size > 0.0) h = smaller(s->step_size, h);
        target = resolved_step(settings->tolerance, h, 0.5, smaller(asked, target), s, work);
        return driven_step(settings, target, s, work);
    }
#endif
    if (s->step_size == 0.0 && !is_fixed) status = first_step(m, settings, end, s, work);
    if (status == GOOD) {
        const double h = is_fixed ? settings->fixed_step
                                  : smaller(s->step_size, settings->largest_step);
        if (!is_fixed) target = even_end(h, target, s);
        target = resolved_step(settings->tolerance, h, 1.0, target, s, work);
    }
    const double start = s->time;
    if (N_NARROW > 0 && s->steps == 0.0) s->steepness = change_by_rounding(end, s, work);
    if (status == GOOD) status = step(m, settings, asked, target, s, work);
    if (status != GOOD) return status;
    if (asked < s->time) {
        prepare_dense(m, work, s);
        if (has_driven_works(m)) add_driven_rows(m, s, work);
    }
    if (N_NARROW > 0) note_steepness(start, end, s, work);
    return GOOD;
}

/* writes the row of an event that is still to be told, behind those of times, which it is not
 * counted with: those that end the run last, and of these the first ends it */
static int report_event(const Method *m, const Settings *settings, State *s, Work *work,
    double *rows, size_t n_rows, size_t max_rows)
{
    size_t told = EVENTS, left = 0;
    for (size_t k = 0; k != EVENTS; ++k) {
        if (s->fired[k] == 0.0) continue;
        if (told == EVENTS || events[told][1] == STOP) told = k;
        ++left;
    }
    if (left == 0) return GOOD;
    if (n_rows == max_rows) return BUFFER_FULL;
    const int status = write_row(m, settings, s->time, s, work, rows + n_rows * ROW_SIZE);
    if (status != GOOD) return status;
    s->event = (double)(1 + told);
    if (left == 1 && events[told][1] == STOP) return STOPPED;
    s->fired[told] = 0.0;
    return EVENT;
}

int PUBLIC(run)(const Settings *settings, const double *times, size_t n_times, size_t max_steps,
    size_t max_rows, double *state, double *workspace, double *rows, size_t *n_rows)
{
    State *s = (State *)state;
    Work *work = (Work *)workspace;
    *n_rows = 0;
    if (!(s->key == KEY) || !is_sound(s, n_times)) return WRONG_STATE;
    if (!are_possible(settings, s)) return BAD_ARGUMENT;
    prepare(s->parameters, work->w);
    const Method *m = methods + settings->method % METHODS;
    const double end = n_times ? times[n_times - 1] : s->time;
    for (size_t steps = 0; (size_t)s->next_row < n_times;) {
        const double t = times[(size_t)s->next_row];
        if (!(s->time_before <= t && t <= end && end < HUGE_VAL)) return BAD_ARGUMENT;
        if (t <= s->time) {
            if (*n_rows == max_rows) return BUFFER_FULL;
            const int status = write_row(m, settings, t, s, work, rows + *n_rows * ROW_SIZE);
            if (status != GOOD) return status;
            *n_rows += 1;
            s->next_row += 1;
        } else {
            const int reported = report_event(m, settings, s, work, rows, *n_rows, max_rows);
            if (reported != GOOD) return reported;
            if (steps == max_steps) return PAUSED;
            const int status = advance(m, settings, t, end, s, work);
            if (status != GOOD) return status;
            steps += 1;
        }
    }
    return GOOD;
}

int PUBLIC(trust)(const Settings *settings, const double *state, Verdict *verdict)
{
    const State *s = (const State *)state;
    if (!(s->key == KEY)) return WRONG_STATE;
    if (!are_possible(settings, s)) return BAD_ARGUMENT;
    judge(settings, s, verdict);
    return verdict->doubts;
}

/* puts a state as it is into the workspace, and finds its accelerations */
static int accelerate_at(
    double time, const double *q, const double *v, const double *parameters, double *w)
{
    if (!parameters) parameters = values;
    if (!are_numbers(time, q, v, parameters)) return BAD_ARGUMENT;
    prepare(parameters, w);
    if (HAS_DESIGN && !is_possible(w)) return BAD_ARGUMENT;
    w[W_T] = time;
    memcpy(w + W_Q, q, NQ * sizeof *w);
    memcpy(w + W_V, v, NV * sizeof *w);
    geometry(w);
    acceleration(w);
    return GOOD;
}

int PUBLIC(accelerations)(double time, const double *q, const double *v, const double *parameters,
    double *workspace, double *v_dot)
{
    const int status = accelerate_at(time, q, v, parameters, workspace);
    if (status == GOOD) memcpy(v_dot, workspace + W_V_DOT, NV * sizeof *v_dot);
    return status;
}

int PUBLIC(evaluate)(
    double time, const double *q, const double *v, const double *parameters, double *workspace)
{
    double *w = workspace;
    const int status = accelerate_at(time, q, v, parameters, w);
    if (status != GOOD) return status;
    position(w);
    move(w);
    velocity(w);
    if (HAS_ROW_SWITCH) ((Work *)workspace)->row_switch.is_active = 0.0;
    find_reactions((Work *)workspace, 0);
    coordinate(w);
    energy(w);
    momentum(w);
    check(w);
    measure(w);
    return GOOD;
}

void PUBLIC(residuals)(const double *workspace, double *residuals)
{
    memcpy(residuals, workspace + W_C, NC * sizeof *residuals);
}

int PUBLIC(pivots)(const double *state, double *workspace, double *pivots)
{
    const State *s = (const State *)state;
    double *w = workspace;
    if (!(fabs(s->key) == KEY)) return WRONG_STATE;
    prepare(s->parameters, w);
    w[W_T] = s->time;
    memcpy(w + W_Q, s->y, NQ * sizeof *w);
    geometry(w);
    for (size_t k = 0; k != NC; ++k) pivots[k] = 1.0 / (w[W_PIVOTS + k] * inverse_pivot_factor(k));
    return GOOD;
}
