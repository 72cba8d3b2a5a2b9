/* Cuts: steps end right before places where a force turns round or jumps; the next lead over them.
 *
 * Stages on both sides of such a place throw the polynomial of a step off, and what they leave in
 * it has the same sign each time. */

/* a step that was cut leads over such a place where this part of it is behind */
#define BEHIND 0.3
/* places within this part of a trial that is not kept must lie where its first rates lead: what is
 * zero there has sunk to this part of what it was, or is that part of the one to which they lead */
#define EARLY 0.1
#define SUNK 0.3
#define THERE 1e-3
/* how often a step is cut for such places */
#define MOST_TURNED 8

/* whether a step to an end is made to lead over a place */
static int is_leap(double end, const Look *look)
{
    return end == look->turning && look->place < end;
}

/* where a step is cut for a place: before it, or behind it if that is no way */
static double cut_beside(double place, double near, const Look *look)
{
    const double way = place - look->start;
    return way > 2.0 * near ? place - larger(near, SMALL * way) : place + near;
}

/* where a step is cut for places; what was seen, which is noted, after many cuts */
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
