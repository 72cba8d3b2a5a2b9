/* Crossing: steps end where events are and where formulas of the state have a kink or a jump.
 * This is event location: a step that was tried is searched before it is kept. A function crosses
 * when it is beyond zero on the other side. Then the step is made again, to end there. */

/* a step, or an interval of one, that comes within 1e-7 of its length to the last time ends there:
 * no sliver is left */
#define STRETCH_TO_END 1.0000001
/* shortest step to a cut, and shortest first trial of a step, in smallest steps */
#define ONWARD 8.0
/* largest distance of an event that is located again from the cut, relative to the step. Also the
 * part of the way by which a step ends before a place */
#define SMALL 1e-3
/* a function passes zero if it is at least this many times as large at FURTHER times the distance;
 * one that jumps there, or is infinite, is not */
#define LARGER_THERE 1.1
/* a step ends where a function that was near to zero takes a side, if that is within this part of
 * the step */
#define SOON 0.1
/* time of a look back at an event that is back at zero, in units of the time since it passed zero:
 * one that has gone evenly through a narrow window was outside of it then */
#define EARLIER 1.5
/* times of a second look back and of one ahead, in the same unit: such an event was in the window
 * then, and will be outside again */
#define HALF 0.5
/* a stage from which the end of a step is made is searched for a contact if its accelerations
 * change speeds by more than this part in the step: for less the error tells enough */
#define PUSHED 0.1
/* parts of a step at which events are asked, beside its ends, whether they are zero all along: no
 * wave has its zeros there, as these are irrational */
#define EARLY_PART 0.29289321881345254
#define MIDDLE_PART 0.5773502691896258
#define LATE_PART 0.816496580927726
/* number of parts of a step in which bounds of such events are compared */
#define COMPARED 16
/* where bounds of an event are less than this many times those elsewhere it is flat there */
#define FLAT 1e-6

/* time of a stage, from a first one on, beyond a switch that its polynomial does not meet. Such a
 * stage is in a contact that the step leads over: the force there makes the polynomial useless. If
 * there is none, it is the time up to which the step is seen. A stage from which the end of the
 * step is made counts only if it changes speeds, as the error tells of most; and no such stage
 * counts beyond a jump, which throws back what passes it a little */
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

/* whether bounds of functions are much closer to zero in a part of a step than in another */
static void is_flat_in_part(
    double end, const Search *search, const State *s, Work *work, int *are_flat)
{
    double least[ROOM(N_CROSSINGS)], most[ROOM(N_CROSSINGS)];
    TimeNode a, b;
    for (size_t k = 0; k != N_CROSSINGS; ++k) {
        least[k] = HUGE_VAL;
        most[k] = 0.0;
    }
    node_at(search->start, search, s, work, &a);
    for (int n = 1; n <= COMPARED; ++n) {
        const double part = (double)n / COMPARED;
        const double time = search->start + part * (end - search->start);
        node_at(n == COMPARED ? end : time, search, s, work, &b);
        bound_functions(&a, &b, search, work->w);
        for (size_t k = 0; k != N_CROSSINGS; ++k) {
            const double *bounds = work->w + W_FUNCTIONS + 4 * k;
            const double size = larger(fabs(bounds[0]), fabs(bounds[1]));
            least[k] = smaller(least[k], size);
            most[k] = larger(most[k], size);
        }
        a = b;
    }
    for (size_t k = 0; k != N_CROSSINGS; ++k) are_flat[k] = least[k] < FLAT * most[k];
}

/* notes which events are no further from zero than the noise all along a step, as energies that are
 * kept: rounding tells their side, they do not cross. Not so an event that is flat in a part of the
 * step only, as max(0, 1 - abs(x))*x: it may cross in another part */
static void note_kept(double end, Search *search, const State *s, Work *work)
{
    const double asked[5] = { 0.0, 1.0, EARLY_PART, MIDDLE_PART, LATE_PART };
    int partly[ROOM(N_CROSSINGS)], any = EVENTS > 0;
    for (size_t k = 0; k != N_CROSSINGS; ++k) search->is_at_zero[k] = (int)k < EVENTS;
    for (int n = 0; n != 5 && any; ++n) {
        const double time = search->start + asked[n] * (end - search->start);
        TimeNode node;
        any = 0;
        node_with_noise(search->noise, time, search, s, work, &node);
        for (size_t k = 0; k != EVENTS; ++k) {
            search->is_at_zero[k] = search->is_at_zero[k] && side_at(&node, k) == 0;
            any = any || search->is_at_zero[k];
        }
    }
    if (!any) return;
    is_flat_in_part(end, search, s, work, partly);
    for (size_t k = 0; k != EVENTS; ++k)
        search->is_at_zero[k] = search->is_at_zero[k] && !partly[k];
}

/* notes which events a step starts short of */
static void note_short(const TimeNode *a, double end, Search *search, const State *s, Work *work)
{
    if (end != search->cut) note_kept(end, search, s, work); /* of a cut it is known */
    for (size_t k = 0; k != N_CROSSINGS; ++k) {
        const int side = (int)s->sides[k];
        const int is_beyond = (int)k < EVENTS && side != 0 && side_at(a, k) == -side;
        search->is_short[k] = is_beyond || search->is_at_zero[k];
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
    note_short(&a, end, search, s, work);
    for (size_t n = 0; n != MOST_NODES && a.time < end; ++n) {
        int is_known = 1, any = 0, is_lost = 0, may_be_infinite = 0;
        node_at(a.time + STRETCH_TO_END * width < end ? a.time + width : end, search, s, work, &b);
        for (size_t k = 0; k != N_CROSSINGS; ++k) {
            /* else the polynomial may be thrown off */
            if (search->is_kept && s->sides[k] == 0.0) s->sides[k] = side_at(&a, k);
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
    int goes_on[ROOM(EVENTS)]; /* at zero, and then to either side */
    TimeNode last, known;
    node_at(end, search, s, work, &last);
    node_with_noise(search->noise, end, search, s, work, &known);
    for (size_t k = 0; k != EVENTS; ++k) goes_on[k] = is_flat(&known, k, work->w);
    for (size_t k = 0; k != N_CROSSINGS; ++k) {
        const int side = (int)s->sides[k], now = side_at(&last, k);
        const int is_open = (int)k >= EVENTS || !goes_on[k];
        const int is_near = is_open && (now == 0 || side_at(&known, k) == 0);
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
