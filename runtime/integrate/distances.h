/* Distances: steps end where one along which a force acts comes down to zero, or nearly.
 *
 * There the force turns round in a time that is none, or as good as none: stages on both sides may
 * tell no error of it, and a step may leap over two such places. On a smooth way a step that meets
 * the tolerance has no distance that is much smaller inside of it than at its ends: only where one
 * may be it is looked for in the polynomial. The step is made again, to end right before that
 * place, and the next one, to end as far behind. */

/* distances that sink to this part of the larger one at the ends, as a parabola tells, are looked
 * at; those that do so to this part in the polynomial turn a force within the step, and those in
 * formulas to this one: bounds tell how these vary, but for what places are known to */
#define SUNK 0.3
#define TURNING 0.0625
#define TOLD_TURNING 1e-2
/* a force turns within so many times the time in which a distance gets larger by as much as it is
 */
#define AROUND 8.0
/* a step that was cut leads over such a place where this part of it is behind */
#define BEHIND 0.3
/* a step of so many times no way leads over such a place, and has no other */
#define LEAP 4.0
/* how often a step is cut for distances */
#define MOST_TURNED 8
/* where the golden section divides an interval, and how often it does */
#define GOLDEN 0.3819660112501051
#define MOST_SECTIONS 80

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
static void distances_at(double time, const Look *look, const State *s, Work *work, double *found)
{
    interpolate(look->m, (time - look->start) / look->h, s, work->scratch);
    distances_of(time, work->scratch, work, found);
}

/* whether the square of a distance may sink between three times, as a parabola through it does */
static int sinks_between(double first, double middle, double last)
{
    const double slope = 0.5 * (last - first), bend = 0.5 * (first + last) - middle;
    double least = smaller(first, last);
    if (bend > 0.0 && fabs(slope) < 2.0 * bend) least = middle - slope * slope / (4.0 * bend);
    return least < SUNK * SUNK * larger(first, last);
}

/* whether a distance may sink in a step of length h from the state to y, with derivative f. A cubic
 * polynomial tells what is in the middle */
static int may_turn(
    double time, double h, const double *y, const double *f, const State *s, Work *work)
{
    double first[ROOM(N_DISTANCES)], there[ROOM(N_DISTANCES)], last[ROOM(N_DISTANCES)];
    double *middle = work->scratch;
    for (size_t i = 0; i != NY; ++i)
        middle[i] = 0.5 * (s->y[i] + y[i]) + 0.125 * h * (s->f[i] - f[i]);
    distances_of(time, s->y, work, first);
    distances_of(time + 0.5 * h, middle, work, there);
    distances_of(time + h, y, work, last);
    for (size_t k = 0; k != N_DISTANCES; ++k) {
        if (sinks_between(first[k], there[k], last[k])) return 1;
    }
    return 0;
}

/* the time in a step at which a distance is least, by golden sections */
static double nearest_time(size_t k, const Look *look, const State *s, Work *work)
{
    double found[ROOM(N_DISTANCES)], first = look->start, last = look->start + look->h;
    double a = first + GOLDEN * look->h, b = last - GOLDEN * look->h;
    distances_at(a, look, s, work, found);
    double there = found[k];
    distances_at(b, look, s, work, found);
    double beyond = found[k];
    for (size_t n = 0; n != MOST_SECTIONS && first < a && a < b && b < last; ++n) {
        if (there < beyond) {
            last = b;
            b = a;
            beyond = there;
            a = first + GOLDEN * (last - first);
            distances_at(a, look, s, work, found);
            there = found[k];
        } else {
            first = a;
            a = b;
            there = beyond;
            b = last - GOLDEN * (last - first);
            distances_at(b, look, s, work, found);
            beyond = found[k];
        }
    }
    return there < beyond ? a : b;
}

/* the time of a step that is no way: bounds tell nothing of what is in it, and rounding little */
static double no_way(const Look *look)
{
    const double tiny = ONWARD * SMALLEST * larger(fabs(look->start), fabs(look->start + look->h));
    return larger(FINEST * look->h, 2.0 * tiny);
}

/* where a step to an end must end by a distance, of these squares at its ends: before the place, or
 * behind it if that is no way; infinite where it need not */
static double turning_end(
    size_t k, double before, double after, double end, const Look *look, const State *s, Work *work)
{
    const double time = nearest_time(k, look, s, work), way = time - look->start;
    const double tiny = ONWARD * SMALLEST * larger(fabs(look->start), fabs(end));
    const double far = larger(before, after);
    double found[ROOM(N_DISTANCES)];
    distances_at(time, look, s, work, found);
    const double least = found[k];
    const double nothing = no_way(look);
    const double part = (int)k < N_LENGTHS ? TURNING : TOLD_TURNING;
    if (!(far > 0.0 && least < part * part * far && end - time > tiny)) return HUGE_VAL;
    /* it starts behind the place */
    if (!(way > tiny) && !(look->h * sqrt(larger(before / far, 0.0)) < 0.5 * nothing))
        return HUGE_VAL;
    /* it leads over the place */
    if (end == look->turning && end - time > BEHIND * look->h) return HUGE_VAL;
    const double from_there = before > after ? way : end - time;
    const double turn = AROUND * from_there * sqrt(larger(least / (far - least), 0.0));
    const double near = larger(nothing, turn);
    if (way > 2.0 * near) return time - larger(near, SMALL * way);
    return time + near;
}

/* where a step is cut for distances; what was seen, which is noted, after many cuts */
static double turned_in(double turned, double seen, Look *look)
{
    if (++look->turned > MOST_TURNED) {
        look->is_untold = 1;
        return seen;
    }
    memset(look->crosses, 0, sizeof look->crosses);
    look->turning = turned;
    return turned;
}

/* where a step to an end must end by all distances, infinite where it need not */
static double turned_end(double end, Look *look, const State *s, Work *work)
{
    double first[ROOM(N_DISTANCES)], there[ROOM(N_DISTANCES)], last[ROOM(N_DISTANCES)];
    double found = HUGE_VAL;
    distances_at(look->start, look, s, work, first);
    distances_at(look->start + 0.5 * look->h, look, s, work, there);
    distances_at(look->start + look->h, look, s, work, last);
    for (size_t k = 0; k != N_DISTANCES; ++k) {
        if (!sinks_between(first[k], there[k], last[k])) continue;
        found = smaller(found, turning_end(k, first[k], last[k], end, look, s, work));
    }
    if (found < end) look->is_over = found - look->start < LEAP * no_way(look);
    return found;
}
