/* The rank of rows with the parameters of a run.
 *
 * Rows that are independent at nominal parameters may become redundant within CLOSURE_TOLERANCE at
 * others, and then constrain motions that should be free. The rank is determined as where a scene
 * is generated: by pivots of C_q without masses, with rotations scaled by the arms of their body,
 * and by how far rows are violated per length and radian that bodies move. */

/* remainder of a scaled row up to which it depends on others but for rounding */
#define HARDLY 1e-11
/* smallest arm of a body, relative to the longest: a body with a smaller one has none */
#define NO_ARM 1e-9
/* distance, in lengths of the scene or radians, up to which a position is still the start */
#define NOT_LEFT 5e-4

/* C_q of the rows, scaled: turns by the arms of their body, rows by their largest element */
static void write_scaled_rows(Work *work)
{
    double *w = work->w, *by = work->rank.columns_by, longest = 0.0;
    Rank *rank = &work->rank;
    memset(w + W_V, 0, NV * sizeof *w);
    for (size_t k = 0; k < NV; ++k) {
        w[W_V + k] = 1.0;
        check(w);
        w[W_V + k] = 0.0;
        by[k] = is_length[k] ? 1.0 : 0.0;
        for (size_t i = 0; i != RANK_ROWS; ++i) rank->rows[i][k] = w[W_C_DOT + rank_rows[i][0]];
    }
    for (size_t t = 0; t != ORIENTATIONS; ++t) {
        const size_t first = orientations[t][1], count = orientations[t][2] == 4 ? 3 : 1;
        double arm = 0.0;
        for (size_t i = 0; i != RANK_ROWS; ++i) {
            if (!row_is_length[rank_rows[i][0]]) continue;
            const double *row = rank->rows[i];
            for (size_t k = first; k != first + count; ++k) arm = larger(arm, fabs(row[k]));
        }
        for (size_t k = first; k != first + count; ++k) by[k] = arm;
        longest = larger(longest, arm);
    }
    for (size_t k = 0; k < NV; ++k) {
        if (is_length[k] || longest == 0.0) by[k] = 1.0;
        else by[k] = 1.0 / (by[k] > NO_ARM * longest ? by[k] : longest);
    }
    for (size_t i = 0; i != RANK_ROWS; ++i) {
        double most = 0.0;
        for (size_t k = 0; k < NV; ++k) {
            rank->rows[i][k] *= by[k];
            most = larger(most, fabs(rank->rows[i][k]));
        }
        rank->rows_by[i] = most;
        for (size_t k = 0; k < NV && most > 0.0; ++k) rank->rows[i][k] /= most;
    }
}

/* rate at which a row misses, per unit of the motion that the rows taken so far allow, in lengths
 * of the scene or radians; the square of the remainder of the row goes to square */
static double rate_of_row(const Rank *rank, size_t i, double *square)
{
    double motion = 0.0;
    *square = 0.0;
    for (size_t k = 0; k < NV; ++k) {
        const double x = rank->rows[i][k];
        const double moved = x * rank->columns_by[k] / (is_length[k] ? LENGTH : 1.0);
        *square += x * x;
        motion += moved * moved;
    }
    motion = sqrt(motion);
    if (!(motion > HARDLY)) return 0.0;
    return *square * rank->rows_by[i] / (row_is_length[rank_rows[i][0]] ? LENGTH : 1.0) / motion;
}

/* how many rows are independent beyond doubt at the geometry in the workspace. They become a basis,
 * and their rates negative; those of the others are what they miss */
static size_t rank_here(Work *work)
{
    Rank *rank = &work->rank;
    const double limit = CLEARLY * CLOSURE_TOLERANCE;
    write_scaled_rows(work);
    memset(rank->rates, 0, sizeof rank->rates);
    for (size_t found = 0;; ++found) {
        size_t best = 0;
        double most = 0.0, rate = 0.0, square = 0.0;
        for (size_t i = 0; i != RANK_ROWS; ++i) {
            if (rank->rates[i] < 0.0) continue;
            rank->rates[i] = rate_of_row(rank, i, &square);
            rate = larger(rate, rank->rates[i]);
            if (square > most) best = i;
            most = larger(most, square);
        }
        const double size = sqrt(most);
        if (!(size > HARDLY && (size > limit || rate > limit))) return found;
        double *basis = rank->rows[best];
        rank->rates[best] = -1.0;
        for (size_t k = 0; k < NV; ++k) basis[k] /= size;
        for (size_t i = 0; i != RANK_ROWS; ++i) {
            double part = 0.0;
            if (rank->rates[i] < 0.0) continue;
            for (size_t k = 0; k < NV; ++k) part += rank->rows[i][k] * basis[k];
            for (size_t k = 0; k < NV; ++k) rank->rows[i][k] -= part * basis[k];
        }
    }
}

/* whether the wanted number of rows is independent beside the start, which is singular then */
static int is_regular_beside(size_t wanted, State *s, Work *work)
{
    Rank *rank = &work->rank;
    double *y = work->k[0], *u = work->k[1];
    for (int back = 0; back < 2; ++back) {
        memcpy(y, s->y, NY * sizeof *y);
        if (!project(s->time, 0.0, y, NULL, NULL, work, s, NULL)) return 0;
        rank_here(work);
        for (size_t k = 0; k < NV; ++k) { /* no special direction */
            const double x = 0.6180339887498949 * (double)(k + 1);
            u[k] = back ? floor(x) + 0.5 - x : x - floor(x) - 0.5;
        }
        for (size_t i = 0; i != RANK_ROWS; ++i) {
            double part = 0.0;
            if (!(rank->rates[i] < 0.0)) continue;
            for (size_t k = 0; k < NV; ++k) part += rank->rows[i][k] * u[k];
            for (size_t k = 0; k < NV; ++k) u[k] -= part * rank->rows[i][k];
        }
        for (size_t k = 0; k < NV; ++k) u[k] *= rank->columns_by[k];
        const double size = size_of(u);
        if (!(size > SMALLEST_DIRECTION)) return 0;
        for (size_t k = 0; k < NV; ++k) u[k] /= size;
        if (!step_along(u, y, work, s)) continue;
        double moved = 0.0;
        for (size_t k = 0; k < NQ; ++k) moved = larger(moved, fabs(y[k] - s->y[k]) / floor_of[k]);
        if (moved > NOT_LEFT && rank_here(work) >= wanted) return 1;
    }
    return 0;
}

/* whether rows that are independent with the parameters of the scene are so in the run. The former
 * rank is that at the start of the scene. If the rank drops, residuals are replaced by the misses
 * of dependent rows, and by 0 for independent ones. The state stays as it is */
static int keep_rank(State *s, Work *work)
{
    enum { SINGLE = offsetof(State, y) / sizeof(double) };
    double counts[SINGLE], *w = work->w, *y = work->k[0];
    size_t wanted = 0;
    memcpy(counts, s, sizeof counts);
    memcpy(y, s->y, NY * sizeof *y);
    if (!project(s->time, 0.0, y, NULL, NULL, work, s, NULL)) return 1;
    const size_t found = rank_here(work);
    for (size_t i = 0; i != RANK_ROWS; ++i) wanted += !rank_rows[i][1];
    if (found < wanted) {
        memcpy(y, s->y, NY * sizeof *y);
        set_parameters(s->parameters, 0.0, w);
        follow_design(y, w);
        if (project(s->time, 0.0, y, NULL, NULL, work, s, NULL)) wanted = rank_here(work);
        set_parameters(s->parameters, 1.0, w);
        setup(w);
    }
    const int is_kept = found >= wanted || is_regular_beside(wanted, s, work);
    if (!is_kept) {
        memcpy(y, s->y, NY * sizeof *y);
        project(s->time, 0.0, y, NULL, NULL, work, s, NULL);
        rank_here(work);
        memset(w + W_C, 0, NCHECK * sizeof *w);
        for (size_t i = 0; i != RANK_ROWS; ++i) {
            const double rate = larger(work->rank.rates[i], HARDLY * HARDLY);
            if (work->rank.rates[i] < 0.0) continue;
            w[W_C + rank_rows[i][0]] = rate * (row_is_length[rank_rows[i][0]] ? LENGTH : 1.0);
        }
    }
    memcpy(s, counts, sizeof counts);
    return is_kept;
}
