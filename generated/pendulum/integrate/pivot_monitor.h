/* The pivot monitor: pivots of C_q M^-1 C_q^T that are small beside others tell that rows of the
 * constraints are nearly dependent. */

/* a pivot ratio this much smaller than the largest so far: rows are nearly dependent */
#define WEAK_PIVOT_RATIO 1e-6
/* one this much smaller: small errors of positions decide about velocities and accelerations */
#define VAGUE_PIVOT_RATIO 1e-8
/* rounding of a position, times the root of the branch ratio: branches that miss each other by less
 * meet in double precision */
#define BRANCH_ROUNDING 1e-14
/* bodies that are so many lengths of the scene from the origin of frame O are far: what rounding
 * leaves of their positions counts */
#define FAR_AWAY 100.0

/* the smallest and the largest inverse of the pivots in the workspace, as masses; 0 if one is not
 * positive, or not finite */
static int inverse_pivots(const double *w, double *least, double *most)
{
    double low[4] = { HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL }, high[4] = { 0.0, 0.0, 0.0, 0.0 };
    double sum[4] = { 0.0, 0.0, 0.0, 0.0 }; /* not finite if one is not; comparisons forget a NaN */
    const double *inverse = w + W_PIVOTS;
    enum { WHOLE = NC / 4 * 4 };
    /* four at a time: a comparison waits for the one before */
    for (size_t k = 0; k != WHOLE; k += 4) {
        for (size_t j = 0; j < 4; ++j) {
            const double x = inverse[k + j] * inverse_pivot_factor(k + j);
            low[j] = smaller(low[j], x);
            high[j] = larger(high[j], x);
            sum[j] += x;
        }
    }
    for (size_t k = WHOLE; k != NC; ++k) {
        const double x = inverse[k] * inverse_pivot_factor(k);
        low[0] = smaller(low[0], x);
        high[0] = larger(high[0], x);
        sum[0] += x;
    }
    *least = smaller(smaller(low[0], low[1]), smaller(low[2], low[3]));
    *most = larger(larger(high[0], high[1]), larger(high[2], high[3]));
    return *least > 0.0 && isfinite(sum[0] + sum[1] + sum[2] + sum[3]);
}

/* the smallest pivot of the factors in the workspace relative to the largest of them and of all
 * steps, 0 if one is not positive: it tends to 0 where rows become dependent */
static double pivot_ratio(const Work *work, const State *s)
{
    double least, most;
    if (HAS_ROW_SWITCH && work->row_switch.is_active != 0.0) return work->row_switch.ratio;
    if (NC == 0) return 1.0;
    if (!inverse_pivots(work->w, &least, &most)) return 0.0;
    return (s->least_inverse_pivot > 0.0 ? smaller(least, s->least_inverse_pivot) : least) / most;
}

/* keeps the largest pivot of all steps: alone it would tell nothing of a single row; where drivers
 * lead the first ones of all rows */
static void note_largest_pivot(const Work *work, State *s)
{
    double least, most;
    const int has_usual = IS_DRIVEN && s->usual_pivots[0] != 0.0;
    if (NC == 0 || !inverse_pivots(work->w, &least, &most)) return;
    s->least_inverse_pivot = s->least_inverse_pivot > 0.0 ? smaller(least, s->least_inverse_pivot)
                                                          : least;
    for (size_t k = 0; IS_DRIVEN && !has_usual && k != NC; ++k) {
        s->usual_pivots[k] = 1.0 / work->w[W_PIVOTS + k];
    }
}

/* what goes with the square of the distance from a place where branches meet: the pivot ratio.
 * Where drivers lead C_q is square, and all pivots together tell the square of its determinant,
 * beside that at the start: a smooth number that is zero there, and tells of it from afar, where
 * the smallest pivot may be another one */
static double branch_ratio(const Work *work, const State *s)
{
    double least, most, product = 1.0;
    const int has_all = HAS_ROW_SWITCH && work->row_switch.is_active != 0.0;
    if (!IS_DRIVEN || NC == 0 || s->usual_pivots[0] == 0.0 || has_all) return pivot_ratio(work, s);
    if (!inverse_pivots(work->w, &least, &most)) return 0.0;
    for (size_t k = 0; k != NC; ++k) product *= work->w[W_PIVOTS + k] * s->usual_pivots[k];
    return 1.0 / product;
}

/* how many times as large rounding of positions is as in a length of the scene, where bodies are
 * far from the origin of frame O, or 1 if none is. Joints bring it into angles and distances */
static double scale_by_distance(const double *y)
{
    double farthest = 0.0;
    for (size_t k = 0; k != SHIFTS; ++k) farthest = larger(fabs(y[shifts[k][0]]), farthest);
    return farthest > FAR_AWAY * LENGTH ? farthest / LENGTH : 1.0;
}

/* what rounding may leave of a position, in lengths and radians */
static double blur_of(const Work *work, const State *s)
{
    const double ratio = larger(pivot_ratio(work, s), branch_ratio(work, s));
    return scale_by_distance(s->y) * BRANCH_ROUNDING / sqrt(larger(ratio, BRANCH_ROUNDING));
}

/* largest branch ratio so far */
static double usual_ratio(const State *s)
{
    return IS_DRIVEN ? s->usual_ratio : s->largest_pivot_ratio;
}

/* keeps the smallest pivot ratio, and when that was */
static void note_pivot_ratio(double ratio, double t, State *s)
{
    if (!(ratio < s->least_pivot_ratio)) return;
    s->least_pivot_ratio = ratio;
    s->least_pivot_ratio_time = t;
}
