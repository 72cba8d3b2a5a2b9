/* Search: what formulas read, and bounds of them, at times inside of a step that was tried. The
 * polynomial of the step, the dense output, gives at some times, the nodes, what formulas read:
 * coordinates, lengths of springs, their rates. Bounds of these between the nodes bound the
 * functions and their rates, as of switching functions of time. Values that are nearer to zero
 * than the error of the step, the noise, count as zero. */

/* smallest step, relative to the time, and rounding of values, relative to their size */
#define SMALLEST 1e-15
/* smallest number of intervals in which a step is searched */
#define CELLS 4
/* largest number of intervals that are looked at in one search */
#define MOST_NODES 512
/* second derivatives of what formulas read are taken to lie within this many times their rise in
 * the cubic polynomial, above and below their mean */
#define DOUBT 2.0
/* loosest tolerance to which values are known in a search, and loosest tolerance of steps from a
 * switch to the next: forces that switch again soon are narrow, and estimates are blind to what
 * acts for a stage or two. It also applies to each step from a kink where no force jumps: friction
 * that holds switches all the time */
#define LOOSEST_AT_SWITCH 1e-5
/* speed that is added to rates to scale their errors, in lengths of the scene or radians over the
 * longest step so far: in a short step the rates of what moves are no better known, and no worse */
#define SLOW 1e-4
/* a zero is transversal if at its speed the value leaves this many times its noise, within the
 * longest step so far and before it comes to rest; the same holds for a rate, which changes as fast
 * as it does. Such values are known to rounding */
#define PASSING 16.0

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
    /* whether each event has been noted by an earlier step that ended a little before its zero, or
     * is zero all along */
    int is_short[ROOM(N_FUNCTIONS)];
    /* whether each event is zero all along the step, as far as it is known */
    int is_at_zero[ROOM(N_FUNCTIONS)];
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

/* whether a function is zero all about a node, which was evaluated last */
static int is_flat(const TimeNode *node, size_t k, const double *w)
{
    const double *rate = w + W_FUNCTIONS + 4 * k + 2;
    return node->least[k] == 0.0 && node->most[k] == 0.0 && rate[0] == 0.0 && rate[1] == 0.0;
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

/* noise of values and rates with which the zero of a function is located. Events, and functions at
 * whose zero a force is infinite, are located by the polynomial, with its rounding; the others are
 * known to the noise of the motion */
static const double *noise_of(size_t k, const Search *search)
{
    return (int)k < EVENTS || (int)k >= N_SWITCHING ? search->rounding : search->noise;
}

/* cuts a step where it must end, and remembers what crosses there */
static double cut_at(double end, Search *search)
{
    memcpy(search->was_crossing, search->crosses, sizeof search->crosses);
    search->cut = end;
    return end;
}
