/* Kinematics: a motion that drivers determine, position by position. */

/* largest error of a prediction, relative to the motion of the step */
#define PREDICTION_ERROR_PART 0.02
/* error of a prediction that is always negligible, in lengths of the scene or radians */
#define NEGLIGIBLE_PREDICTION_ERROR 1e-9
/* largest part of the motion of a step that velocities may leave unexplained */
#define UNEXPLAINED_MOTION_PART 1e-3
/* unexplained motion up to which no driver has jumped, in lengths of the scene or radians */
#define SMALLEST_JUMP 1e-6
/* largest ratio of the branch ratios at the ends of half a step: if they differ by more, another
 * branch may lie behind a singular configuration in between */
#define MOST_GROWTH 2.0
/* longest motion of bodies in half a step, in lengths of the scene or radians, over which branch
 * ratios show a singular configuration: the angle between two bodies turns by twice as much, and
 * the root of the ratio goes with its sine */
#define LONGEST_WAY 0.6
/* motion of bodies in half a step, in lengths of the scene or radians, up to which it is not
 * shortened any more to find a singular configuration */
#define FINEST_WAY 1e-6
/* error of rates in the middle of a step, in units of what the cubic polynomial is off there */
#define SLOPE_OF_ERROR 8.0
/* power of the excess of an error of sixth order by which a step is made shorter */
#define SIXTH (-1.0 / 6.0)
/* safety factor of the length of a step that is just smooth enough, or that just sums works to the
 * tolerance */
#define NEXT_STEP_SAFETY 0.9
/* largest ratio of a step length to the one before */
#define MOST_NEXT_FACTOR 2.0
/* factor of a step length where nothing tells how short it must be */
#define HALVED 0.5
/* power of the step length with which errors of works by Lobatto's rule of five nodes go */
#define LOBATTO_ORDER 9.0
/* power of the step length with which errors of works by Simpson's rule go */
#define SIMPSON_ORDER 5.0
/* distance, in step lengths, up to which an end is tried behind a position where rows are nearly
 * dependent */
#define FURTHEST_TRIAL 8.0
/* factor of the smallest pivot ratio that positions inside of a step may have, once a leap over
 * such a position has been given up as branches do not meet there */
#define DEEP_RATIO_PART 1e-3
/* the largest turn of a step: angles count their turns [rad] */
#define MOST_TURN 1.0
/* error of works by Simpson's rule, in tolerances, below which no better rule need be tried */
#define SURE_WORK_ERROR 1e-3
/* number of steps after which a better rule is tried even so */
#define RULE_TRIAL_STEPS 64.0
/* rounding of energies, relative to them */
#define ENERGY_ROUNDING 1e-13
/* part of the error of a rule that still counts in the next step: at a turning point of the rate
 * the error is small by chance */
#define ERROR_DECAY 0.5
/* a node of Lobatto's rule of five, a part of a step: (1 - sqrt(3/7)) / 2 */
#define LOBATTO_NODE 0.17267316464601143

/* error of Lobatto's rule, relative to the cube of its correction over the square of Simpson's:
 * twice that of a sine */
#define EVEN_ERROR_PART 0.2
/* place s of its inner nodes from the middle, in half steps: odd powers of time are looked at
 * there, as even ones may correct nothing by chance */
#define ODD_PLACE 0.6546536707079772
/* square of s - s^3, by which a cubic polynomial is off a straight line at this place */
#define ODD_PART 0.14
/* weight of the error that odd powers of time tell */
#define ODD_ERROR_PART 4e-4

/* up to which part of a step a position is found, and where it is kept */
typedef struct {
    double x;
    size_t place;
} Part;
static const Part leap[1] = { { 1.0, 1 } };
static const Part halves[2] = { { 0.5, 0 }, { 1.0, 1 } };
static const Part nodes[4] = { { LOBATTO_NODE, 2 }, { 0.5, 0 }, { 1.0 - LOBATTO_NODE, 3 },
    { 1.0, 1 } };

/* a position and velocity, and their derivative */
typedef struct {
    double *y, *f;
} Position;

/* goes on by h as position, velocity and acceleration predict it, brings that onto the constraints
 * and gives the derivative; 0 where that is impossible */
static int predict_and_correct(
    double t, double h, Position from, Position to, Work *work, State *s, double *drift)
{
    double *w = work->w;
    const double *v = from.y + NQ, *v_dot = from.f + NQ;
    memcpy(w + W_Q, from.y, NQ * sizeof *w);
    for (size_t k = 0; k < NV; ++k) {
        w[W_DQ + k] = h * (v[k] + 0.5 * h * v_dot[k]);
        to.y[NQ + k] = v[k] + h * v_dot[k];
    }
    displace(w, NULL);
    memcpy(to.y, w + W_Q, NQ * sizeof *w);
    return project(t, 0.0, to.y, NULL, to.f, work, s, drift);
}

/* roughness of a step of length h, at most one where it is smooth. It compares the correction of
 * the prediction, and the change of the velocities that the accelerations do not explain, with what
 * is allowed; on another branch both are large. It goes with the square of h */
static double roughness(
    double h, double drift, Position from, Position to, Work *work, const State *s)
{
    const double *v[2] = { from.y + NQ, to.y + NQ }, *v_dot[2] = { from.f + NQ, to.f + NQ };
    double *change = work->scratch;
    const double way = way_of(h, from.y, to.y);
    for (size_t k = 0; k < NV; ++k) {
        change[k] = h * (v[1][k] - v[0][k] - 0.5 * h * (v_dot[0][k] + v_dot[1][k]));
    }
    const double known = larger(
        larger(NEGLIGIBLE_PREDICTION_ERROR, blur_of(work, s)), PREDICTION_ERROR_PART * way);
    double rough = larger(drift, size_of(change)) / known;
    /* no prediction tells how far drivers turn */
    for (size_t k = UNWRAPPED_ANGLES; HAS_JOINT_COORDINATES && k != UNWRAPPED_ANGLES_END; ++k) {
        const double turn = fabs(to.y[k] - from.y[k]) / MOST_TURN;
        rough = larger(rough, turn * turn);
    }
    return rough;
}

/* whether velocities explain where bodies are after two halves of length h. They do not where a
 * driver jumps; the prediction of bodies that are put onto what drives them does not tell of a
 * jump */
static int is_explained(double h, Position start, Position half, Position last)
{
    const double fastest = larger(
        larger(size_of(start.y + NQ), size_of(half.y + NQ)), size_of(last.y + NQ));
    const double most = larger(SMALLEST_JUMP, UNEXPLAINED_MOTION_PART * 2.0 * h * fastest);
    for (size_t k = 0; k < NQ; ++k) {
        const double rates = start.f[k] + 4.0 * half.f[k] + last.f[k];
        const double left = last.y[k] - start.y[k] - h / 3.0 * rates;
        if (!(fabs(left) / floor_of[k] <= most)) return 0;
    }
    return 1;
}

/* branch ratio, negative where all rows are solved for: these have another ratio */
static double signed_ratio(const Work *work, const State *s)
{
    const double ratio = branch_ratio(work, s);
    return HAS_ROW_SWITCH && work->row_switch.is_active != 0.0 ? -ratio : ratio;
}

/* whether half a step of length h may leap over a singular configuration. Another branch lies
 * behind it. The branch ratio goes with the square of the distance from it, which changes at a
 * steady rate: no half passes zero if the ratio changes by a small factor in it and in those beside
 * it. A half that is too short to be halved is noted, and looked at later */
static int may_leap(double h, double before, double after, Position last, State *s)
{
    const double low = smaller(fabs(before), fabs(after));
    const double high = larger(fabs(before), fabs(after));
    const int is_near = high > MOST_GROWTH * low && (before < 0.0) == (after < 0.0);
    const double way = h * size_of(last.y + NQ);
    if (is_near && !(way > FINEST_WAY)) s->is_near = 1.0;
    const int is_long = HAS_REFINEMENT && way > LONGEST_WAY && low < LEVEL_RATIO_PART * high;
    return is_long || (is_near && way > FINEST_WAY);
}

/* where a position of a step is kept: that of its middle, its end, two between */
static Position position_at(size_t place, Work *work)
{
    return (Position){ work->k[2 * place], work->k[2 * place + 1] };
}

/* goes on to the end in parts, or in one leap; whether that was smooth. Powers at the ends and in
 * the middle are summed by Simpson's rule to the works. The largest roughness of the parts goes to
 * rough; it is infinite where no position was found. No position inside has a pivot ratio smaller
 * than weak, where the largest is 1. */
static int reach(double end, const Part *ways, size_t n, double weak, State *s, Work *work,
    double *drift, double *rough)
{
    const Position start = { s->y, s->f }, half = position_at(0, work), last = position_at(1, work);
    const double h = end - s->time;
    const int is_leap = n == 1;
    Position before = start;
    double gone = 0.0, ratio = s->position_ratio, first = 0.0;
    *drift = *rough = 0.0;
    forget_trials(work);
    s->is_near = is_leap ? 1.0 : 0.0; /* a leap goes over such a place */
    for (const Part *part = ways; part != ways + n; ++part) {
        const Position to = position_at(part->place, work);
        const double way = (part->x - gone) * h;
        const double time = part->x == 1.0 ? end : s->time + part->x * h;
        if (!predict_and_correct(time, way, before, to, work, s, &first)) {
            *rough = HUGE_VAL;
            return 0;
        }
        *rough = larger(roughness(way, first, before, to, work, s), *rough);
        if (!(*rough <= 1.0)) return 0;
        if (part->x < 1.0 && pivot_ratio(work, s) < weak * s->largest_pivot_ratio) return 0;
        const double there = signed_ratio(work, s);
        if (!is_leap && may_leap(way, ratio, there, to, s)) return 0;
        gone = part->x;
        before = to;
        ratio = there;
        *drift = larger(first, *drift);
    }
    if (HAS_JOINT_COORDINATES && !is_leap && !is_explained(0.5 * h, start, half, last)) return 0;
    for (size_t k = NQ - WORKS; k != NQ; ++k) {
        last.y[k] = start.y[k] + (is_leap ? h / 2.0 * (start.f[k] + last.f[k])
                                          : h / 6.0 * (start.f[k] + 4.0 * half.f[k] + last.f[k]));
    }
    return 1;
}

/* whether a step to an end may lead onto another branch: BRANCH_LOST, ON_BRANCH or BIFURCATION */
static int branch_at(double end, State *s, Work *work)
{
    if (!(HAS_REFINEMENT && s->is_near > 0.0)) return ON_BRANCH;
    const Position last = position_at(1, work);
    const double first = sqrt(fabs(s->position_ratio)), after = sqrt(branch_ratio(work, s));
    const double part = meeting_part(first, after), h = end - s->time;
    const int found = follow_branch(h, last.y, last.f, part, first + after, work, s);
    place(end, last.y, work->w); /* its geometry again */
    ratio_at(last.y, work, s);
    return found;
}

/* finds the positions of a step in halves at the other nodes; whether they are */
static int find_between(double end, double weak, State *s, Work *work)
{
    const double h = end - s->time;
    for (size_t k = 0; k != 2; ++k) {
        const Position from = k == 0 ? (Position){ s->y, s->f } : position_at(0, work);
        const Position to = position_at(2 + k, work);
        const double x = k == 0 ? LOBATTO_NODE : 1.0 - LOBATTO_NODE,
                     way = (k == 0 ? x : x - 0.5) * h;
        double drift = 0.0;
        if (!predict_and_correct(s->time + x * h, way, from, to, work, s, &drift)) return 0;
        if (!(roughness(way, drift, from, to, work, s) <= 1.0)) return 0;
        if (pivot_ratio(work, s) < weak * s->largest_pivot_ratio) return 0;
    }
    return 1;
}

/* the energy that errors of works are compared with, where that at its end is in the workspace */
static double moving_energy(double h, const State *s, Work *work)
{
    const double *end = position_at(1, work).y;
    const double moved = larger(s->moved, energy_moved(work->w, end, s));
    return energy_of_works(h, end, moved, s) + work->w[W_ENERGIES];
}

/* what errors of works are compared with in a step of length h, beside the works [J] */
static double least_size_of_works(double h, const State *s, Work *work)
{
    energy(work->w);
    return moving_energy(h, s, work);
}

/* what a step of length h leaves of energy that no work explains, in tolerances: the energy of
 * positions is exact, and tells what no rule says of its own error, as where powers are narrow
 * beside the nodes. Steps over the finest way are not asked: energies differ by what rates are
 * rounded to, of which a shorter step has as much */
static double unbalanced(const Settings *settings, double h, const State *s, Work *work)
{
    const double *w = work->w, *end = position_at(1, work).y;
    if (way_of(h, s->y, end) <= FINEST_WAY) return 0.0;
    const double left = fabs(energy_balance(w, end, s) - s->balance);
    double most = 0.0;
    for (size_t k = NQ - WORKS; k != NQ; ++k) {
        most = larger(larger(fabs(s->y[k]), fabs(end[k])), most);
    }
    const double size = moving_energy(h, s, work) + most;
    const double known = ENERGY_ROUNDING * larger(fabs(w[W_ENERGIES + 1]), fabs(s->energy));
    /* velocities are known to as much of the way to another branch as positions are */
    const double blur = blur_of(work, s), rounding = scale_by_distance(s->y) * BRANCH_ROUNDING;
    return left / ((settings->tolerance + blur * blur / rounding) * size + known);
}

/* sums the works of a step by a better rule than Simpson's, unless that is good enough, and returns
 * the error in units of the tolerance. The relative error of Simpson's rule is about the square of
 * that of the trapezoidal rule. Unless it is far below the tolerance, two more positions estimate
 * it, and works are summed by Lobatto's rule. This rule is also tried once in RULE_TRIAL_STEPS
 * steps: periodic powers that are the same at both ends and in the middle differ at its nodes. The
 * error of Simpson's rule since the last trial goes to the ledger */
static double sum_works(const Settings *settings, double end, double weak, int has_nodes, State *s,
    Work *work, int *is_estimated, double *simpson)
{
    const double h = end - s->time, *rate = s->f, *half = position_at(0, work).f;
    const double *f = position_at(1, work).f, *one = position_at(2, work).f;
    const double *other = position_at(3, work).f;
    double *y = position_at(1, work).y, error = 0.0, most = 0.0, missed = 0.0, estimated = 0.0;
    *is_estimated = 1;
    if (WORKS == 0) return 0.0;
    *is_estimated = 0;
    const double least = least_size_of_works(h, s, work);
    for (size_t k = NQ - WORKS; k != NQ; ++k) {
        const double size = least + larger(fabs(s->y[k]), fabs(y[k]));
        const double way = fabs(rate[k]) + 2.0 * fabs(half[k]) + fabs(f[k]);
        const double left = (2.0 * half[k] - rate[k] - f[k]) / 6.0;
        if (way > 0.0) error = larger(0.5 * h * left * (left / way) / size, error);
    }
    error = s->simpson = larger(error / settings->tolerance, ERROR_DECAY * s->simpson);
    if (!has_nodes) {
        if (error < SURE_WORK_ERROR && fmod(s->steps, RULE_TRIAL_STEPS) != 0.0) return error;
        has_nodes = find_between(end, weak, s, work);
        place(end, y, work->w); /* its geometry again */
        ratio_at(y, work, s);
        if (!has_nodes) return error;
    }
    *is_estimated = 1;
    for (size_t k = NQ - WORKS; k != NQ; ++k) {
        const double size = least + larger(fabs(s->y[k]), fabs(y[k]));
        const double ends = 0.5 * (rate[k] + f[k]), inner = 0.5 * (one[k] + other[k]);
        const double more = 49.0 / 90.0 * h * (inner - half[k] - 3.0 / 7.0 * (ends - half[k]));
        const double coarse = h * (ends - half[k]) / 3.0;
        const double square = more * more + coarse * coarse;
        if (square > 0.0)
            estimated = larger(
                EVEN_ERROR_PART * fabs(more) * (more * more / square) / size, estimated);
        const double slope = 0.5 * (f[k] - rate[k]);
        const double odd = 0.5 * (other[k] - one[k]) - ODD_PLACE * slope;
        const double squares = odd * odd + slope * slope * ODD_PART;
        if (squares > 0.0)
            estimated = larger(
                ODD_ERROR_PART * h * fabs(odd) * (odd * odd / squares) / size, estimated);
        most = larger(fabs(more), most);
        missed = larger(fabs(more) / size, missed);
        y[k] += more;
    }
    *simpson = missed / settings->tolerance;
    s->simpson = larger(*simpson, s->simpson);
    if (error < SURE_WORK_ERROR) {
        s->work_error += most / h * smaller(s->untold, RULE_TRIAL_STEPS * h);
        s->untold = 0.0;
    }
    return larger(estimated / settings->tolerance, ERROR_DECAY * s->error);
}

/* what is known of the works of a step: their error, and that of Simpson's rule if more positions
 * estimated it, in units of the tolerance; at its end the energy that no work explains, and that
 * which has moved [J]; whether more positions estimated the error */
typedef struct {
    double error, simpson, balance, moved;
    int is_estimated;
} WorkEstimate;

/* sums the works of a step better unless it leaps, and tells what its energy says of them */
static void estimate_works(const Settings *settings, double end, double weak, size_t n, State *s,
    Work *work, WorkEstimate *works)
{
    const double *y = position_at(1, work).y;
    check_misses(settings, work);
    if (n > 1)
        works->error = sum_works(
            settings, end, weak, n == 4, s, work, &works->is_estimated, &works->simpson);
    else if (WORKS > 0) energy(work->w);
    if (WORKS == 0) return;
    works->error = larger(unbalanced(settings, end - s->time, s, work), works->error);
    works->moved = energy_moved(work->w, y, s);
    works->balance = energy_balance(work->w, y, s);
}

/* keeps a position, at or behind the time that is asked for */
static void accept_position(
    const Settings *settings, double end, double asked, Work *work, State *s)
{
    const double h = end - s->time;
    const Position last = position_at(1, work);
    double *f_before = work->k[0];
    s->time_before = end > asked ? s->time : end;
    s->time = end;
    s->steps += 1;
    note_misses(settings, work, s);
    note_motion(h, last.y, s);
    memcpy(s->y_before, s->y, NY * sizeof *s->y);
    memcpy(f_before, s->f, NY * sizeof *s->y);
    memcpy(s->y, last.y, NY * sizeof *s->y);
    memcpy(s->f, last.f, NY * sizeof *s->y);
    if (end > asked) {
        memset(s->dense, 0, sizeof s->dense);
        hermite_cubic(h, s->y, f_before, s->f, s);
    }
}

/* notes the pivot ratio and the branch ratio of a position that is kept. Where the pivot ratio is
 * weak, later ones are weak only below it, or further below if deep */
static void note_ratios(double ratio, double end, int is_deep, State *s, const Work *work)
{
    note_pivot_ratio(ratio, end, s);
    if (ratio < WEAK_PIVOT_RATIO * s->largest_pivot_ratio)
        s->largest_pivot_ratio = ratio / WEAK_PIVOT_RATIO * (is_deep ? DEEP_RATIO_PART : 1.0);
    s->largest_pivot_ratio = larger(s->largest_pivot_ratio, ratio);
    note_largest_pivot(work, s);
    s->position_ratio = signed_ratio(work, s);
    s->usual_ratio = larger(s->usual_ratio, s->position_ratio);
}

/* what the polynomial needs to meet y and its derivative f in the middle of a step of h, too */
static void add_middle_rows(double h, const double *y, const double *f, State *s)
{
    for (size_t i = 0; i < NY; ++i) {
        const double step = s->dense[0][i], first = s->dense[1][i], second = s->dense[2][i];
        const double off = y[i] - s->y_before[i] - (0.5 * step + 0.25 * first + 0.125 * second);
        const double slope = h * f[i] - step - 0.25 * second;
        s->dense[3][i] = 16.0 * off - 8.0 * slope;
        s->dense[4][i] = 16.0 * slope;
    }
}

/* up to which time a step may be so long that its polynomial tells of all events. It will meet
 * the position in the middle, too: the error that is left, of sixth order, goes with the square of
 * what the cubic polynomial is off there, relative to the motion */
static double exact_end(double end, const Search *search, const State *s, Work *work)
{
    const Position half = position_at(0, work);
    const double h = search->h, time = search->start + 0.5 * h;
    double cubic[ROOM(N_READ)], known[ROOM(N_READ)], excess = 0.0;
    if (EVENTS == 0 || way_of(h, s->y, position_at(1, work).y) <= FINEST_WAY) return end;
    read_at(time, search, s, work, cubic);
    read_of(time, half.y, work, known);
    for (size_t k = 0; k != N_MEASURES; ++k) {
        const double rate = fabs(known[2 * k + 1] - cubic[2 * k + 1]);
        const double change = h * search->second_bound[k];
        const double left[2] = { fabs(known[2 * k] - cubic[2 * k]) + h * rate,
            SLOPE_OF_ERROR * rate };
        const double moved[2] = { h * larger(fabs(cubic[2 * k + 1]), change), change };
        for (size_t n = 0; n != 2; ++n) {
            const double part = left[n] < moved[n] ? left[n] / moved[n] : 1.0;
            excess = larger(left[n] * part / search->noise[2 * k + n], excess);
        }
    }
    if (!(excess > 1.0)) return end;
    return search->start + h * larger(LEAST_STEP_FACTOR, NEXT_STEP_SAFETY * pow(excess, SIXTH));
}

/* where a position to an end must be, so that forces between are resolved, and events; one that
 * leaps over a place stays where it is */
static double watched_end(
    const Settings *settings, double end, double part, Search *search, State *s, Work *work)
{
    const Position half = position_at(0, work), last = position_at(1, work);
    const Method *m = methods + METHODS - 1;
    begin_search(settings, m, 0, end - s->time, last.y, s->f, last.f, search, s, work);
    const double exact = part <= 1.0 ? exact_end(end, search, s, work) : end;
    if (exact < end) return exact;
    if (part <= 1.0) add_middle_rows(search->h, half.y, half.f, s);
    const double seen = crossing_end(end, search, s, work);
    const int is_cut = seen < end && part <= 1.0;
    const double resolved = N_NARROW > 0 ? resolved_end(is_cut ? seen : end, search, s, work) : end;
    if (search->pole) return cut_at(end_before_pole(search, s), search);
    if (part > 1.0) {
        search->is_unresolved = search->is_unresolved || resolved < end;
        return end;
    }
    return seen <= resolved && seen < end ? cut_at(seen, search) : smaller(resolved, seen);
}

/* how much longer than a step the next one is, or that which is tried in its place */
static double following(double error, double rough, int is_good, int is_estimated)
{
    const double by_shape = rough > 0.0 ? NEXT_STEP_SAFETY / sqrt(rough) : MOST_NEXT_FACTOR;
    if (!is_good)
        return 1.0 < rough && rough < HUGE_VAL ? larger(LEAST_STEP_FACTOR, by_shape) : HALVED;
    if (!isfinite(error)) return HALVED;
    const double order = is_estimated ? LOBATTO_ORDER : SIMPSON_ORDER;
    const double by_work = error > 0.0 ? NEXT_STEP_SAFETY * pow(error, -1.0 / order)
                                       : MOST_NEXT_FACTOR;
    return larger(LEAST_STEP_FACTOR, smaller(MOST_NEXT_FACTOR, smaller(by_shape, by_work)));
}

/* notes the works of a step of length h that is kept, with the error that counts */
static void note_works(
    const Settings *settings, const WorkEstimate *works, double error, double h, State *s)
{
    note_moved(settings, works->moved, s);
    s->untold += works->is_estimated ? 0.0 : h;
    s->error = works->is_estimated ? error : 0.0;
    s->balance = works->balance;
}

/* whether nothing tells that works are good, as a force varies beyond polynomials. Both rules may
 * be off alike between their nodes, and at the tail of a hill what the better one adds says
 * little: Simpson's must be good, too */
static int is_blind(const WorkEstimate *works, const State *s)
{
    const int is_sure = works->is_estimated || s->simpson >= SURE_WORK_ERROR;
    return WORKS > 0 && N_NARROW > 0 && (works->simpson > 1.0 || !is_sure);
}

/* factor to the step that is tried in place of a blind one: 1 to estimate it first */
static double factor_where_blind(double rough, const WorkEstimate *works, State *s)
{
    s->rejected += 1;
    if (works->is_estimated) return following(works->simpson, rough, 1, 0);
    s->simpson = SURE_WORK_ERROR; /* asks for more positions */
    return 1.0;
}

/* length of the first trial of a step; the last one is tiny up to a cut near the start */
static double first_length(const Settings *settings, double asked, const State *s)
{
    if (!(s->step_size > 0.0)) return settings->largest_step;
    const double least = ONWARD * SMALLEST * larger(fabs(s->time), fabs(asked));
    return smaller(larger(s->step_size, least), settings->largest_step);
}

/* the next position of a motion that drivers determine, at most at the time that is asked for.
 * Steps are made shorter until they are smooth and sum works to the tolerance. Where rows are
 * nearly dependent at the end, it is put elsewhere: before that position as long as possible, then
 * behind it, also behind the time that is asked for */
static int driven_step(const Settings *settings, double asked, State *s, Work *work)
{
    double drift = 0.0, rough = 0.0, part = 1.0;
    int is_deep = 0;
    double longest = first_length(settings, asked, s);
    const int tells_works = HAS_ENERGIES || settings->checks; /* in rows, or the ledger */
    Search search = { .cut = s->time, .is_kept = 1 };
    for (;;) {
        const int is_last = s->time + STRETCH_TO_END * longest >= asked;
        const double whole = is_last ? asked - s->time : longest;
        const double end = is_last && part == 1.0 ? asked : s->time + part * whole;
        if (!(end - s->time > SMALLEST * larger(fabs(s->time), fabs(asked)))) return STEP_TOO_SMALL;
        const int has_nodes = part <= 1.0 && tells_works && s->simpson >= SURE_WORK_ERROR;
        const Part *ways = part > 1.0 ? leap : has_nodes ? nodes : halves;
        const size_t n = part > 1.0 ? 1 : has_nodes ? 4 : 2;
        const double weak = WEAK_PIVOT_RATIO * (is_deep ? DEEP_RATIO_PART : 1.0);
        const int good = reach(end, ways, n, weak, s, work, &drift, &rough);
        const double ratio = pivot_ratio(work, s);
        WorkEstimate works = { 0.0, 0.0, 0.0, 0.0, 0 };
        if (good && tells_works) estimate_works(settings, end, weak, n, s, work, &works);
        const double error = part > 1.0 ? 0.0 : works.error; /* leaps sum no works well */
        const double factor = following(error, rough, good, works.is_estimated);
        const int is_avoided = part < FURTHEST_TRIAL && !is_deep &&
                               ratio < WEAK_PIVOT_RATIO * s->largest_pivot_ratio;
        const int is_fit = good && error <= 1.0 && !is_avoided;
        const int branch = is_fit ? branch_at(end, s, work) : ON_BRANCH;
        /* onto another branch, or over what one can go through, as works want */
        const int is_leap = part > 1.0 &&
                            (branch == BRANCH_LOST || (branch == ON_BRANCH && works.error > 1.0));
        if (is_avoided) {
            s->avoided += 1;
            part = part == 0.5 ? 1.25 : part <= 1.0 ? part - 0.25 : 1.25 * part;
            continue;
        }
        if (!is_fit || is_leap) {
            s->rejected += 1;
            longest = (is_leap ? 1.0 : part <= 1.0 ? factor : 0.5) * whole;
            part = 1.0;
            is_deep = is_deep || is_leap;
            continue;
        }
        if (N_FUNCTIONS > 0) {
            const double seen = watched_end(settings, end, part, &search, s, work);
            const int why = why_stopped(seen, &search, s);
            if (why != GOOD) return why;
            if (seen < end) {
                if (seen == search.cut) asked = seen;
                longest = larger(seen, s->time + FINEST * whole) - s->time;
                part = 1.0;
                continue;
            }
            if (part <= 1.0 && tells_works && is_blind(&works, s)) {
                longest = factor_where_blind(rough, &works, s) * whole;
                part = 1.0;
                continue;
            }
            note_crossings(end, &search, s, work);
            if (search.is_unresolved) note_unresolved(s->time, s);
        }
        note_branch(end, branch, s);
        note_ratios(ratio, end, is_deep, s, work);
        s->drift = larger(s->drift, drift);
        note_works(settings, &works, error, end - s->time, s);
        s->step_size = larger(is_last ? s->step_size : 0.0, factor * whole);
        accept_position(settings, end, asked, work, s);
        return GOOD;
    }
}
