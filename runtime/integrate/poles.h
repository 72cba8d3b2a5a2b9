/* Poles: where formulas have no value, and where forces are infinite. An event without a value,
 * and a step that leads over a pole of a force, end the run before it. */

/* ratio of two distances from a crossing at which a function is compared */
#define FURTHER 8.0
/* smallest of these distances, in roundings of the time */
#define ROUNDINGS 64.0
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
