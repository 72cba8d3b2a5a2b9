/* Cuts: steps end right before places where a force reverses or jumps; the next lead over them.
 *
 * Stages on both sides of such a place throw the polynomial of a step off, and what they leave in
 * it has the same sign each time. */

/* a step that was cut leads over such a place where this part of it is behind */
#define BEHIND 0.3
/* places within this part of a trial that is not kept must lie where its first rates lead: what is
 * zero there has fallen to this part of what it was, or is that part of the one to which they
 * lead */
#define EARLY 0.1
#define FALLEN_PART 0.3
#define THERE 1e-3
/* how often a step is cut for such places */
#define MOST_PLACE_CUTS 8

/* whether a step to an end is made to lead over a place */
static int leads_over(double end, const Search *search)
{
    return end == search->place_cut && search->place < end;
}

/* where a step is cut for a place: before it, or behind it if that is no way */
static double cut_beside(double place, double near, const Search *search)
{
    const double way = place - search->start;
    return way > 2.0 * near ? place - larger(near, SMALL * way) : place + near;
}

/* where a step is cut for places; what was seen, which is noted, after many cuts */
static double cut_for_place(double end, double seen, Search *search)
{
    if (++search->place_cuts > MOST_PLACE_CUTS) {
        search->is_unresolved = 1;
        return seen;
    }
    memset(search->crosses, 0, sizeof search->crosses);
    search->place_cut = end;
    return end;
}
