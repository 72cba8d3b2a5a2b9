/* Switching: steps end where formulas of time have a kink or a jump, and miss nothing between.
 *
 * A scene bounds its switching functions and their rates between any two times. Where these exclude
 * a root there is none, so that no two roots hide in one step. Parts that vary with time beyond
 * polynomials are bounded likewise: a step is at most as long as the times between which samples
 * tell how such a part varies, so that none leaps over a narrow bump. */

/* largest number of intervals that a search looks at; then the run goes on to where the search
 * came */
#define MOST_INTERVALS 4096
/* number of these intervals after which laws of drivers are no longer looked at: a law whose bounds
 * do not tell by then whether it bends is gone over, and counted */
#define MOST_BOUNDS 4000
/* number of short steps in a row after which samples bound steps no more, until steps are long
 * again */
#define MOST_SHORT 1000
/* a step is short if samples bound it below this part of the longest step tried */
#define SHORT 1e-4
/* the longest step tried is taken as no more than this many times the longest one made: a span says
 * nothing of how long steps could be */
#define GROWTH 10.0
/* factor by which the longest step tried fades in each step */
#define FORGETTING 0.9999
/* steps are long again from this part of the longest step tried */
#define LONG 0.1
/* larger distance from a switch at which laws of drivers are compared on both sides, relative to
 * the time: no law bends there that goes on smoothly as seen from one of both distances */
#define FAR_BESIDE 1e-6
/* smaller distance at which they are compared */
#define BESIDE 1e-7
/* rounding of laws of drivers, relative to their values */
#define EQUAL 1e-12
/* distance behind a switch up to which forces are tried until they have values, relative to the
 * time: a force may be infinite at the switch itself */
#define FURTHEST_BEHIND 1e-12
/* factor by which the third derivative of a law may exceed those on both sides of a switch */
#define BENDING 4.0
/* ratio of each displacement of bodies to the one before, of which the first is their rounding:
 * three of them tell whether forces are too steep for doubles */
#define FAR_BY_ROUNDING 16.0
/* changes of forces by two such displacements are those of a slope if they deviate from it by at
 * most this part of the larger change */
#define EVEN_SLOPE 0.03
/* their means over both sides are those of a kink if they deviate from it by at most this part */
#define EVEN_KINK 0.01
/* a body that is pushed back by more than this many times its displacement until the end of the run
 * swings: once and a half or more often */
#define SWINGS 100.0
/* multiples of this number lie evenly between integers */
#define GOLDEN_RATIO 0.6180339887498949
/* factor of the squares of these multiples that scatters them between integers */
#define SCATTERING 997.0
/* number of pieces of an interval, with a sample at each end of them */
#define PIECES 4

/* least, most, slowest and fastest of switching functions and of parts that vary, to the workspace
 */
static void bounds_between(double first, double last, double *w)
{
    w[W_SPAN] = first;
    w[W_SPAN + 1] = last;
    switching(w);
}

/* the values of switching functions at a time */
static void switches_at(double time, double *w, double *values_there)
{
    bounds_between(time, time, w);
    for (size_t k = 0; k != N_SWITCHES; ++k) values_there[k] = w[W_SWITCHES + 4 * k];
}

static int sign_of(double x) { return (x > 0.0) - (x < 0.0); }

/* whether the switching functions bounded in the workspace have no root in an interval. Those that
 * are zero all along have none, nor have those that rise or fall all along between values of one
 * sign. Else each is no less than lines from both ends as steep as its bounds */
static int are_rootless(const double *w, const double *before, const double *after, double h)
{
    for (size_t k = 0; k != N_SWITCHES; ++k) {
        const double *bounds = w + W_SWITCHES + 4 * k;
        const double least = bounds[0], most = bounds[1], slowest = bounds[2], fastest = bounds[3];
        /* whatever rounding makes of bounds */
        if (sign_of(before[k]) != sign_of(after[k])) return 0;
        if (least > 0.0 || most < 0.0 || (least == 0.0 && most == 0.0)) continue;
        if (slowest >= 0.0 || fastest <= 0.0) continue;
        const int down = before[k] < 0.0;
        const double a = down ? -before[k] : before[k], b = down ? -after[k] : after[k];
        const double falls = down ? -fastest : slowest, rises = down ? -slowest : fastest;
        if (!stays_positive(a, b, falls, rises, h)) return 0;
    }
    return 1;
}

/* laws of drivers between two times, each with two derivatives, to the workspace */
static void bound_laws(double first, double last, double *w)
{
    w[W_LAW_SPAN] = first;
    w[W_LAW_SPAN + 1] = last;
    bending(w);
}

/* whether rates of laws change evenly within rounding of times, all along between two times. The
 * uneven change, from bounds of the third derivative, is at most the part BENT of the rate. If the
 * law is at rest there, it is compared with its rate further away, or with the law itself over the
 * whole time */
static int are_unbent(double first, double last, double span, double *w)
{
    double change[ROOM(N_LAWS)], size[ROOM(N_LAWS)];
    const double no_time = NO_TIME * SMALLEST * span, far = FAR_BESIDE * span;
    const double times[2] = { first - far, last + far };
    int is_told = 1;
    bound_laws(first, last, w);
    for (size_t k = 0; k != N_LAWS; k += 3) {
        const double *law = w + W_LAWS + 4 * k, *rate = law + 4, *third = law + 10;
        const double fastest = larger(fabs(rate[0]), fabs(rate[1]));
        size[k] = larger(fastest, larger(fabs(law[0]), fabs(law[1])) / span);
        change[k] = (fabs(third[0]) + fabs(third[1])) * no_time * no_time;
        if (!isfinite(change[k])) return 0;
        is_told = is_told && change[k] <= BENT * size[k];
    }
    for (size_t n = 0; n != 2 && !is_told; ++n) {
        bound_laws(times[n], times[n], w);
        for (size_t k = 0; k != N_LAWS; k += 3) {
            const double rate = fabs(w[W_LAWS + 4 * k + 4]);
            size[k] = larger(isfinite(rate) ? rate : 0.0, size[k]);
        }
    }
    if (is_told) return 1;
    for (size_t k = 0; k != N_LAWS; k += 3) {
        if (!(change[k] <= BENT * size[k])) return 0;
    }
    return 1;
}

/* adds the error that rounding may leave of laws and two derivatives at a time. They may be
 * differences of much larger terms: bounds within rounding of the time tell it */
static void law_rounding(double time, double span, double *rounding, double *w)
{
    const double no_time = NO_TIME * SMALLEST * span;
    bound_laws(time - no_time, time + no_time, w);
    for (size_t k = 0; k != N_LAWS; ++k) {
        const double width = w[W_LAWS + 4 * k + 1] - w[W_LAWS + 4 * k];
        rounding[k] += isfinite(width) ? width : 0.0;
    }
}

/* first law without two derivatives between two times, counted from 1, or 0. Values at a distance
 * beside both times tell it: the law and each derivative change by the mean of the next derivative
 * on both sides, and the law in between lies between its values, if it has one there */
static size_t bent_beside(double far, double first, double last, double span, double *w)
{
    double laws[ROOM(4 * N_LAWS)], between[ROOM(N_LAWS)], rounding[ROOM(N_LAWS)] = { 0.0 };
    const double half = 0.5 * (last - first) + far, *after = w + W_LAWS;
    const double there = 0.5 * (first + last);
    law_rounding(first - far, span, rounding, w);
    law_rounding(last + far, span, rounding, w);
    bound_laws(there, there, w);
    for (size_t k = 0; k != N_LAWS; k += 3) between[k] = after[4 * k];
    bound_laws(first - far, first - far, w);
    memcpy(laws, after, 4 * N_LAWS * sizeof *laws);
    bound_laws(last + far, last + far, w);
    for (size_t k = 0; k != N_LAWS; ++k) {
        const size_t at = 4 * (k - k % 3 + 2) + 2; /* the third derivative */
        const double a = laws[4 * k], b = after[4 * k];
        const double left = b - a - half * (laws[4 * k + 2] + after[4 * k + 2]);
        const double third = fabs(laws[at]) + fabs(after[at]);
        const double powers[3] = { half * half * half, half * half, half };
        const double bent = BENDING * third * powers[k % 3];
        const double size = EQUAL * (fabs(a) + fabs(b)) + rounding[k];
        if (!(fabs(left) <= size + bent)) return k / 3 + 1;
        if (k % 3 != 0) continue;
        const double second = fabs(laws[4 * (k + 2)]) + fabs(after[4 * (k + 2)]);
        const double off = fabs(between[k] - 0.5 * (a + b));
        if (off > size + second * (half * half) + bent) return k / 3 + 1;
    }
    return 0;
}

/* the first law that bends or jumps between two times that are nearly one, counted from 1, or 0 */
static size_t bent_law(double first, double last, double span, double *w)
{
    if (N_LAWS == 0 || bent_beside(FAR_BESIDE * span, first, last, span, w) == 0) return 0;
    return bent_beside(BESIDE * span, first, last, span, w);
}

/* the first driven distance, a gap, that is none between two times, counted from 1, or 0 */
static size_t lost_gap(double first, double last, double *w)
{
    size_t lost = N_GAPS;
    if (N_GAPS == 0) return 0;
    /* where one gets on the other side bounds may be above it by rounding */
    for (size_t n = 0; n != 2; ++n) {
        bounds_between(n == 0 ? first : last, last, w);
        for (size_t k = 0; k != N_GAPS; ++k) {
            if (w[W_GAPS + 4 * k] <= 0.0 && k < lost) lost = k;
        }
    }
    return lost == N_GAPS ? 0 : lost + 1;
}

/* whether there is no root of a switching function between two times, where functions have values
 * before and after, nor bends a law that is followed */
static int is_even(double first, double last, double span, const double *before, double *after,
    int follows, double *w)
{
    if (N_SWITCHES > 0) {
        switches_at(last, w, after);
        bounds_between(first, last, w);
        if (!are_rootless(w, before, after, last - first)) return 0;
    }
    if (!follows || are_unbent(first, last, span, w)) return 1;
    /* bounds may be infinite at a single time */
    return last - first <= SMALLEST * span && bent_law(first, last, span, w) == 0;
}

/* the first root of a switching function, or bend of a law: no step goes beyond it */
static void find_switch(double end, State *s, Work *work)
{
    int follows = N_LAWS > 0;
    double before[ROOM(N_SWITCHES)] = { 0.0 }, after[ROOM(N_SWITCHES)] = { 0.0 };
    double *w = work->w, first = s->time, h = end - first;
    const double span = larger(fabs(first), fabs(end));
    if (N_SWITCHES > 0) switches_at(first, w, before);
    for (size_t n = 0; n != MOST_INTERVALS; ++n) {
        const double last = h < end - first ? first + h : end;
        if (n == MOST_BOUNDS && follows) {
            note_unresolved(first, s);
            follows = 0;
        }
        if (is_even(first, last, span, before, after, follows, w)) {
            first = last;
            memcpy(before, after, sizeof before);
            if (first == end) break;
            h = 2.0 * h;
        } else if (last - first <= SMALLEST * span) {
            s->limit = first;
            s->behind = last;
            return;
        } else {
            h = 0.5 * (last - first);
        }
    }
    /* laws without a bend limit no step */
    s->limit = s->behind = N_SWITCHES == 0 && first == end ? HUGE_VAL : first;
}

/* puts bodies behind a switch; whether forces have values there. If a force is infinite at the
 * switch, as log|t - 5| is, they are put a little further behind it */
static int is_put_behind(double span, State *s, Work *work)
{
    for (double further = SMALLEST; further < FURTHEST_BEHIND; further *= FURTHER) {
        forget_trials(work);
        if (project(s->time, 0.0, s->y, s->low, s->f, work, s, NULL)) return 1;
        s->time = s->switched = s->switched + further * span;
    }
    return 0;
}

/* notes what a force that is infinite at a switch may do while bodies are put behind it. Nothing
 * moves there, and rounding hides times that are nearer to the switch. The change of speed is
 * estimated as the time between both sides times the accelerations on both: that is its size for
 * 1/sqrt|t - 5|, or so large that it tells of a steeper force. Where no force can be infinite it is
 * no more than rounding */
static void note_impulse(double before, double acceleration, State *s, Work *work)
{
    const double exact[ROOM(N_READ)] = { 0.0 }, times[2] = { before, s->time };
    TimeNode nodes[2];
    int is_there = 0;
    if (N_POLES == 0) return;
    for (size_t n = 0; n != 2; ++n) {
        read_of(times[n], s->y, work, nodes[n].read);
        evaluate_node(exact, times[n], work->w, &nodes[n]);
    }
    for (size_t k = N_SWITCHING; k != N_CROSSINGS; ++k) {
        if (side_at(&nodes[0], k) != side_at(&nodes[1], k)) is_there = 1;
    }
    if (!is_there) return;
    const double both = acceleration + size_of(s->f + NQ);
    s->impulse += (s->time - before) * both;
    s->impulse_time = s->time;
}

/* half widths of the parts of forces that vary beyond polynomials, and their sizes, where what
 * formulas read at a time is known to a noise */
static void widths_of(
    const double *read, const double *noise, double time, double *w, double *widths, double *sizes)
{
    TimeNode node;
    memcpy(node.read, read, sizeof node.read);
    evaluate_node(noise, time, w, &node);
    for (size_t k = 0; k != N_NARROW; ++k) {
        widths[k] = half_width(&node, N_CROSSINGS + k);
        sizes[k] = fabs(middle(&node, N_CROSSINGS + k));
    }
}

/* which such parts change, by rounding of what they read, as none that has a slope; how many they
 * are. Such a part changes by much more than a sixteenth of its change by sixteen times the
 * rounding */
static size_t find_steep(
    const double *read, const double *noise, double time, double *w, int *is_steep)
{
    double far[ROOM(N_READ)], widths[ROOM(N_NARROW)], wider[ROOM(N_NARROW)], sizes[ROOM(N_NARROW)];
    size_t count = 0;
    for (size_t k = 0; k != N_READ; ++k) far[k] = FAR_BY_ROUNDING * noise[k];
    widths_of(read, far, time, w, wider, sizes);
    widths_of(read, noise, time, w, widths, sizes);
    for (size_t k = 0; k != N_NARROW; ++k) {
        const double least = larger(EVEN_SLOPE * wider[k], SMALLEST * sizes[k]);
        is_steep[k] = widths[k] - wider[k] / FAR_BY_ROUNDING > least;
        count += is_steep[k] ? 1 : 0;
    }
    return count;
}

/* a number between -1 and 1, other ones for all n, no multiples or differences of others */
static double scattered(size_t n)
{
    const double part = fmod((double)n * GOLDEN_RATIO, 1.0);
    return 2.0 * fmod(SCATTERING * part * part, 1.0) - 1.0;
}

/* puts bodies elsewhere, and makes them faster, by so many roundings, and gives the derivative
 * there; 0 where there is none */
static int displace_by_rounding(double times, double *y, double *f, State *s, Work *work)
{
    const double part = times * SMALLEST, length = LENGTH * scale_by_distance(s->y);
    memcpy(y, s->y, NY * sizeof *y);
    for (size_t k = 0; k != SHIFTS; ++k) y[shifts[k][0]] += part * scattered(k) * length;
    for (size_t k = 0; k != ORIENTATIONS; ++k) {
        for (size_t i = 0; i != orientations[k][2]; ++i)
            y[orientations[k][0] + i] += part * scattered(orientations[k][0] + i);
    }
    for (size_t k = 0; k != NV; ++k)
        y[NQ + k] += part * scattered(k) * (s->fastest * (is_length[k] ? LENGTH : 1.0));
    forget_trials(work);
    return project(s->time, 0.0, y, NULL, f, work, s, NULL);
}

/* what formulas read of y at a time, and some way ahead at its derivative */
static void read_beside(double time, double way, const double *y, const double *f, Work *work,
    double *read, double *ahead)
{
    read_of(time, y, work, read);
    for (size_t k = 0; k != NY; ++k) work->scratch[k] = y[k] + way * f[k];
    read_of(time, work->scratch, work, ahead);
}

/* by how much rounding changes accelerations where forces are too steep for doubles, as that of
 * sqrt(abs(x)) where x is zero but for rounding. By bodies on both sides of a place, and twice as
 * many times further away, that tells of even and odd parts of forces what no slope and no kink
 * explains. The odd ones are none where each steep part pushes a body back, beyond rounding, by
 * what it reads: that swings there until the end of a run */
static double change_by_rounding(double end, State *s, Work *work)
{
    enum { SIDES = 6 };
    double rounding[ROOM(N_READ)], alone[ROOM(N_READ)] = { 0.0 }, read[ROOM(N_READ)];
    double beside[SIDES][ROOM(N_READ)], ahead[SIDES][ROOM(N_READ)];
    int is_steep[ROOM(N_NARROW)], by_this[ROOM(N_NARROW)], is_back[ROOM(N_NARROW)] = { 0 };
    const double away = scale_by_distance(s->y), span = larger(fabs(s->time), fabs(end));
    const double longest = s->stride > 0.0 ? s->stride : span;
    double times = 1.0;
    int swings = 1;
    read_of(s->time, s->y, work, read);
    for (size_t k = 0; k != N_MEASURES; ++k) {
        rounding[2 * k] = SMALLEST * (measure_sizes[k] * away + fabs(read[2 * k]));
        rounding[2 * k + 1] = SMALLEST * (measure_sizes[k] * s->fastest + fabs(read[2 * k + 1]));
    }
    if (find_steep(read, rounding, s->time, work->w, is_steep) == 0) return 0.0;
    for (size_t n = 0; n != SIDES; ++n) {
        if (!displace_by_rounding(times, work->y, work->k[n], s, work)) return 0.0;
        read_beside(s->time, longest, work->y, work->k[n], work, beside[n], ahead[n]);
        times = n % 2 == 0 ? -times : -FAR_BY_ROUNDING * times;
    }
    for (size_t k = 0; k != N_READ; ++k) {
        const size_t rate = k | 1;
        const double moved = 0.5 * (beside[0][k] - beside[1][k]);
        const double first = ahead[0][rate] - beside[0][rate];
        const double faster = 0.5 * (first - (ahead[1][rate] - beside[1][rate]));
        const double back = moved > 0.0 ? -faster : faster;
        const double way = back / longest * span * (k == rate ? 1.0 : span);
        const int is_pushed = back > SMALLEST * measure_sizes[k / 2] * s->fastest;
        if (!(is_pushed && way > SWINGS * fabs(moved))) continue;
        alone[k] = rounding[k];
        find_steep(read, alone, s->time, work->w, by_this);
        alone[k] = 0.0;
        for (size_t n = 0; n != N_NARROW; ++n) is_back[n] |= by_this[n];
    }
    for (size_t n = 0; n != N_NARROW; ++n) swings &= !is_steep[n] || is_back[n];
    for (size_t k = 0; k != NV; ++k) {
        double sum[SIDES / 2], change[SIDES / 2];
        for (size_t n = 0; n != SIDES / 2; ++n) {
            const double a = work->k[2 * n][NQ + k], b = work->k[2 * n + 1][NQ + k];
            sum[n] = 0.5 * (a + b);
            change[n] = 0.5 * (a - b);
        }
        const double further = sum[2] - sum[1], least = EVEN_SLOPE * fabs(change[1]);
        const double even = 0.5 * fabs((sum[1] - sum[0]) - further / FAR_BY_ROUNDING);
        const double odd = fabs(change[0] - change[1] / FAR_BY_ROUNDING);
        work->u[k] = even > larger(least, EVEN_KINK * fabs(further)) ? even : 0.0;
        if (!swings && odd > least) work->u[k] += odd;
    }
    return size_of(work->u);
}

/* notes what rounding changes by that where a step towards an end ends that began at a time: where
 * it began so steep, too, not where it came to such a place or passed it */
static void note_steepness(double start, double end, State *s, Work *work)
{
    const double before = s->steepness;
    s->steepness = change_by_rounding(end, s, work);
    if (!(smaller(before, s->steepness) > 0.0)) return;
    s->impulse += (s->time - start) * smaller(before, s->steepness);
    s->impulse_time = s->time;
}

/* goes over the switch that a step has come to, and finds the next one. Formulas of each side hold
 * on that side; nothing moves in between. The run ends at the switch if the law of a driver bends
 * or jumps there, or a driven distance becomes zero */
static int meet_switches(double end, State *s, Work *work)
{
    while (s->time < end && !(s->time < s->limit)) {
        if (s->behind > s->time) {
            const double span = larger(fabs(s->time), fabs(end));
            const size_t lost = lost_gap(s->limit, s->behind, work->w);
            if (lost > 0) {
                s->bent = (double)lost;
                return NO_DIRECTION;
            }
            const size_t bent = bent_law(s->limit, s->behind, span, work->w);
            if (bent > 0) {
                s->bent = (double)bent;
                return BENDS;
            }
            memcpy(s->y_before, s->y, NY * sizeof *s->y);
            memset(s->dense, 0, sizeof s->dense);
            s->time_before = s->time;
            const double acceleration = size_of(s->f + NQ);
            s->time = s->switched = smaller(s->behind, end);
            if (!is_put_behind(span, s, work)) return NOT_PROJECTED;
            note_impulse(s->time_before, acceleration, s, work);
        } else {
            find_switch(end, s, work);
            if (s->limit - s->time <= SMALLEST * larger(fabs(s->time), fabs(end))) {
                s->limit = s->time; /* too near for a step */
            }
        }
    }
    return GOOD;
}

/* where a step of length h towards an end ends: half-way from a switch to the next. Of equal steps
 * none is nearly all of the way, where estimates of errors can be blind alike on each such way */
static double even_end(double h, double end, const State *s)
{
    const double way = end - s->time;
    const int is_between = s->time == s->switched && end == s->limit;
    return is_between && h < way && way < 2.0 * h ? s->time + 0.5 * way : end;
}

/* how well samples of an interval tell how parts vary with time. What is not constant is not
 * steady: bounds that are loose beside a place where a quotient is 0/0 would lead steps there */
static int sampling_in(double tolerance, double first, double last, double *w)
{
    VariationBounds variations[ROOM(N_FEATURES)];
    const double h = (last - first) / PIECES, *features = w + W_FEATURES;
    int is_coarse = 0;
    bounds_between(first, first, w);
    for (size_t k = 0; k != N_FEATURES; ++k) begin_variation(features[4 * k], &variations[k]);
    for (int piece = 0; piece != PIECES; ++piece) {
        double bounds[ROOM(4 * N_FEATURES)];
        const double b = first + (piece + 1) * h;
        bounds_between(first + piece * h, b, w);
        for (size_t k = 0; k != 4 * N_FEATURES; ++k) bounds[k] = features[k];
        bounds_between(b, b, w);
        for (size_t k = 0; k != N_FEATURES; ++k) {
            add_cell(h, features[4 * k], bounds + 4 * k, &variations[k]);
        }
    }
    for (size_t k = 0; k != N_FEATURES; ++k) {
        const double size = larger(-variations[k].least, variations[k].most);
        const double nothing = negligible_variation(
            size, feature_scales[k], tolerance, first, last);
        const int sampling = sampling_of(&variations[k], 0.0, 0, nothing);
        if (sampling == UNRESOLVED) return UNRESOLVED;
        is_coarse = is_coarse || sampling == COARSE;
    }
    return is_coarse ? COARSE : RESOLVED;
}

/* where a step of length h must end, at most at an end: no longer than a part of the intervals that
 * are resolved, unless it ends before such a one; what keeps steps short for long, such as a
 * quotient that is 0/0 somewhere, is gone over and counted, and so is what takes too many intervals
 */
static double resolved_step(
    double tolerance, double h, double part, double end, State *s, Work *work)
{
    if (N_FEATURES == 0) return end;
    const double start = s->time, whole = smaller(h, end - start);
    s->longest = larger(FORGETTING * s->longest, smaller(whole, GROWTH * s->stride));
    const double last_step = start - s->time_before;
    const int is_tired = s->short_steps > MOST_SHORT && last_step < LONG * s->longest;
    double first = start, allowed = whole, width = whole / part;
    size_t n = 0;
    for (; n != MOST_INTERVALS; ++n) {
        const double last = first + width;
        const int good = sampling_in(tolerance, first, last, work->w) != UNRESOLVED;
        if (!good && width > FINEST * whole) {
            width = 0.5 * width;
            continue;
        }
        if (good) allowed = smaller(allowed, larger(first - start, part * width));
        first = last;
        if (!(first < start + allowed)) break;
        width = 2.0 * width;
    }
    if (n == MOST_INTERVALS || (is_tired && allowed < whole)) note_unresolved(start, s);
    if (is_tired) return end;
    if (!(allowed < SHORT * s->longest)) s->short_steps = 0;
    else if (allowed < whole) s->short_steps += 1; /* others are short by their error */
    if (!(allowed < whole)) return end;
    /* in equal steps: what is left of the way must be none too short */
    return start + whole / ceil(whole / allowed);
}
