/* The row switch-over: where the rows that are kept lose rank. Some rows of the constraints depend
 * on others and are left out. Where those that are kept are nearly dependent, the rows that were
 * left out take over: all rows are solved for, as many as are independent, in the order of the
 * largest pivots. A column of C_q is the rate of the rows at a unit velocity less their rate at
 * rest, -nu, which drivers cause. No row of a driver depends on others: its multiplier is the same
 * whichever rows are solved for. */

/* pivot ratio of the rows that are kept, relative to the largest so far, below which rows that were
 * left out may take over */
#define FALL_BACK 1e-2
/* smallest factor by which all rows must have the larger pivot ratio to take over: else the choice
 * of rows is not to blame */
#define HELPS 10.0
/* value in place of the largest pivot ratio so far that asks for all rows to be solved for,
 * whatever the pivots of those that are kept */
#define ALL_OF_THEM (-1.0)

/* an element of the diagonal of M^-1 */
static double inverse_mass(const double *w, size_t k)
{
    if (!HAS_VARYING_MASSES || mass_places[k] < 0) return inverse_masses[k];
    return w[W_DESIGN + mass_places[k]];
}

/* C_q of all rows, row by row; v stays what it is */
static void write_jacobian(Work *work)
{
    double *w = work->w;
    RowSwitch *all = &work->row_switch;
    memcpy(all->v, w + W_V, NV * sizeof *w);
    memset(w + W_V, 0, NV * sizeof *w);
    if (HAS_DRIVERS) {
        check(w);
        memcpy(all->rates, w + W_C_DOT, NCHECK * sizeof *w);
    }
    for (size_t k = 0; k < NV; ++k) {
        w[W_V + k] = 1.0;
        check(w);
        w[W_V + k] = 0.0;
        for (size_t i = 0; i != ALL_ROWS; ++i) {
            all->rows[i][k] = HAS_DRIVERS ? w[W_C_DOT + i] - all->rates[i] : w[W_C_DOT + i];
        }
    }
    memcpy(w + W_V, all->v, NV * sizeof *w);
}

static void exchange(double *a, double *b)
{
    const double kept = *a;
    *a = *b;
    *b = kept;
}

/* the order in which rows are looked at: those of drivers first, whose multipliers are wanted
 * whatever happens */
static void set_order(double *order)
{
    size_t n = 0;
    for (size_t k = 0; k != DRIVERS; ++k) order[n++] = (double)drivers[k][0];
    for (size_t i = 0; i != ALL_ROWS; ++i) {
        int is_driver = 0;
        for (size_t k = 0; k != DRIVERS; ++k) is_driver |= drivers[k][0] == i;
        if (!is_driver) order[n++] = (double)i;
    }
}

/* C_q M^-1 C_q^T of all rows in their order: few columns belong to a row */
static void multiply_rows(Work *work)
{
    RowSwitch *all = &work->row_switch;
    memset(all->matrix, 0, sizeof all->matrix);
    for (size_t i = 0; i != ALL_ROWS; ++i) {
        for (size_t k = 0; k < NV; ++k) {
            const double x = all->rows[(size_t)all->order[i]][k] * inverse_mass(work->w, k);
            if (x == 0.0) continue;
            for (size_t j = 0; j != ALL_ROWS; ++j) {
                all->matrix[i][j] += x * all->rows[(size_t)all->order[j]][k];
            }
        }
    }
}

/* a pivot of all rows, as the inverse of a mass [1/kg] */
static double comparable_pivot(const RowSwitch *all, size_t r)
{
    return all->matrix[r][r] / inverse_pivot_factor((size_t)all->order[r]);
}

/* C_q M^-1 C_q^T of all rows becomes L D L^T of NC rows, those of drivers and those with the
 * largest pivots. Returns the smallest pivot relative to the largest one of these rows and of all
 * steps, 0 if one is not positive; known is the inverse of the largest pivot of all steps, 0 if
 * there is none */
static double factorise_rows(Work *work, double known)
{
    RowSwitch *all = &work->row_switch;
    double least = HUGE_VAL;
    double most = known > 0.0 ? 1.0 / known : 0.0;
    set_order(all->order);
    multiply_rows(work);
    for (size_t r = 0; r != NC; ++r) {
        size_t best = r;
        for (size_t i = r + 1; i != ALL_ROWS && (int)r >= DRIVERS; ++i) {
            if (comparable_pivot(all, i) > comparable_pivot(all, best)) best = i;
        }
        exchange(&all->order[r], &all->order[best]);
        for (size_t k = 0; k != ALL_ROWS; ++k) exchange(&all->matrix[r][k], &all->matrix[best][k]);
        for (size_t k = 0; k != ALL_ROWS; ++k) exchange(&all->matrix[k][r], &all->matrix[k][best]);
        const double *row = all->matrix[r];
        if (!(row[r] > 0.0)) return 0.0;
        least = smaller(least, comparable_pivot(all, r));
        most = larger(most, comparable_pivot(all, r));
        for (size_t i = r + 1; i != ALL_ROWS; ++i) {
            double *other = all->matrix[i];
            if (other[r] == 0.0) continue;
            other[r] /= row[r];
            for (size_t j = r + 1; j != ALL_ROWS; ++j) other[j] -= other[r] * row[j];
        }
    }
    return least / most;
}

/* x = L^-T x with the factors of all rows */
static void substitute_back(const RowSwitch *all, double *x)
{
    for (size_t r = NC; r-- > 0;) {
        for (size_t i = 0; i < r; ++i) x[i] -= all->matrix[r][i] * x[r];
    }
}

/* u = -M^-1 C_q^T lambda, where C_q M^-1 C_q^T lambda is what the rows have */
static void solve_rows(const double *right, Work *work, double *u)
{
    RowSwitch *all = &work->row_switch;
    double *x = all->solution;
    for (size_t i = 0; i != NC; ++i) x[i] = right[(size_t)all->order[i]];
    for (size_t r = 0; r != NC; ++r) {
        for (size_t i = r + 1; i != NC; ++i) x[i] -= all->matrix[i][r] * x[r];
    }
    for (size_t r = 0; r != NC; ++r) x[r] /= all->matrix[r][r];
    substitute_back(all, x);
    for (size_t k = 0; k < NV; ++k) u[k] = 0.0;
    for (size_t r = 0; r != NC; ++r) {
        const double *row = all->rows[(size_t)all->order[r]];
        for (size_t k = 0; k < NV; ++k) u[k] += row[k] * x[r];
    }
    for (size_t k = 0; k < NV; ++k) u[k] *= -inverse_mass(work->w, k);
}

/* the power of drivers with the multipliers of all rows */
static void drive(Work *work)
{
    double *q_dot = work->w + W_Q_DOT;
    for (size_t k = 0; k != DRIVERS; ++k) q_dot[drivers[k][1]] = 0.0;
    for (size_t k = 0; k != DRIVERS; ++k) {
        q_dot[drivers[k][1]] += work->row_switch.rates[drivers[k][0]] *
                                work->row_switch.lam[drivers[k][0]];
    }
}

/* lam becomes the multipliers of all rows that move no body, the n-th that was not solved for
 * being 1 */
static void null_multipliers(size_t n, Work *work, double *lam)
{
    RowSwitch *all = &work->row_switch;
    double *x = all->solution;
    memcpy(x, all->matrix[NC + n], NC * sizeof *x);
    substitute_back(all, x);
    memset(lam, 0, NCHECK * sizeof *lam);
    for (size_t r = 0; r != NC; ++r) lam[(size_t)all->order[r]] = -x[r];
    lam[(size_t)all->order[NC + n]] = 1.0;
}

static double inner_product(const double *a, const double *b)
{
    double sum = 0.0;
    for (size_t k = 0; k != N_WRENCHES; ++k) sum += a[k] * b[k];
    return sum;
}

/* solves square x = right by elimination; both are used up, and x is in right */
static void eliminate(double square[][ROOM(FREE_ROWS)], double *right)
{
    for (size_t r = 0; r != FREE_ROWS; ++r) {
        for (size_t i = r + 1; i != FREE_ROWS; ++i) {
            const double factor = square[i][r] / square[r][r];
            for (size_t j = r + 1; j != FREE_ROWS; ++j) square[i][j] -= factor * square[r][j];
            right[i] -= factor * right[r];
        }
    }
    for (size_t r = FREE_ROWS; r-- > 0;) {
        right[r] /= square[r][r];
        for (size_t i = 0; i < r; ++i) right[i] -= square[i][r] * right[r];
    }
}

/* the forces of joints: of all multipliers that move the bodies as those that were found do, those
 * with the least forces and torques, as where the rows that are kept are independent */
static void least_norm_reactions(Work *work)
{
    RowSwitch *all = &work->row_switch;
    double *w = work->w, *lam = w + W_ALL_LAM;
    for (size_t n = 0; n != FREE_ROWS; ++n) {
        null_multipliers(n, work, lam);
        memcpy(all->ways[n], lam, NCHECK * sizeof *lam);
        wrench(w);
        memcpy(all->wrenches[n], w + W_WRENCHES, N_WRENCHES * sizeof *lam);
    }
    memcpy(lam, all->lam, NCHECK * sizeof *lam);
    wrench(w);
    for (size_t n = 0; n != FREE_ROWS; ++n) {
        const double *own = all->wrenches[n];
        for (size_t m = 0; m != FREE_ROWS; ++m) {
            all->square[n][m] = inner_product(own, all->wrenches[m]);
        }
        all->mu[n] = -inner_product(own, w + W_WRENCHES);
    }
    eliminate(all->square, all->mu);
    for (size_t n = 0; n != FREE_ROWS; ++n) {
        for (size_t i = 0; i != ALL_ROWS; ++i) lam[i] += all->mu[n] * all->ways[n][i];
    }
    wrench(w);
}

/* takes the multipliers of the rows that are kept for those of all rows, and finds the factors that
 * tell which others there are; without these no force is known */
static void take_multipliers(Work *work)
{
    RowSwitch *all = &work->row_switch;
    memset(all->lam, 0, NCHECK * sizeof(double));
    memcpy(all->lam, work->w + W_LAM, NC * sizeof(double));
    write_jacobian(work);
    if (factorise_rows(work, 0.0) > 0.0) return;
    for (size_t k = 0; k != NC; ++k) all->lam[k] = (double)NAN;
}

/* brings v_dot, and the multipliers of all rows, nearer to C_q v_dot = gamma */
static void refine_all_rows(Work *work)
{
    RowSwitch *all = &work->row_switch;
    double *w = work->w;
    check(w);
    solve_rows(w + W_C_DDOT, work, all->v);
    for (size_t k = 0; k < NV; ++k) w[W_V_DOT + k] += all->v[k];
    for (size_t r = 0; r != NC; ++r) all->lam[(size_t)all->order[r]] += all->solution[r];
}

/* without the inverse pivots no row has a force: then all rows get theirs; others may read a number
 * that is equal to a pivot */
static void accelerate_all_rows(Work *work)
{
    double *pivots = work->w + W_PIVOTS, *kept = work->row_switch.solution;
    memcpy(kept, pivots, NC * sizeof(double));
    memset(pivots, 0, NC * sizeof(double));
    memset(work->row_switch.lam, 0, NCHECK * sizeof(double));
    acceleration(work->w);
    memcpy(pivots, kept, NC * sizeof(double));
    refine_all_rows(work);
}

/* forgets where all rows were tried in vain: what follows does not depend on what was asked
 * before */
static void forget_trials(Work *work)
{
    if (HAS_ROW_SWITCH) work->row_switch.tried = 0.0;
}

/* whether all rows are better than those kept. Where they are not, as where drivers or bars stand
 * in line, they are tried again only when the pivot ratio of the rows kept has changed by the
 * factor HELPS */
static int are_all_rows_better(double ratio, Work *work, const State *s)
{
    RowSwitch *all = &work->row_switch;
    if (ratio < HELPS * all->tried && all->tried < HELPS * ratio) return 0;
    write_jacobian(work);
    all->ratio = factorise_rows(work, s->least_inverse_pivot);
    const int found = all->ratio > HELPS * ratio;
    all->tried = found ? 0.0 : ratio;
    return found;
}

/* checks what rows that are left out miss at the position in the workspace */
static void check_misses(const Settings *settings, Work *work)
{
    if (MISSED_ROWS == 0 || !settings->checks) return;
    check(work->w);
    for (size_t k = 0; k != MISSED_ROWS; ++k) work->missed[k] = fabs(work->w[W_C + NC + k]);
}

/* notes the misses of rows that are left out, at a position that is kept */
static void note_misses(const Settings *settings, const Work *work, State *s)
{
    if (!settings->checks) return;
    double *worst = s->violations[0] + NC;
    for (size_t k = 0; k != MISSED_ROWS; ++k) worst[k] = larger(work->missed[k], worst[k]);
}

/* the geometry of q, and the factors of all rows where those that are kept are nearly dependent */
static void find_geometry(Work *work, State *s)
{
    geometry(work->w);
    if (!HAS_ROW_SWITCH) return;
    work->row_switch.is_active = 0.0;
    if (!(s->largest_pivot_ratio > ALL_OF_THEM)) {
        write_jacobian(work);
        work->row_switch.ratio = factorise_rows(work, 0.0);
        work->row_switch.is_active = work->row_switch.ratio > 0.0;
        return;
    }
    const double ratio = pivot_ratio(work, s);
    if (!(ratio < FALL_BACK * s->largest_pivot_ratio && are_all_rows_better(ratio, work, s)))
        return;
    work->row_switch.is_active = 1.0;
    s->fallbacks += 1;
    s->fallback_time = work->w[W_T];
}

/* keeps the usual pivot ratio where a run begins: if rows that are kept are nearly dependent there,
 * it is that of all rows */
static void note_first_pivot_ratio(Work *work, State *s)
{
    place(s->time, s->y, work->w);
    memset(work->w + W_DQ, 0, NV * sizeof(double));
    displace(work->w, NULL);
    geometry(work->w);
    work->row_switch.is_active = 0.0;
    forget_trials(work);
    const double ratio = pivot_ratio(work, s);
    write_jacobian(work);
    const double all = factorise_rows(work, s->least_inverse_pivot);
    s->largest_pivot_ratio = ratio < FALL_BACK * all ? all : ratio;
}
