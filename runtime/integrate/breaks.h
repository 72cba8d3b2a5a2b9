/* Breaks: steps end where a function of the state crosses zero at which a force jumps.
 *
 * Trials that end beyond it are too long by their error, until so little of one is behind the jump
 * that it is kept: each time that leaves an error of one sign, which is no smaller than the
 * tolerance. */

/* a step that leads over a jump begins at this part of the longest step before it, in units of the
 * tolerance: what its stages on both sides leave is that much less than may be */
#define NEAR 1e-6

/* finds when functions first cross in the polynomial of a step at which a force jumps */
static void find_breaks(Search *search, const State *s, Work *work)
{
    TimeNode node;
    for (size_t n = 0; n != N_BREAKS; ++n) {
        const size_t k = N_SWITCHING - N_BREAKS + n;
        double first = search->start, last = search->breaks[n];
        if (!(last < HUGE_VAL)) continue;
        while (last - first > SMALLEST * larger(fabs(first), fabs(last))) {
            const double time = 0.5 * (first + last);
            if (!(first < time && time < last)) break;
            node_with_noise(search->rounding, time, search, s, work, &node);
            if (side_at(&node, k) == -(int)s->sides[k]) last = time;
            else first = time;
        }
        search->breaks[n] = last;
    }
}

/* the size of a function so far ahead of the start of a step at its first rates */
static double size_ahead(size_t k, double way, const Search *search, const State *s, Work *work)
{
    const double exact[ROOM(N_READ)] = { 0.0 };
    TimeNode node;
    for (size_t i = 0; i != NY; ++i) work->scratch[i] = s->y[i] + way * s->f[i];
    read_of(search->start + way, work->scratch, work, node.read);
    evaluate_node(exact, search->start + way, work->w, &node);
    return fabs(middle(&node, k));
}

/* whether a function comes to zero at an early place of a vague trial at its first rates, too:
 * stages behind jumps throw its polynomial off, and it may have places there that are none */
static int is_ahead(size_t k, double place, const Search *search, const State *s, Work *work)
{
    const double way = place - search->start, early = EARLY * search->h;
    if (search->least_part == 0.0 || !(way < early)) return 1;
    const double before = size_ahead(k, 0.0, search, s, work);
    const double there = size_ahead(k, way, search, s, work);
    const double beyond = size_ahead(k, early, search, s, work);
    return there <= larger(FALLEN_PART * before, THERE * beyond);
}

/* whether a function that crosses zero at a place would be thrown back, and stay there, as where
 * dry friction holds a body: what acts at a stage that is beyond tells it */
static int is_pushed_back(size_t k, double place, const Search *search, const State *s, Work *work)
{
    const double exact[ROOM(N_READ)] = { 0.0 }, soon = SMALL * larger(s->stride, search->h);
    const Method *m = search->m;
    double following[ROOM(N_READ)], *y = work->scratch;
    TimeNode own, node;
    for (size_t n = 1; n <= m->stages; ++n) {
        const double time = search->start + m->c[n] * search->h;
        combine(n, m->a + n * (n - 1) / 2, s->y, search->h, work->k, y);
        read_of(time, y, work, own.read);
        evaluate_node(search->rounding, time, work->w, &own);
        if (side_at(&own, k) != -(int)s->sides[k]) continue;
        for (size_t i = 0; i != NY; ++i) y[i] = y[i] + soon * work->k[n][i];
        read_of(time + soon, y, work, following);
        read_at(place, search, s, work, node.read);
        evaluate_node(exact, place, work->w, &node);
        const double there = middle(&node, k);
        for (size_t i = 0; i != N_MEASURES; ++i) {
            node.read[2 * i] += soon * node.read[2 * i + 1];
            node.read[2 * i + 1] += following[2 * i + 1] - own.read[2 * i + 1];
        }
        evaluate_node(exact, place + soon, work->w, &node);
        return s->sides[k] * (middle(&node, k) - there) > 0.0;
    }
    return 0;
}

/* the first jump in a step, as a number of those, N_BREAKS where there is none */
static size_t first_break(const Search *search)
{
    size_t found = N_BREAKS;
    for (size_t k = 0; k != N_BREAKS; ++k) {
        const double first = found == N_BREAKS ? HUGE_VAL : search->breaks[found];
        if (search->breaks[k] < first) found = k;
    }
    return found;
}

/* where a step to an end, or to what is seen in it, must end by the first jump. That is the end
 * where it leads over the jump, as it is made to, and what is seen where no jump is, or an event is
 * nearer. One that is too wide for its error is made narrower */
static double break_end(
    double end, double seen, int is_leading, Search *search, const State *s, Work *work)
{
    find_breaks(search, s, work);
    const size_t first = first_break(search);
    if (first == N_BREAKS) return seen;
    const double place = search->breaks[first];
    const int is_over = is_leading && end - place > BEHIND * search->h;
    if (is_over && search->is_kept) {
        for (size_t k = 0; k != EVENTS; ++k) {
            if (search->crosses[k]) return seen;
        }
        return end;
    }
    if (search->place_cuts >= MOST_PLACE_CUTS) return seen;
    const size_t k = N_SWITCHING - N_BREAKS + first;
    if (!is_ahead(k, place, search, s, work) || is_pushed_back(k, place, search, s, work))
        return seen;
    double near = 2.0 * ONWARD * SMALLEST * larger(fabs(search->start), fabs(end));
    if (!is_over) {
        const double part = search->slack / search->h;
        near = larger(NEAR * part * larger(s->stride, search->h), near);
    }
    const double found = cut_beside(place, near, search);
    return found < seen ? found : seen;
}

/* where a step is cut for jumps: those over which it leads cross there */
static double broken_in(double found, Search *search)
{
    search->place = search->breaks[first_break(search)];
    search->is_over = search->place < found;
    cut_for_place(found, found, search);
    for (size_t k = 0; k != N_BREAKS; ++k)
        search->crosses[N_SWITCHING - N_BREAKS + k] = search->breaks[k] < found;
    return found;
}
