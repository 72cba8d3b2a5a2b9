/* Distances: steps end where one along which a force acts comes down to zero, or nearly.
 *
 * There the force reverses in a time that is none, or as good as none: stages on both sides may
 * tell no error of it, and a step may pass two such places. On a smooth way a step that meets the
 * tolerance has no distance that is much smaller inside of it than at its ends: only where one may
 * be it is looked for in the polynomial. The step is made again, to end right before that place,
 * and the next one, to end as far behind. */

/* distances that have fallen beside the largest at the ends and in the middle of a step, as cubics
 * over its halves tell, are looked at; those that do so to this part in the polynomial reverse a
 * force within the step, and those in formulas to this one: bounds tell how these vary, but for
 * what places are known to */
#define REVERSAL_PART 0.0625
#define BOUNDED_REVERSAL_PART 1e-2
/* rates of squares are told by their difference over this part of a step, 2^-20 */
#define DIFFERENCE 9.5367431640625e-7
/* the node in the middle of a step: each lies twice as far from its start as the one before it, the
 * first at that difference */
#define DOUBLED 20
/* a force reverses within so many times the time in which a distance grows by as much as it is */
#define AROUND 8.0
/* a step of so many times no way leads over such a place, and has no other */
#define OVER_PLACE 4.0
/* where the golden section divides an interval, and how often it does */
#define GOLDEN 0.3819660112501051
#define MOST_SECTIONS 80

/* parts of a step where squares are asked for: at its ends, in its middle, and beside these */
static const double NODES[] = { 0.0, DIFFERENCE, 0.5, 0.5 + DIFFERENCE, 1.0 - DIFFERENCE, 1.0 };
enum { N_NODES = sizeof NODES / sizeof *NODES };

enum { W_NEAR = N_LENGTHS > 0 ? W_LENGTHS : W_DISTANCES }; /* one behind the other */

/* squares of distances of y at a time */
static void distances_of(double time, const double *y, Work *work, double *found)
{
    double read[ROOM(N_READ)];
    read_of(time, y, work, read);
    distance(work->w);
    memcpy(found, work->w + W_NEAR, N_DISTANCES * sizeof *found);
}

/* squares of distances at a time */
static void distances_at(
    double time, const Search *search, const State *s, Work *work, double *found)
{
    interpolate(search->m, (time - search->start) / search->h, s, work->scratch);
    distances_of(time, work->scratch, work, found);
}

/* the least value inside of a cubic of these values and slopes at 0 and 1, infinite if none is */
static double dip_between(double first, double slope, double last, double rise)
{
    const double way = last - first;
    const double quadratic = 3.0 * way - 2.0 * slope - rise, cubic = slope + rise - 2.0 * way;
    const double inner = quadratic * quadratic - 3.0 * cubic * slope;
    const double root = quadratic + sqrt(larger(inner, 0.0));
    if (inner < 0.0 || root == 0.0) return HUGE_VAL;
    const double place = -slope / root;
    if (!(0.0 <= place && place <= 1.0)) return HUGE_VAL;
    return first + place * (slope + place * (quadratic + place * cubic));
}

/* the largest square of a distance at the ends and in the middle of a step */
static double largest_of(size_t k, double nodes[N_NODES][ROOM(N_DISTANCES)])
{
    return larger(larger(nodes[0][k], nodes[5][k]), nodes[2][k]);
}

/* whether the square of a distance may fall in the first or second half of a step */
static int falls_in(int half, size_t k, double nodes[N_NODES][ROOM(N_DISTANCES)])
{
    const double first = nodes[0][k], middle = nodes[2][k], last = nodes[5][k];
    const double slope = (nodes[3][k] - middle) * (0.5 / DIFFERENCE);
    double least;
    if (half == 0)
        least = smaller(
            first, dip_between(first, (nodes[1][k] - first) * (0.5 / DIFFERENCE), middle, slope));
    else
        least = smaller(
            last, dip_between(middle, slope, last, (last - nodes[4][k]) * (0.5 / DIFFERENCE)));
    return least < FALLEN_PART * FALLEN_PART * largest_of(k, nodes);
}

/* whether a distance may fall in a step of length h from the state to y, with derivative f. A cubic
 * polynomial tells what is in it */
static int may_reverse(
    double time, double h, const double *y, const double *f, const State *s, Work *work)
{
    double nodes[N_NODES][ROOM(N_DISTANCES)], *there = work->scratch;
    for (size_t n = 0; n != N_NODES; ++n) {
        const double part = NODES[n], rest = 1.0 - part, along = part * part * (3.0 - 2.0 * part);
        const double curve = h * part * rest;
        for (size_t i = 0; i != NY; ++i)
            there[i] = (1.0 - along) * s->y[i] + along * y[i] +
                       curve * (rest * s->f[i] - part * f[i]);
        distances_of(time + part * h, there, work, nodes[n]);
    }
    for (size_t k = 0; k != N_DISTANCES; ++k) {
        if (falls_in(0, k, nodes) || falls_in(1, k, nodes)) return 1;
    }
    return 0;
}

/* the part of a step at a node of those among which a distance is looked for. They lie the closer
 * the nearer they are to its ends: a step that was cut begins right before a place */
static double node_of(int number)
{
    if (number == 0) return 0.0;
    if (number <= DOUBLED) return ldexp(DIFFERENCE, number - 1);
    return number == 2 * DOUBLED ? 1.0 : 1.0 - ldexp(DIFFERENCE, 2 * DOUBLED - number - 1);
}

/* the time between two in a step at which a distance is least, by golden sections */
static double nearest_time(
    size_t k, double first, double last, const Search *search, const State *s, Work *work)
{
    double found[ROOM(N_DISTANCES)];
    double a = first + GOLDEN * (last - first), b = last - GOLDEN * (last - first);
    distances_at(a, search, s, work, found);
    double there = found[k];
    distances_at(b, search, s, work, found);
    double beyond = found[k];
    for (size_t n = 0; n != MOST_SECTIONS && first < a && a < b && b < last; ++n) {
        if (there < beyond) {
            last = b;
            b = a;
            beyond = there;
            a = first + GOLDEN * (last - first);
            distances_at(a, search, s, work, found);
            there = found[k];
        } else {
            first = a;
            a = b;
            there = beyond;
            b = last - GOLDEN * (last - first);
            distances_at(b, search, s, work, found);
            beyond = found[k];
        }
    }
    return there < beyond ? a : b;
}

/* the time of a step that is no way: bounds tell nothing of what is in it, and rounding little */
static double no_way(const Search *search)
{
    const double tiny = ONWARD * SMALLEST *
                        larger(fabs(search->start), fabs(search->start + search->h));
    return larger(FINEST * search->h, 2.0 * tiny);
}

/* where a step to an end must end by a distance that is least at a time: before the place, or
 * behind it if that is no way; infinite where it need not */
static double cut_end(size_t k, double time, double nodes[N_NODES][ROOM(N_DISTANCES)], double end,
    const Search *search, const State *s, Work *work)
{
    const double way = time - search->start;
    const double tiny = ONWARD * SMALLEST * larger(fabs(search->start), fabs(end));
    const double before = nodes[0][k], far = largest_of(k, nodes);
    double found[ROOM(N_DISTANCES)];
    distances_at(time, search, s, work, found);
    const double least = found[k];
    const double nothing = no_way(search);
    const double part = (int)k < N_LENGTHS ? REVERSAL_PART : BOUNDED_REVERSAL_PART;
    if (!(far > 0.0 && least < part * part * far && end - time > tiny)) return HUGE_VAL;
    /* it starts behind the place */
    if (!(way > tiny) && !(search->h * sqrt(larger(before / far, 0.0)) < 0.5 * nothing))
        return HUGE_VAL;
    /* it is made to lead over the place, and does */
    if (leads_over(end, search) && end - time > BEHIND * search->h) return HUGE_VAL;
    const double farthest = before == far ? 0.0 : nodes[2][k] == far ? 0.5 : 1.0;
    const double from_there = fabs(way - farthest * search->h);
    const double near = AROUND * from_there * sqrt(larger(least / (far - least), 0.0));
    return cut_beside(time, larger(nothing, near), search);
}

/* where a step to an end must end by the first such place of a distance, and that */
static double first_reversal(size_t k, double nodes[N_NODES][ROOM(N_DISTANCES)], double end,
    const Search *search, const State *s, Work *work, double *place)
{
    double found[ROOM(N_DISTANCES)], earlier = search->start, time = search->start;
    double before = HUGE_VAL, there = nodes[0][k];
    for (int number = 0; number != 2 * DOUBLED; ++number) {
        const double following = search->start + node_of(number + 1) * search->h;
        distances_at(following, search, s, work, found);
        const double beyond = found[k];
        if (there <= before && there < beyond) {
            *place = nearest_time(k, earlier, following, search, s, work);
            const double cut = cut_end(k, *place, nodes, end, search, s, work);
            if (cut < HUGE_VAL) return cut;
        }
        earlier = time;
        time = following;
        before = there;
        there = beyond;
    }
    return HUGE_VAL;
}

/* whether a distance falls to an early place of a trial that is not kept at its first rates, too:
 * stages that meet a force which the others pass by throw its polynomial off. It then has places
 * that are none, also right at its start, and again wherever the trial is made again */
static int is_on_the_way(
    size_t k, double place, double before, const Search *search, const State *s, Work *work)
{
    const double way = place - search->start, early = EARLY * search->h;
    double there[ROOM(N_DISTANCES)], beyond[ROOM(N_DISTANCES)], *y = work->scratch;
    if (search->is_kept || !(way < early)) return 1;
    for (size_t i = 0; i != NY; ++i) y[i] = s->y[i] + way * s->f[i];
    distances_of(search->start + way, y, work, there);
    for (size_t i = 0; i != NY; ++i) y[i] = s->y[i] + early * s->f[i];
    distances_of(search->start + early, y, work, beyond);
    return there[k] <= larger(FALLEN_PART * FALLEN_PART * before, THERE * THERE * beyond[k]);
}

/* where a step to an end must end by all distances, infinite where it need not */
static double reversal_end(double end, Search *search, const State *s, Work *work)
{
    double nodes[N_NODES][ROOM(N_DISTANCES)], found = HUGE_VAL, place = HUGE_VAL;
    for (size_t n = 0; n != N_NODES; ++n)
        distances_at(search->start + NODES[n] * search->h, search, s, work, nodes[n]);
    for (size_t k = 0; k != N_DISTANCES; ++k) {
        if (!falls_in(0, k, nodes) && !falls_in(1, k, nodes)) continue;
        double nearest;
        const double cut = first_reversal(k, nodes, end, search, s, work, &nearest);
        if (!(cut < found)) continue;
        if (!is_on_the_way(k, nearest, nodes[0][k], search, s, work)) continue;
        found = cut;
        place = nearest;
    }
    if (found < end) {
        search->place = place;
        search->is_over = found - search->start < OVER_PLACE * no_way(search);
    }
    return found;
}
