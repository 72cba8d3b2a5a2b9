/* Crossing: steps end where events are and where formulas of the state have a kink or a jump. *
 * This is event location: a step that was tried is searched before it is kept. Its polynomial, the
 * dense output, gives at some times what formulas read: coordinates, lengths of springs, their
 * rates. Bounds of these between the times bound the functions and their rates, as of switching
 * functions of time. Values that are nearer to zero than the error of a step count as zero: a
 * function crosses when it is beyond on the other side. Where bounds show that one crosses once,
 * its time is bisected. Then the step is made again, to end there. Parts of formulas that vary with
 * the state beyond polynomials are bounded likewise: where samples do not show how, the step is
 * made shorter. */

/* smallest step, relative to the time, and rounding of values, relative to their size */
#define SMALLEST 1e-15
/* a step, or an interval of one, that comes within 1e-7 of its length to the last time ends there:
 * no sliver is left */
#define STRETCH_TO_END 1.0000001
/* shortest step to a cut, and shortest first trial of a step, in smallest steps */
#define ONWARD 8.0
/* smallest number of intervals in which a step is searched */
#define CELLS 4
/* largest number of intervals that are looked at in one search */
#define MOST_NODES 512
/* second derivatives of what formulas read are taken to lie within this many times their rise in
 * the cubic polynomial, above and below their mean */
#define DOUBT 2.0
/* samples resolve a part if the sum over all cells of the width of its rate bounds, times the
 * length of the cell, is at most this many times the range of the samples */
#define EXPLAINED 2.0
/* where formulas switch and an error is known, samples also resolve a part if the sum over all
 * cells of the width of its value bounds is at most this many times their range: a hill between two
 * samples goes up and down, and would make it twice */
#define SHOWN 1.5
/* samples are few for a part if the sum that EXPLAINED bounds is more than this many times their
 * range */
#define SMOOTH 0.25
/* negligible variation of a part, relative to its size */
#define NEGLIGIBLE_VARIATION 1e-12
/* negligible variation of a force: it moves the lightest body by this part of the tolerance, in
 * lengths of the scene */
#define NEGLIGIBLE_MOTION 1e-3
/* a part needs no samples in an interval where its bounds differ by less than this part of its
 * size */
#define STEADY 0.5
/* bounds count as evenly loose if no cell has more than this part of all by which they exceed the
 * change of samples: a hill between two samples makes one cell stand out */
#define UNEVEN 0.35
/* shortest interval in which the variation of a part is looked at, relative to the step: narrower
 * ones have no bounds */
#define FINEST 1e-9
/* largest distance of an event that is located again from the cut, relative to the step */
#define SMALL 1e-3
/* ratio of two distances from a crossing at which a function is compared */
#define FURTHER 8.0
/* a function passes zero if it is at least this many times as large at the larger of these
 * distances; one that jumps there, or is infinite, is not */
#define LARGER_THERE 1.5
/* smallest of these distances, in roundings of the time */
#define ROUNDINGS 64.0
/* a step ends where a function that was near to zero takes a side, if that is within this part of
 * the step */
#define SOON 0.1
/* loosest tolerance to which values are known in a search, and loosest tolerance of steps from a
 * switch to the next: forces that switch again soon are narrow, and estimates are blind to what
 * acts for a stage or two. It also applies to each step from a kink where no force jumps: friction
 * that holds switches all the time */
#define LOOSEST_AT_SWITCH 1e-5
/* speed that is added to rates to scale their errors, in lengths of the scene or radians over the
 * longest step so far: in a short step the rates of what moves are no better known, and no worse */
#define SLOW 1e-4
/* a part of a force is infinite at a place if it grows by more than this factor each time one comes
 * FURTHER times nearer: 1/x grows by FURTHER */
#define STEEP 7.0
/* two such growth factors in succession differ by at most this ratio where a part is infinite */
#define EVENLY 1.5
/* a step that leads over a pole of a force is made again, over this part of the way to the pole */
#define CLOSER 0.9
/* a run ends where the way to a pole is at most this part of its longest step. An event that is
 * back at zero within this part of it may have been thrown back */
#define NO_WAY 1e-6
/* a function is near to zero at a node where it is less than this many times its noise; the noise
 * at other nodes tells nothing of how near it comes to zero between them */
#define BANDS 16.0
/* time of a look back at an event that is back at zero, in units of the time since it passed zero:
 * one that has gone evenly through a narrow window was outside of it then */
#define EARLIER 1.5
/* times of a second look back and of one ahead, in the same unit: such an event was in the window
 * then, and will be outside again */
#define HALF 0.5
/* a zero is transversal if at its speed the value leaves this many times its noise, within the
 * longest step so far and before it comes to rest; the same holds for a rate, which changes as fast
 * as it does. Such values are known to rounding */
#define PASSING 16.0
/* a stage with weight at the end of a step is searched for a contact if its accelerations change
 * speeds by more than this part in the step: for less the error tells enough */
#define PUSHED 0.1

enum {
    N_SWITCHING = N_CROSSINGS - N_POLES, /* events, and where formulas switch */
    N_BOUNDED = N_CROSSINGS + N_NARROW,
    N_FUNCTIONS = N_BOUNDED + N_INFINITE,
    N_SEARCHED = N_FUNCTIONS + N_DISTANCES,
    N_READ = 2 * N_MEASURES,
    /* one behind the other */
    W_FUNCTIONS = N_SWITCHING > N_BREAKS ? W_CROSSINGS
    : N_BREAKS > 0                       ? W_BREAKS
    : N_POLES > 0                        ? W_POLES
                                         : W_NARROW
};

/* notes a step from a time on over which bounds do not tell how formulas vary */
static void note_unresolved(double time, State *s)
{
    s->unresolved += 1;
    s->unresolved_time = time;
}

/* a node of the search, at a time of a step */
typedef struct {
    double time;                                              /* when [s] */
    double read[ROOM(N_READ)];                                /* what formulas read, and its rate */
    double least[ROOM(N_FUNCTIONS)], most[ROOM(N_FUNCTIONS)]; /* bounds of each function */
} TimeNode;

/* the search for crossings in a step, whose polynomial is in the state */
typedef struct {
    /* time at which the step was cut [s] */
    double cut;
    /* how it was made: its method, start and length [s] */
    const Method *m;
    double start, h;
    /* earliest part of the step at which it may be cut */
    double least_part;
    double tolerance; /* of the run */
    /* time within which crossings count as one [s] */
    double slack;
    /* errors of each number that is read and of its rate: in the motion, and in its polynomial */
    double noise[ROOM(N_READ)], rounding[ROOM(N_READ)];
    /* sizes of the terms that each number read is made of: its rounding is relative to these,
     * however small the number is */
    double sizes[ROOM(N_MEASURES)];
    /* second derivatives of what is read: their mean, rise above it at the end, and bound */
    double second_mean[ROOM(N_MEASURES)];
    double second_rise[ROOM(N_MEASURES)];
    double second_bound[ROOM(N_MEASURES)];
    /* errors of rates by which it is decided whether they pass by: at most what rates have been */
    double rate_noise[ROOM(N_MEASURES)];
    /* whether each function crosses in the step, and crossed where the step was cut */
    int crosses[ROOM(N_FUNCTIONS)], was_crossing[ROOM(N_FUNCTIONS)];
    /* whether each event has been noted by an earlier step that ended a little before its zero */
    int is_short[ROOM(N_FUNCTIONS)];
    /* whether samples do not resolve how parts vary with the state somewhere in the step */
    int is_unresolved;
    /* whether samples are few for how such a part varies in the step */
    int is_coarse;
    /* whether formulas switch and the error decides how long the step is */
    int has_error;
    /* whether the error of the step is within the tolerance */
    int is_kept;
    /* 1-based index of the event without a value right behind the start; 0: none */
    int undefined;
    /* 1-based index of the function that is zero where a force is infinite, 0: none; its time
     * [s] */
    int pole;
    double pole_time;
    /* number of times that the step was cut for distances and jumps; end of the last such cut, and
     * the time of the distance or jump that it was made for [s] */
    int place_cuts;
    double place_cut, place;
    /* whether a step to this cut only leads over the distance or jump */
    int is_over;
    /* upper bounds of the first crossing of each function at which a force jumps, or infinite
     * [s] */
    double breaks[ROOM(N_BREAKS)];
} Search;

/* whether what is a at the start of h and b at its end is positive between: no less than lines from
 * both ends as steep as it falls and rises at most */
static int stays_positive(double a, double b, double falls, double rises, double h)
{
    return a * rises - b * falls + falls * rises * h > 0.0;
}

/* what formulas read of y at a time */
static void read_of(double time, const double *y, Work *work, double *read)
{
    place(time, y, work->w);
    measure(work->w);
    memcpy(read, work->w + W_MEASURES, N_READ * sizeof *read);
}

/* what formulas read at a time */
static void read_at(double time, const Search *search, const State *s, Work *work, double *read)
{
    interpolate(search->m, (time - search->start) / search->h, s, work->scratch);
    read_of(time, work->scratch, work, read);
}

/* the bounds of a node at a time where formulas read what it has, known to a noise */
static void evaluate_node(const double *noise, double time, double *w, TimeNode *node)
{
    double *ranges = w + W_RANGES;
    node->time = ranges[0] = ranges[1] = time;
    for (size_t k = 0; k != N_MEASURES; ++k) {
        double *own = ranges + 2 + 6 * k;
        for (size_t n = 0; n != 2; ++n) {
            own[2 * n] = node->read[2 * k + n] - noise[2 * k + n];
            own[2 * n + 1] = node->read[2 * k + n] + noise[2 * k + n];
        }
        own[4] = own[5] = 0.0;
    }
    crossing(w);
    for (size_t k = 0; k != N_FUNCTIONS; ++k) {
        node->least[k] = w[W_FUNCTIONS + 4 * k];
        node->most[k] = w[W_FUNCTIONS + 4 * k + 1];
    }
}

/* the node at a time, where values are known to a given noise */
static void node_with_noise(const double *noise, double time, const Search *search, const State *s,
    Work *work, TimeNode *node)
{
    read_at(time, search, s, work, node->read);
    evaluate_node(noise, time, work->w, node);
}

/* on which side of zero a function is, 0 where that is not known */
static int side_at(const TimeNode *node, size_t k)
{
    return (node->least[k] > 0.0) - (node->most[k] < 0.0);
}

/* the size of a second derivative at a time of a step, but for what rounding makes of it */
static double second_at(size_t k, double time, const Search *search)
{
    const double part = (time - search->start) / search->h, h = search->h;
    const double change = fabs(
        search->second_mean[k] + (2.0 * part - 1.0) * search->second_rise[k]);
    return change - 2.0 * search->rounding[2 * k + 1] / h;
}

/* whether a value of such a speed and bound of acceleration gets far beyond its noise */
static int passes_by(
    double speed, double acceleration, double noise, const Search *search, const State *s)
{
    const double far = PASSING * noise;
    return speed * larger(s->stride, search->h) > far && speed * speed > far * acceleration;
}

/* what values that formulas read at a time are known to: what passes by there to rounding */
static void noise_at(
    double time, const double *read, const Search *search, const State *s, double *noise)
{
    memcpy(noise, search->noise, sizeof search->noise);
    for (size_t k = 0; k != N_MEASURES; ++k) {
        const double speed = fabs(read[2 * k + 1]), change = second_at(k, time, search);
        const double third = 2.0 * fabs(search->second_rise[k]) / search->h;
        if (passes_by(speed, search->second_bound[k], noise[2 * k], search, s))
            noise[2 * k] = search->rounding[2 * k];
        if (passes_by(change, third, search->rate_noise[k], search, s))
            noise[2 * k + 1] = search->rounding[2 * k + 1];
    }
}

/* the node at a time of the motion. Values and rates that pass by are taken from the polynomial,
 * with its rounding, however far off it may be, so that nothing narrower than the noise is passed
 * over. All others have the noise, and so have all where a force may be infinite */
static void node_at(double time, const Search *search, const State *s, Work *work, TimeNode *node)
{
    double noise[ROOM(N_READ)];
    read_at(time, search, s, work, node->read);
    if (N_POLES > 0) evaluate_node(search->noise, time, work->w, node);
    for (size_t k = N_SWITCHING; k != N_CROSSINGS; ++k) {
        if (side_at(node, k) == 0) return;
    }
    noise_at(time, node->read, search, s, noise);
    evaluate_node(noise, time, work->w, node);
}

/* time of a stage, from a first one on, beyond a switch that its polynomial does not meet. Such a
 * stage is in a contact that the step leads over: the force there makes the polynomial useless. If
 * there is none, it is the time up to which the step is seen. A stage with weight at the end of the
 * step, where the error tells of it, counts only if it changes speeds; and no such stage counts
 * beyond a jump, which throws back what passes it a little */
static double stage_beyond(
    size_t first, double seen, const Search *search, const State *s, Work *work)
{
    const Method *m = search->m;
    const double slow = PUSHED * size_of(s->y + NQ);
    TimeNode node;
    for (size_t n = first; n < m->all; ++n) {
        const size_t last = n > m->stages ? N_SWITCHING : N_SWITCHING - N_BREAKS;
        const double time = search->start + m->c[n] * search->h;
        if (!(time < seen)) continue;
        if (n <= m->stages && search->h * size_of(work->k[n] + NQ) <= slow) continue;
        combine(n, m->a + n * (n - 1) / 2, s->y, search->h, work->k, work->scratch);
        read_of(time, work->scratch, work, node.read);
        evaluate_node(search->noise, time, work->w, &node);
        for (size_t k = EVENTS; k < last; ++k) {
            if (s->sides[k] != 0.0 && side_at(&node, k) == -(int)s->sides[k]) return time;
        }
    }
    return seen;
}

/* by how much a second derivative at the end of h is above its mean, as that of a cubic polynomial
 * that value and rate at both ends tell, but for rounding */
static double second_rise_of(double size, const double *a, const double *b, double h)
{
    const double rounding = 6.0 * SMALLEST * (size + fabs(a[0]) + fabs(b[0])) / h;
    const double off = 3.0 * (a[1] + b[1]) - 6.0 * (b[0] - a[0]) / h;
    return copysign(larger(0.0, fabs(off) - rounding) / h, off);
}

/* makes the polynomial of a step from the state to y, whose rates at both ends are given */
static void begin_search(const Settings *settings, const Method *m, int has_stages, double h,
    const double *y, const double *f_before, const double *f, Search *search, State *s, Work *work)
{
    double first[ROOM(N_READ)], last[ROOM(N_READ)];
    search->m = m;
    search->start = s->time;
    search->h = h;
    search->tolerance = settings->tolerance;
    search->slack = settings->tolerance * h;
    search->is_unresolved = 0;
    for (size_t k = 0; k != N_BREAKS; ++k) search->breaks[k] = HUGE_VAL;
    memcpy(s->y_before, s->y, NY * sizeof *s->y);
    memset(s->dense, 0, sizeof s->dense);
    hermite_cubic(h, y, f_before, f, s);
    if (has_stages) add_dense_rows(m, h, s, work);
    read_at(s->time, search, s, work, first);
    read_at(s->time + h, search, s, work, last);
    const double away = scale_by_distance(s->y); /* y may be thrown off */
    for (size_t k = 0; k != N_MEASURES; ++k) {
        const double size = measure_sizes[k], *a = first + 2 * k, *b = last + 2 * k;
        const double most = larger(fabs(a[0]), fabs(b[0]));
        const double known = smaller(settings->tolerance, LOOSEST_AT_SWITCH) * size +
                             SMALLEST * most;
        search->sizes[k] = size * away;
        search->rounding[2 * k] = SMALLEST * (search->sizes[k] + most);
        search->noise[2 * k] = larger(known, search->rounding[2 * k]);
        const double speed = larger(fabs(a[1]), fabs(b[1])), longest = larger(s->stride, h);
        const double fast = speed + SLOW * size / longest;
        search->noise[2 * k + 1] = settings->tolerance * fast;
        search->rate_noise[k] = smaller(search->noise[2 * k + 1], speed + size * s->fastest);
        search->second_mean[k] = (b[1] - a[1]) / h;
        search->second_rise[k] = second_rise_of(search->sizes[k], a, b, h);
        search->second_bound[k] = fabs(search->second_mean[k]) + fabs(search->second_rise[k]);
        search->rounding[2 * k + 1] = SMALLEST * fast;
    }
}

/* the least and the most between values a and b at the ends of h, where a slope is bounded */
static void reach_between(
    double a, double b, double slowest, double fastest, double h, double *range)
{
    range[0] = smaller(a, b);
    range[1] = larger(a, b);
    if (!(slowest < 0.0 && fastest > 0.0)) return;
    const double all = fastest - slowest, curve = slowest * fastest * h;
    range[0] = smaller(range[0], (fastest * a - slowest * b + curve) / all);
    range[1] = larger(range[1], (fastest * b - slowest * a - curve) / all);
}

/* bounds of the functions between two times, to the workspace */
static void bound_functions(const TimeNode *a, const TimeNode *b, const Search *search, double *w)
{
    const double h = b->time - a->time;
    double *ranges = w + W_RANGES;
    ranges[0] = a->time;
    ranges[1] = b->time;
    for (size_t k = 0; k != N_MEASURES; ++k) {
        const double *p = a->read + 2 * k, *q = b->read + 2 * k;
        double *own = ranges + 2 + 6 * k;
        const double mean = (q[1] - p[1]) / h;
        const double rise = fabs(second_rise_of(search->sizes[k], p, q, h));
        own[4] = mean - DOUBT * rise;
        own[5] = mean + DOUBT * rise;
        reach_between(p[1], q[1], own[4], own[5], h, own + 2);
        reach_between(p[0], q[0], own[2], own[3], h, own);
    }
    crossing(w);
}

static double middle(const TimeNode *node, size_t k)
{
    return 0.5 * (node->least[k] + node->most[k]);
}

static double half_width(const TimeNode *node, size_t k)
{
    return 0.5 * (node->most[k] - node->least[k]);
}

/* whether an event that a step starts short of is no further from zero than the noise. An earlier
 * step ended for this event and noted it: it does not cross back */
static int is_still_short(
    size_t k, int side, double time, const Search *search, const State *s, Work *work)
{
    TimeNode known;
    if (!search->is_short[k]) return 0;
    node_with_noise(search->noise, time, search, s, work, &known);
    return side_at(&known, k) != -side;
}

/* half width of a function at a node, by the noise of an event that a step starts short of */
static double band_at(
    size_t k, const TimeNode *node, const Search *search, const State *s, Work *work)
{
    TimeNode known;
    if (!search->is_short[k]) return half_width(node, k);
    node_with_noise(search->noise, node->time, search, s, work, &known);
    return half_width(&known, k);
}

/* root isolation: whether a function that was on a side crosses between two nodes as often as their
 * sides tell, and not oftener; its bounds are in the workspace */
static int is_isolated(size_t k, int side, const TimeNode *a, const TimeNode *b,
    const double *bounds, const Search *search, const State *s, Work *work)
{
    const double sign = side < 0 ? -1.0 : 1.0;
    const double least = side < 0 ? -bounds[1] : bounds[0];
    const double falls = side < 0 ? -bounds[3] : bounds[2];
    const double rises = side < 0 ? -bounds[2] : bounds[3];
    const double band_a = band_at(k, a, search, s, work), band_b = band_at(k, b, search, s, work);
    const double first = sign * middle(a, k), last = sign * middle(b, k);
    const double near_a = side == 0 || first < BANDS * band_a ? band_a : 0.0;
    const double near_b = side == 0 || last < BANDS * band_b ? band_b : 0.0;
    const double within = larger(near_a, near_b);
    const int is_beyond = side != 0 && side_at(b, k) == -side;
    if (is_beyond && !is_still_short(k, side, b->time, search, s, work)) return rises <= 0.0;
    if (least > -within || falls >= 0.0 || rises <= 0.0) return 1;
    if (side == 0) return bounds[1] < within;
    return stays_positive(first + within, last + within, falls, rises, b->time - a->time);
}

/* whether a function has a value at a node */
static int has_value(const TimeNode *node, size_t k)
{
    return !isnan(node->least[k]) && !isnan(node->most[k]);
}

/* the first event without a finite value at the state, counted from 1, 0 where all have one */
static int first_without_value(const State *s, Work *work)
{
    const double exact[ROOM(N_READ)] = { 0.0 };
    TimeNode node;
    if (EVENTS == 0) return 0;
    read_of(s->time, s->y, work, node.read);
    evaluate_node(exact, s->time, work->w, &node);
    for (size_t k = 0; k != EVENTS; ++k) {
        if (!(isfinite(node.least[k]) && isfinite(node.most[k]))) return (int)k + 1;
    }
    return 0;
}

/* whether a function has no value at a time, nor right behind it, where one has that is 0/0 there
 */
static int is_undefined(size_t k, double time, const Search *search, const State *s, Work *work)
{
    const double exact[ROOM(N_READ)] = { 0.0 };
    const double onward = ROUNDINGS * SMALLEST * larger(fabs(time), search->h);
    TimeNode node;
    node_with_noise(exact, time, search, s, work, &node);
    if (has_value(&node, k)) return 0;
    node_with_noise(exact, time + onward, search, s, work, &node);
    return !has_value(&node, k);
}

/* the last time between two nodes at which all events have a value that have none at the second:
 * the first that has none behind it is noted. Infinite where there is none */
static double domain_end(
    const TimeNode *a, const TimeNode *b, Search *search, const State *s, Work *work)
{
    const double exact[ROOM(N_READ)] = { 0.0 };
    double end = HUGE_VAL;
    TimeNode node;
    search->undefined = 0;
    for (size_t k = 0; k != EVENTS; ++k) {
        if (has_value(b, k) || !is_undefined(k, b->time, search, s, work)) continue;
        double first = a->time, last = b->time;
        while (last - first > SMALLEST * larger(fabs(first), fabs(last))) {
            const double time = 0.5 * (first + last);
            if (!(first < time && time < last)) break;
            node_with_noise(exact, time, search, s, work, &node);
            if (has_value(&node, k)) first = time;
            else last = time;
        }
        if (first < end) {
            end = first;
            search->undefined = (int)k + 1;
        }
    }
    return end;
}

/* noise of values and rates with which the zero of a function is located. Events, and functions at
 * whose zero a force is infinite, are located by the polynomial, with its rounding; the others are
 * known to the noise of the motion */
static const double *noise_of(size_t k, const Search *search)
{
    return (int)k < EVENTS || (int)k >= N_SWITCHING ? search->rounding : search->noise;
}

/* the first time between two nodes at which a function that crosses does. An event is zero at this
 * time; any other function is beyond zero, so that all that follows is on the other side */
static double time_of(size_t k, const TimeNode *a, const TimeNode *b, const Search *search,
    const State *s, Work *work)
{
    const int side = -side_at(b, k);
    double first = a->time, last = b->time, there[ROOM(N_READ)], noise[ROOM(N_READ)];
    TimeNode node;
    memcpy(noise, noise_of(k, search), sizeof noise);
    noise_at(last, b->read, search, s, there);
    /* rates may be in a window that is narrower */
    for (size_t n = 0; n != N_MEASURES; ++n) {
        if ((int)k >= EVENTS && (int)k < N_SWITCHING) noise[2 * n + 1] = there[2 * n + 1];
    }
    /* by the polynomial it is beyond zero, by less than that */
    node_with_noise(noise, last, search, s, work, &node);
    if (side_at(&node, k) != -side) memcpy(noise, search->rounding, sizeof noise);
    while (last - first > SMALLEST * larger(fabs(first), fabs(last))) {
        const double time = 0.5 * (first + last);
        if (!(first < time && time < last)) break;
        node_with_noise(noise, time, search, s, work, &node);
        const int is_behind = (int)k < EVENTS ? side * middle(&node, k) <= 0.0
                                              : side_at(&node, k) == -side;
        if (is_behind) last = time;
        else first = time;
    }
    return last;
}

/* the first of the functions that cross between two nodes; only those that do so there are left.
 * What is behind the end of the run does not count, however near it is */
static double first_time(
    const TimeNode *a, const TimeNode *b, Search *search, const State *s, Work *work)
{
    double times[ROOM(N_CROSSINGS)], first = b->time;
    for (size_t k = 0; k != N_CROSSINGS; ++k) {
        if (!search->crosses[k]) continue;
        times[k] = time_of(k, a, b, search, s, work);
        first = smaller(first, times[k]);
    }
    double together = first + search->slack;
    for (size_t k = 0; k != EVENTS; ++k) {
        if (search->crosses[k] && events[k][1] == STOP && times[k] <= first + search->slack) {
            together = first + 4.0 * SMALLEST * fabs(first);
        }
    }
    for (size_t k = 0; k != N_CROSSINGS; ++k) {
        search->crosses[k] = search->crosses[k] && times[k] <= together;
    }
    return first;
}

/* whether a step begins where a function that has crossed is on the side that it left. A step may
 * end so, within its errors. Formulas are then those of the side that was left, and the error
 * estimate of a method can be blind to its first stage */
static int is_short_of(
    size_t k, const TimeNode *a, const Search *search, const State *s, Work *work)
{
    TimeNode node;
    if (a->time != search->start) return 0;
    node_with_noise(search->rounding, a->time, search, s, work, &node);
    return side_at(&node, k) != (int)s->sides[k];
}

/* first time at which a function that was near to zero, but no event, is on a side. Values of
 * formulas at zero, where they may jump, tell nothing of what follows; values near to zero on the
 * side that is taken do */
static double first_departure(
    const TimeNode *a, const TimeNode *b, const Search *search, const State *s, Work *work)
{
    double first = HUGE_VAL;
    for (size_t k = EVENTS; (int)k < N_SWITCHING; ++k) {
        const int now = side_at(b, k);
        if (now == 0 || now * middle(a, k) > 0.0) continue;
        if (s->sides[k] != 0.0 && (s->sides[k] != now || !is_short_of(k, a, search, s, work))) {
            continue;
        }
        first = smaller(first, time_of(k, a, b, search, s, work));
    }
    return first;
}

/* the node that far from a time where formulas read this, and go on evenly */
static void node_beside(double way, double time, const double *read, const double *noise,
    const Search *search, Work *work, TimeNode *node)
{
    for (size_t k = 0; k != N_MEASURES; ++k) {
        node->read[2 * k] = read[2 * k] + way * read[2 * k + 1];
        node->read[2 * k + 1] = read[2 * k + 1] + way * search->second_mean[k];
    }
    evaluate_node(noise, time + way, work->w, node);
}

/* how large parts of forces that may be infinite are that far from a time */
static void sizes_beside(
    double way, double time, const double *read, const Search *search, Work *work, double *sizes)
{
    const double exact[ROOM(N_READ)] = { 0.0 };
    TimeNode node;
    node_beside(way, time, read, exact, search, work, &node);
    for (size_t k = 0; k != N_INFINITE; ++k) sizes[k] = fabs(middle(&node, N_BOUNDED + k));
}

/* whether a force is infinite where a function gets on a side of zero at a time. No motion leads
 * through such a place: the force grows as 1/x or faster on a side. A force that is 0/0 there, or
 * jumps, does not grow, and one that grows less, as 1/sqrt(x), has a finite integral */
static int is_infinite(
    size_t k, int side, double time, const Search *search, const State *s, Work *work)
{
    double near[ROOM(N_INFINITE)], there[ROOM(N_INFINITE)], away[ROOM(N_INFINITE)];
    double read[ROOM(N_READ)], far = ROUNDINGS * SMALLEST * larger(fabs(time), search->h);
    int is_pole = 0;
    TimeNode a, b;
    read_at(time, search, s, work, read);
    for (;;) {
        node_beside(-far, time, read, search->rounding, search, work, &a);
        node_beside(far, time, read, search->rounding, search, work, &b);
        if (side_at(&a, k) == -side && side_at(&b, k) == side) break;
        far *= FURTHER;
        if (!(far < s->stride)) return 1; /* rounding hides that */
    }
    for (int n = 0; n != 2; ++n) {
        const double way = n == 0 ? -far : far;
        sizes_beside(FURTHER * FURTHER * way, time, read, search, work, near);
        sizes_beside(FURTHER * FURTHER * FURTHER * way, time, read, search, work, there);
        sizes_beside(FURTHER * FURTHER * FURTHER * FURTHER * way, time, read, search, work, away);
        for (size_t i = 0; i != N_INFINITE; ++i) {
            const double both = near[i] * away[i], square = there[i] * there[i];
            const int grows = near[i] > STEEP * there[i] && there[i] > STEEP * away[i] &&
                              both <= EVENLY * square && square <= EVENLY * both;
            is_pole = is_pole || grows || isinf(near[i]);
        }
    }
    return is_pole;
}

/* finds the first pole of a force between two nodes, but behind nothing else that crosses there,
 * where functions pass zero at which forces may be infinite */
static void find_pole(const int *passes, const TimeNode *a, const TimeNode *b, Search *search,
    const State *s, Work *work)
{
    int crossed[ROOM(N_FUNCTIONS)], any = 0;
    double first = HUGE_VAL;
    memcpy(crossed, search->crosses, sizeof crossed);
    for (size_t k = 0; k != N_CROSSINGS; ++k) any = any || crossed[k];
    if (any) first = first_time(a, b, search, s, work);
    memcpy(search->crosses, crossed, sizeof crossed);
    for (size_t k = 0; k != N_POLES; ++k) {
        const size_t own = N_SWITCHING + k;
        if (!passes[k]) continue;
        const int side = side_at(b, own);
        const double time = side_at(a, own) == side ? a->time : time_of(own, a, b, search, s, work);
        if (time <= first && is_infinite(own, side, time, search, s, work)) {
            first = search->pole_time = time;
            search->pole = (int)k + 1;
        }
    }
}

/* where a step ends before a pole that is seen in it: at its start if that is near */
static double end_before_pole(const Search *search, const State *s)
{
    const double way = search->pole_time - search->start;
    return way > NO_WAY * s->stride ? search->start + CLOSER * way : search->start;
}

/* why a run leads no further, where a step would end there; GOOD where it does */
static int why_stopped(double seen, const Search *search, State *s)
{
    if (search->undefined) {
        s->event = search->undefined;
        return NO_VALUE;
    }
    if (search->pole && !(seen > s->time)) {
        s->pole = search->pole;
        return INFINITE;
    }
    return GOOD;
}

/* notes on which side functions are where a step starts: by the noise that was open. Rates are
 * known to rounding where they pass by, places to the noise. Events, which are looked for until
 * they are exact, and poles stay */
static void note_sides(const TimeNode *a, const Search *search, State *s, Work *work)
{
    double noise[ROOM(N_READ)];
    TimeNode node = *a;
    noise_at(a->time, a->read, search, s, noise);
    for (size_t k = 0; k != N_MEASURES; ++k) noise[2 * k] = search->noise[2 * k];
    evaluate_node(noise, a->time, work->w, &node);
    for (size_t k = EVENTS; (int)k < N_SWITCHING; ++k) {
        const int now = side_at(&node, k);
        if (now == -(int)s->sides[k]) s->sides[k] = now;
    }
}

/* whether a function that was on a side is beyond zero at a node */
static int are_crossed(
    size_t k, int side, const TimeNode *b, const Search *search, const State *s, Work *work)
{
    if (side == 0 || side_at(b, k) != -side) return 0;
    return !is_still_short(k, side, b->time, search, s, work);
}

/* where a step to an end must end: where a function first crosses, or how far was looked */
static double crossing_end(double end, Search *search, State *s, Work *work)
{
    const double tiny = SMALLEST * larger(fabs(search->start), fabs(end));
    const double nearest = search->start + larger(ONWARD * tiny, search->least_part * search->h);
    const double widest = search->h / CELLS;
    const double soon = search->start + larger(ONWARD * tiny, search->slack);
    int passed[ROOM(N_POLES)] = { 0 }, passes[ROOM(N_POLES)] = { 0 };
    double width = widest, bounds[4 * ROOM(N_CROSSINGS)];
    TimeNode a, b;
    search->pole = 0;
    node_at(search->start, search, s, work, &a);
    domain_end(&a, &a, search, s, work);
    if (search->undefined) return end;
    note_sides(&a, search, s, work);
    for (size_t k = 0; k != N_CROSSINGS; ++k) {
        const int side = (int)s->sides[k];
        search->is_short[k] = (int)k < EVENTS && side != 0 && side_at(&a, k) == -side;
    }
    for (size_t n = 0; n != MOST_NODES && a.time < end; ++n) {
        int is_known = 1, any = 0, is_lost = 0, may_be_infinite = 0;
        node_at(a.time + STRETCH_TO_END * width < end ? a.time + width : end, search, s, work, &b);
        for (size_t k = 0; k != N_CROSSINGS; ++k) {
            if (s->sides[k] == 0.0) s->sides[k] = side_at(&a, k);
            const int side = (int)s->sides[k];
            search->crosses[k] = are_crossed(k, side, &b, search, s, work);
            if (N_POLES > 0 && (int)k >= N_SWITCHING) {
                const size_t pole = k - N_SWITCHING;
                const int now = passed[pole] ? -side : side;
                search->crosses[k] = 0;
                passes[pole] = now != 0 && side_at(&b, k) == -now;
                may_be_infinite = may_be_infinite || passes[pole];
            }
            any = any || search->crosses[k];
        }
        const double valued = domain_end(&a, &b, search, s, work);
        if (search->undefined) {
            const double first = any ? first_time(&a, &b, search, s, work) : HUGE_VAL;
            if (first <= valued + search->slack) {
                search->undefined = 0;
                return smaller(larger(first, nearest), end);
            }
            if (search->is_kept && valued <= soon) return end;
            search->undefined = 0;
            /* at the end, where it was cut for that, or by rounding */
            is_lost = end - valued <= (end == search->cut ? SMALL * search->h : ONWARD * tiny);
            if (!is_lost) {
                memset(search->crosses, 0, sizeof search->crosses);
                return smaller(larger(valued, nearest), end);
            }
        }
        bound_functions(&a, &b, search, work->w);
        memcpy(bounds, work->w + W_FUNCTIONS, 4 * N_CROSSINGS * sizeof *bounds);
        for (size_t k = 0; k != N_CROSSINGS; ++k) {
            int side = (int)s->sides[k];
            if (N_POLES > 0 && (int)k >= N_SWITCHING && passed[k - N_SWITCHING]) side = -side;
            if (is_lost && !has_value(&b, k)) continue; /* it ends where that has no value */
            if (!is_isolated(k, side, &a, &b, bounds + 4 * k, search, s, work)) is_known = 0;
        }
        const double left = larger(
            first_departure(&a, &b, search, s, work), search->start + ONWARD * tiny);
        if (left - search->start < SOON * (end - search->start)) {
            memset(search->crosses, 0, sizeof search->crosses);
            return left;
        }
        if (!is_known && b.time - a.time > tiny) {
            width = 0.5 * (b.time - a.time);
            continue;
        }
        if (may_be_infinite && search->is_kept) {
            find_pole(passes, &a, &b, search, s, work);
            if (search->pole) return end;
        }
        for (size_t k = 0; k != N_POLES; ++k) passed[k] = passed[k] != passes[k];
        if (any) {
            for (size_t k = 0; k != N_BREAKS; ++k)
                if (search->crosses[N_SWITCHING - N_BREAKS + k]) search->breaks[k] = b.time;
            return smaller(larger(first_time(&a, &b, search, s, work), nearest), end);
        }
        a = b;
        width = smaller(2.0 * width, widest);
    }
    search->is_unresolved = a.time < end && !(a.time > nearest);
    return a.time < end && a.time > nearest ? a.time : end;
}

/* cuts a step where it must end, and remembers what crosses there */
static double cut_at(double end, Search *search)
{
    memcpy(search->was_crossing, search->crosses, sizeof search->crosses);
    search->cut = end;
    return end;
}

/* difference of a function from one side of a time to the other, so far away. Both values are in
 * the polynomial, or beyond it. The difference is 0 where they are not surely on different sides of
 * zero, and negative where the function goes to the opposite side */
static double gap_across(size_t k, int side, double time, double far, int is_beyond,
    const Search *search, const State *s, Work *work)
{
    double read[ROOM(N_READ)];
    TimeNode a, b;
    if (is_beyond) {
        read_at(time, search, s, work, read);
        node_beside(-far, time, read, search->rounding, search, work, &a);
        node_beside(far, time, read, search->rounding, search, work, &b);
    } else {
        node_with_noise(search->rounding, time - far, search, s, work, &a);
        node_with_noise(search->rounding, time + far, search, s, work, &b);
    }
    if (side_at(&a, k) != -side || side_at(&b, k) != side)
        return side_at(&a, k) == side && side_at(&b, k) == -side ? -1.0 : 0.0;
    return side > 0 ? b.least[k] - a.most[k] : a.least[k] - b.most[k];
}

/* whether an event that gets on a side of zero in a step to an end is zero there. Else it jumps, or
 * goes through infinity: right beside the place it is then as large as further away, or larger.
 * Where rounding hides the difference it counts as zero. Distances may exceed a short step, beyond
 * which its polynomial tells nothing: values and rates at its end are then continued. If the event
 * goes to the opposite side, rounding brought it back over a jump that was passed */
static int passes_zero(
    size_t k, int side, double end, const Search *search, const State *s, Work *work)
{
    double first = search->start, last = end;
    TimeNode node;
    if (!events[k][2]) return 1;
    node_with_noise(search->rounding, end, search, s, work, &node);
    if (side_at(&node, k) != side) last = end + SMALL * search->h;
    while (last - first > SMALLEST * larger(fabs(first), fabs(last))) {
        const double time = 0.5 * (first + last);
        if (!(first < time && time < last)) break;
        node_with_noise(search->rounding, time, search, s, work, &node);
        if (side_at(&node, k) == side) last = time;
        else first = time;
    }
    double far = ROUNDINGS * SMALLEST * larger(fabs(last), search->h);
    for (; far < larger(search->h, s->stride) / FURTHER; far *= FURTHER) {
        const int is_beyond = !(far < search->h / FURTHER);
        const double gap = gap_across(k, side, last, far, is_beyond, search, s, work);
        if (gap == 0.0) continue;
        far *= FURTHER;
        return gap > 0.0 &&
               gap_across(k, side, last, far, is_beyond, search, s, work) >= LARGER_THERE * gap;
    }
    return 1;
}

/* where an event is that a step was cut for, by the polynomial of the step that ends near it */
static double polished_cut(const Search *search, const State *s, Work *work)
{
    const double most = SMALL * search->h;
    for (size_t k = 0; k != EVENTS; ++k) {
        if (!search->was_crossing[k]) continue;
        if (!passes_zero(k, -(int)s->sides[k], search->cut, search, s, work)) continue;
        double before = search->cut - most, there = search->cut;
        TimeNode a, b;
        const double *noise = noise_of(k, search);
        node_with_noise(noise, before, search, s, work, &a);
        node_with_noise(noise, there, search, s, work, &b);
        for (int n = 0; n != 4 && middle(&a, k) != middle(&b, k); ++n) {
            const double slope = (middle(&b, k) - middle(&a, k)) / (there - before);
            const double time = there - middle(&b, k) / slope;
            if (!(fabs(time - search->cut) <= most) || time == there) break;
            a = b;
            before = there;
            there = time;
            node_with_noise(noise, there, search, s, work, &b);
        }
        return there;
    }
    return search->cut;
}

/* whether an event that passed zero is back there, where a jump of a force threw it back. Dry
 * friction that holds a body at rest does that all the time. It is so if nothing has moved since
 * the event passed zero by more than its noise, unless the event goes evenly through a narrow
 * window: then it was on the side that it leaves half of this time ago, and is on the other one
 * before and soon. An event that was held once is not asked again */
static int is_thrown_back(size_t k, double end, const Search *search, State *s, Work *work)
{
    const double way = end - s->crossed[k];
    double read[ROOM(N_READ)];
    TimeNode node;
    int is_there = N_MEASURES > 0 && way <= NO_WAY * s->stride;
    read_at(end, search, s, work, read);
    for (size_t n = 0; n != N_MEASURES; ++n) {
        const double known = search->noise[2 * n];
        if (!(fabs(read[2 * n + 1]) * way <= known)) is_there = 0;
        if (!(fabs(search->second_mean[n]) * way <= known * s->fastest)) is_there = 0;
    }
    if (!is_there) {
        s->held[k] = 0.0;
    } else if (s->held[k] == 0.0) {
        const double beside[3] = { -EARLIER * way, -HALF * way, HALF * way };
        for (int n = 0; n != 3; ++n) {
            node_beside(beside[n], end, read, search->rounding, search, work, &node);
            const int side = n == 1 ? (int)s->sides[k] : -(int)s->sides[k];
            if (side_at(&node, k) != side) s->held[k] = 1.0;
        }
    }
    return s->held[k] > 0.0;
}

/* notes what a step that is kept has crossed: one that was cut, also what is at zero there */
static void note_crossings(double end, const Search *search, State *s, Work *work)
{
    TimeNode last, known;
    node_at(end, search, s, work, &last);
    node_with_noise(search->noise, end, search, s, work, &known);
    for (size_t k = 0; k != N_CROSSINGS; ++k) {
        const int side = (int)s->sides[k], now = side_at(&last, k);
        const int is_near = now == 0 || side_at(&known, k) == 0;
        const int is_there = is_near && end == search->cut && search->was_crossing[k];
        const int is_back = now == -side && !is_still_short(k, side, end, search, s, work);
        if (side == 0 || !(is_back || is_there)) continue;
        const int is_same = (int)k < EVENTS && is_thrown_back(k, end, search, s, work);
        s->sides[k] = -side;
        if ((int)k >= EVENTS) continue;
        s->crossed[k] = end;
        if (is_same || (events[k][0] != 0 && events[k][0] != -side)) continue;
        if (!passes_zero(k, -side, end, search, s, work)) continue;
        s->counts[k] += 1.0;
        if (events[k][1] != COUNT) s->fired[k] = 1.0;
    }
}

/* what a part of some size may vary by between two times, in the unit of its formula: a force that
 * acts as long moves a body on meanwhile, and then in as much time as has passed since 0 */
static double negligible_variation(
    double size, const double *scale, double tolerance, double start, double end)
{
    const double span = larger(fabs(start), fabs(end));
    if (scale[1] == 0.0) return NEGLIGIBLE_VARIATION * larger(size, scale[0]);
    return larger(NEGLIGIBLE_VARIATION * size,
        NEGLIGIBLE_MOTION * tolerance * (scale[0] / ((end - start) * span)));
}

/* how a part varies between two times, as samples and bounds of the cells between them tell */
typedef struct {
    double last, least, most;   /* the last sample, the least and largest */
    double low, high;           /* bounds of all cells */
    double reach, change;       /* sums of what bounds let it vary by, and of what rates may */
    double hidden, most_hidden; /* by how much bounds of cells exceed samples: sum, and largest */
} VariationBounds;

/* how well samples tell how parts vary */
enum { UNRESOLVED, COARSE, RESOLVED };

static void begin_variation(double sample, VariationBounds *v)
{
    *v = (VariationBounds){
        .last = sample, .least = sample, .most = sample, .low = sample, .high = sample
    };
}

/* adds a cell of length h: the sample at its end, and bounds of values and rates in it */
static void add_cell(double h, double sample, const double *bounds, VariationBounds *v)
{
    const double width = bounds[1] - bounds[0], hidden = width - fabs(sample - v->last);
    v->least = smaller(sample, v->least);
    v->most = larger(sample, v->most);
    v->low = smaller(bounds[0], v->low);
    v->high = larger(bounds[1], v->high);
    v->reach += width;
    v->change += h * (bounds[3] - bounds[2]);
    v->hidden += hidden;
    v->most_hidden = larger(hidden, v->most_hidden);
    v->last = sample;
}

/* how well samples tell how a part varies, but for what counts as nothing. Samples resolve it in
 * one of three ways: its rate bounds are narrow beside the range of the samples (EXPLAINED); its
 * bounds are steady (STEADY) and no looser in one cell, where a hill may hide, than in the others
 * (UNEVEN); or, where formulas switch and an error is known, its value bounds exceed the samples by
 * little (SHOWN), as of a root, at whose end no rate is bounded */
static int sampling_of(const VariationBounds *v, double steady, int has_error, double nothing)
{
    const double range = v->most - v->least;
    const int is_even = v->most_hidden <= UNEVEN * v->hidden + nothing;
    const int is_steady = is_even && v->high - v->low <= steady + nothing;
    const int is_shown = has_error && v->reach <= SHOWN * range + nothing;
    if (!(is_steady || is_shown || v->change <= EXPLAINED * range + nothing)) return UNRESOLVED;
    return is_steady || v->change <= SMOOTH * range + nothing ? RESOLVED : COARSE;
}

/* whether samples between two times tell how parts vary with the state; whether they are few for
 * that is noted */
static int are_narrow_resolved(double start, double end, Search *search, const State *s, Work *work)
{
    VariationBounds variations[ROOM(N_NARROW)];
    double band[ROOM(N_NARROW)];
    const double h = (end - start) / CELLS;
    int is_coarse = 0;
    TimeNode a, b;
    node_at(start, search, s, work, &a);
    for (size_t k = 0; k != N_NARROW; ++k) {
        begin_variation(middle(&a, N_CROSSINGS + k), &variations[k]);
        band[k] = half_width(&a, N_CROSSINGS + k);
    }
    for (int cell = 1; cell <= CELLS; ++cell) {
        node_at(start + cell * h, search, s, work, &b);
        bound_functions(&a, &b, search, work->w);
        for (size_t k = 0; k != N_NARROW; ++k) {
            add_cell(h, middle(&b, N_CROSSINGS + k), work->w + W_NARROW + 4 * k, &variations[k]);
            band[k] = larger(half_width(&b, N_CROSSINGS + k), band[k]);
        }
        a = b;
    }
    for (size_t k = 0; k != N_NARROW; ++k) {
        const double size = larger(-variations[k].least, variations[k].most);
        const double nothing = band[k] + negligible_variation(
                                             size, narrow_scales[k], search->tolerance, start, end);
        /* no error tells of what works miss along drivers */
        const double steady = IS_DRIVEN ? 0.0 : STEADY * size;
        const int sampling = sampling_of(&variations[k], steady, search->has_error, nothing);
        if (sampling == UNRESOLVED) return 0;
        is_coarse = is_coarse || sampling == COARSE;
    }
    search->is_coarse = search->is_coarse || is_coarse;
    return 1;
}

/* whether at both times a function is near to zero at which a force may be infinite, or in between:
 * no bound tells there how it varies, and of what is narrow the energy does */
static int is_at_pole(
    int in_between, double first, double last, const Search *search, const State *s, Work *work)
{
    TimeNode a, b;
    if (N_POLES == 0) return 0;
    node_with_noise(search->noise, first, search, s, work, &a);
    node_with_noise(search->noise, last, search, s, work, &b);
    for (size_t k = N_SWITCHING; k != N_CROSSINGS; ++k) {
        const int before = side_at(&a, k), after = side_at(&b, k);
        if ((before == 0 && after == 0) || (in_between && before * after != 1)) return 1;
    }
    return 0;
}

/* where a step to an end must end so that samples tell how parts vary with the state; what they do
 * not tell in the finest intervals either is gone over, and noted */
static double resolved_end(double end, Search *search, const State *s, Work *work)
{
    const double start = search->start, whole = end - start;
    double first = start, allowed = whole, width = whole;
    for (size_t n = 0; first < start + allowed; ++n) {
        if (n == MOST_NODES) {
            search->is_unresolved = search->is_unresolved ||
                                    !is_at_pole(1, first, end, search, s, work);
            break;
        }
        const double last = smaller(first + width, end);
        const int is_there = is_at_pole(0, first, last, search, s, work);
        const int good = !is_there && are_narrow_resolved(first, last, search, s, work);
        if (!good && !is_there && width > FINEST * search->h) {
            width = 0.5 * width;
            continue;
        }
        if (good) {
            allowed = smaller(allowed, larger(first - start, last - first));
        } else if (!is_at_pole(1, first, last, search, s, work)) {
            search->is_unresolved = 1;
        }
        first = last;
        width = 2.0 * width;
    }
    return allowed < whole ? start + allowed : end;
}
