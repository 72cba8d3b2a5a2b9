/* Roots: times at which functions of the state cross zero in a step. Where bounds between two
 * nodes show that a function crosses once, its time is bisected. */

/* a function is near to zero at a node where it is less than this many times its noise; the noise
 * at other nodes tells nothing of how near it comes to zero between them */
#define BANDS 2.0

/* whether what is a at the start of h and b at its end is positive between: no less than lines from
 * both ends as steep as it falls and rises at most */
static int stays_positive(double a, double b, double falls, double rises, double h)
{
    return a * rises - b * falls + falls * rises * h > 0.0;
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
    if (search->is_at_zero[k]) return 1;
    if (least > -within || falls >= 0.0 || rises <= 0.0) return 1;
    if (side == 0) return bounds[1] < within;
    return stays_positive(first + within, last + within, falls, rises, b->time - a->time);
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
        const int is_there = side * middle(&node, k) <= 0.0 && !is_flat(&node, k, work->w);
        const int is_behind = (int)k < EVENTS ? is_there : side_at(&node, k) == -side;
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
