/* Dense output: the polynomial that tells the state at times inside of a step. */

/* y = low + h sum of row[m] k[m], without low if it is NULL */
static void combine(
    size_t n, const double *row, const double *low, double h, double k[][ROOM(NY)], double *y)
{
    for (size_t i = 0; i < NY; ++i) y[i] = low ? low[i] : 0.0;
    for (size_t m = 0; m < n; ++m) {
        const double factor = h * row[m];
        if (factor == 0.0) continue;
        for (size_t i = 0; i < NY; ++i) y[i] += factor * k[m][i];
    }
}

/* the cubic polynomial that leads from the state before to y in a step of length h, and meets the
 * derivatives f_before and f at its ends */
static void hermite_cubic(
    double h, const double *y, const double *f_before, const double *f, State *s)
{
    for (size_t i = 0; i < NY; ++i) {
        const double step = y[i] - s->y_before[i];
        s->dense[0][i] = step;
        s->dense[1][i] = h * f_before[i] - step;
        s->dense[2][i] = 2.0 * step - h * (f_before[i] + f[i]);
    }
}

/* what the stages of a step add to that */
static void add_dense_rows(const Method *m, double h, State *s, Work *work)
{
    for (size_t n = 0; n < m->dense_rows; ++n) {
        combine(m->all, m->dense + n * m->all, NULL, h, work->k, s->dense[3 + n]);
    }
}

/* whether works at times inside of a step are summed from powers at its stages */
static int has_driven_works(const Method *m) { return IS_DRIVEN && WORKS > 0 && m->work_rows > 0; }

static void add_driven_rows(const Method *m, State *s, Work *work)
{
    const double h = s->time - s->time_before;
    for (size_t n = 0; n < m->work_rows; ++n) {
        for (size_t i = NQ - WORKS; i != NQ; ++i) s->dense[3 + n][i] = 0.0;
        for (size_t k = 0; k < m->all; ++k) {
            const double factor = h * m->works[n * m->all + k];
            for (size_t i = NQ - WORKS; i != NQ; ++i) s->dense[3 + n][i] += factor * work->k[k][i];
        }
    }
}

/* what the last two of these rows add at the part x of the step */
static void add_driven_works(double x, const State *s, double *y)
{
    const double rest = 1.0 - x, factor = x * (x * rest) * (x * rest);
    for (size_t i = NQ - WORKS; i != NQ; ++i) {
        y[i] += factor * (s->dense[4][i] + rest * s->dense[5][i]);
    }
}

/* the interpolating polynomial of the step that was made, all stages of which are there */
static void prepare_dense(const Method *m, Work *work, State *s)
{
    const double h = s->time - s->time_before;
    hermite_cubic(h, s->y, work->k[0], work->k[m->stages], s);
    add_dense_rows(m, h, s, work);
}

/* y at the part x of the step */
static void interpolate(const Method *m, double x, const State *s, double *y)
{
    for (size_t i = 0; i < NY; ++i) y[i] = 0.0;
    for (size_t n = 3 + m->dense_rows; n-- > 0;) {
        const double factor = n % 2 == 0 ? x : 1.0 - x;
        for (size_t i = 0; i < NY; ++i) y[i] = (y[i] + s->dense[n][i]) * factor;
    }
    for (size_t i = 0; i < NY; ++i) y[i] += s->y_before[i];
}

/* the derivative of the interpolating polynomial of a step of length h; y is used up */
static void differentiate(
    const Method *m, double x, double h, const State *s, double *y, double *rate)
{
    for (size_t i = 0; i < NY; ++i) y[i] = rate[i] = 0.0;
    for (size_t n = 3 + m->dense_rows; n-- > 0;) {
        const double factor = n % 2 == 0 ? x : 1.0 - x, sign = n % 2 == 0 ? 1.0 : -1.0;
        for (size_t i = 0; i < NY; ++i) {
            y[i] += s->dense[n][i];
            rate[i] = rate[i] * factor + sign * y[i];
            y[i] *= factor;
        }
    }
    for (size_t i = 0; i < NY; ++i) rate[i] /= h;
}
