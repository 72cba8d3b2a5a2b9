/* Branches: whether a step stays on its branch of the motion where another one meets it, or comes
 * near. */

/* largest correction of places of a smooth way onto the rows, in lengths of the scene or radians */
#define OFF_WAY 1e-9
/* largest gap between branches that is rounding: the correction times the distance from the place
 * where branches meet at which it is found */
#define NO_GAP 1e-14
/* first distance from the place where branches meet at which a gap is looked for, relative to the
 * step */
#define FIRST_DISTANCE 0.03
/* factor of this distance from each approach to the next */
#define DISTANCE_FACTOR 0.1
/* distance at which no gap is looked for any more where drivers determine the motion, in lengths of
 * the scene or radians */
#define NEAREST_DISTANCE 1e-5
/* largest number of approaches; a step that is undecided then may end on another branch */
#define MOST_APPROACHES 12
/* largest correction onto the rows, relative to the distance from the singularity, where the
 * singularity lies outside the step */
#define FAR_ERROR_PART 1e-2
/* largest ratio of the roots of branch ratios at the ends of a driven step, where the singularity
 * lies outside the step: drivers that turn back hide one inside */
#define LARGEST_ROOT_RATIO 2.0

/* verdicts on a step: it may end on another branch, it stays on its own, or goes straight on where
 * another one meets it, or comes nearer than rounding tells */
enum { BRANCH_LOST, ON_BRANCH, BIFURCATION };

/* Newton's polynomial through n coordinates at parts x of a step: q at a part of it */
static void evaluate_path(size_t n, const double *x, double c[][ROOM(NQ)], double part, double *q)
{
    memcpy(q, c[n - 1], NQ * sizeof *q);
    for (size_t k = n - 1; k-- > 0;) {
        for (size_t i = 0; i < NQ; ++i) q[i] = q[i] * (part - x[k]) + c[k][i];
    }
}

/* the cubic polynomial through both ends of a step of length h, from f_before to f */
static void begin_path(double h, const double *y_before, const double *f_before, const double *y,
    const double *f, double *x, double c[][ROOM(NQ)])
{
    x[0] = x[1] = 0.0;
    x[2] = x[3] = 1.0;
    for (size_t i = 0; i < NQ; ++i) {
        const double step = y[i] - y_before[i], first = h * f_before[i];
        c[0][i] = y_before[i];
        c[1][i] = first;
        c[2][i] = step - first;
        c[3][i] = h * f[i] - step - c[2][i];
    }
}

/* brings a place of the way at a part of a step onto the constraints, if it is off: the way leads
 * through it then; how far off it was, negative where it cannot be brought */
static double correct_path(size_t *count, double *x, double c[][ROOM(NQ)], double t, double part,
    double *ratio, Work *work, State *s)
{
    double *w = work->w, *q = work->scratch, product = 1.0;
    const size_t n = *count;
    evaluate_path(n, x, c, part, q);
    w[W_T] = t;
    ratio_at(q, work, s);
    *ratio = branch_ratio(work, s);
    correct_position(work);
    s->factorisations += 1;
    s->corrections += 1;
    const double off = size_of(w + W_DQ);
    if (off <= OFF_WAY) return off;
    displace(w, NULL);
    if (n == WAY || !(project_position(OFF_WAY * OFF_WAY, work, NULL, s) >= 0.0)) return -1.0;
    *ratio = branch_ratio(work, s);
    for (size_t k = 0; k < n; ++k) product *= part - x[k];
    for (size_t i = 0; i < NQ; ++i) c[n][i] = (w[W_Q + i] - q[i]) / product;
    x[n] = part;
    *count += 1;
    return off;
}

/* verdict on a step of length h to y and f. Branches meet, or nearly, at about this part of it; the
 * slope is that of roots of branch ratios there, which go with the distance from a place where
 * branches meet. Where they do meet, the way leads straight on: it is smooth and satisfies the
 * rows, as near to the place as one looks. Where they miss each other by little, a smooth way from
 * one to the other violates the rows, the more the nearer to the place: the branch itself bends
 * sharply there, and ends elsewhere */
static int follow_branch(
    double h, const double *y, const double *f, double part, double slope, Work *work, State *s)
{
    double x[WAY], beside = FIRST_DISTANCE, roots[2], off[2], farthest = 0.0, nearest = HUGE_VAL;
    const double way = way_of(h, s->y, y);
    const double before = sqrt(fabs(s->position_ratio)), after = slope - before;
    const int is_even = !IS_DRIVEN ||
                        larger(before, after) <= LARGEST_ROOT_RATIO * smaller(before, after);
    size_t n = 4;
    forget_trials(work);
    begin_path(h, s->y, s->f, y, f, x, work->way);
    for (size_t approach = 0; approach != MOST_APPROACHES; ++approach) {
        for (size_t side = 0; side < 2; ++side) {
            const double there = part + (side ? beside : -beside), t = s->time + there * h;
            off[side] = correct_path(&n, x, work->way, t, there, &roots[side], work, s);
            if (!(off[side] >= 0.0)) return BRANCH_LOST;
            /* rows that were left out took over, and hold it */
            if (HAS_ROW_SWITCH && work->row_switch.is_active != 0.0 &&
                roots[side] > FALL_BACK * s->largest_pivot_ratio)
                return ON_BRANCH;
            roots[side] = sqrt(roots[side]);
            farthest = larger(farthest, off[side]);
            nearest = smaller(nearest, roots[side]);
        }
        const double sum = roots[0] + roots[1], change = roots[1] - roots[0];
        const double usual = 2.0 * beside * slope;
        const int is_between = sum > 0.0 && fabs(sum - usual) <= fabs(fabs(change) - usual);
        part -= is_between ? beside * change / sum : beside * sum / change;
        const int is_inside = part > 0.0 && part < 1.0;
        if (!is_between && is_inside) continue; /* the place is farther away */
        const int is_on = larger(off[0], off[1]) <= larger(OFF_WAY, NO_GAP / (beside * way));
        if (is_on && !is_between)
            return is_even && farthest <= FAR_ERROR_PART * nearest ? ON_BRANCH : BRANCH_LOST;
        /* momentum leads free bodies across gaps that numbers of a scene are rounded to */
        if (is_on && (!IS_DRIVEN || beside * way <= NEAREST_DISTANCE)) return BIFURCATION;
        if (is_between) slope = sum / (2.0 * beside);
        if (!is_inside) part = part > 0.5 ? 1.0 : 0.0;
        beside *= DISTANCE_FACTOR;
    }
    return BRANCH_LOST;
}

/* notes the verdict on a step to a time: that it may have leapt, or that branches meet */
static void note_branch(double time, int found, State *s)
{
    if (found == BRANCH_LOST) {
        if (s->branch_points == 0.0) s->branch_point_time = time;
        s->branch_points += 1;
    } else if (found == BIFURCATION) {
        if (s->meetings == 0.0) s->meeting_time = time;
        s->meetings += 1;
    }
}
