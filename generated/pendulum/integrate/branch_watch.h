/* Branches in a step: whether pivot ratios tell that it led past a singular configuration. Beyond
 * one a step may have gone on to another branch of the constraints. */

/* check a step for other branches if its smallest branch ratio, by a parabola through those
 * at its ends and at a stage inside, or at a stage, is below this part of the larger ratio at its
 * ends */
#define FALLEN_RATIO_PART 0.1
/* check a step for other branches, too, if a stage has a branch ratio below this part of the
 * smaller ratio at its ends */
#define DIPPED_RATIO_PART 0.75
/* check a step for other branches, too, if a branch ratio at its ends is below this part of the
 * largest so far and the step is long in the sense of FAR_WAY_PART */
#define SMALL_RATIO_PART 1e-3
/* a step is long if bodies move in it by more than this part of the distance to the place where
 * branches meet, taken as the root of the larger branch ratio at its ends over the largest so
 * far */
#define FAR_WAY_PART 0.5
/* longest motion of bodies in a step that is checked for other branches, in lengths of the scene or
 * radians: how branch ratios vary is not known over longer ones */
#define LONGEST_NEAR_BRANCHES 0.75
/* tolerance above which the motion in every step is limited, so that no stages pass by a place
 * where branches meet. Where drivers determine the motion it is so at every tolerance */
#define LOOSE_TOLERANCE 1e-3
/* longest motion of bodies in a step that is limited for this reason, in lengths of the scene or
 * radians */
#define LONGEST_IF_LOOSE 1.2
/* longest motion of bodies, instead of LONGEST_IF_LOOSE, where drivers determine it and the method
 * has many stages. Two bodies turn towards each other by twice as much, which is less than half a
 * turn: no step passes two places where branches meet */
#define LONGEST_OF_MANY_STAGES 1.5
/* these limits do not apply where the smallest branch ratio in a step exceeds this part of the
 * largest: no place where branches meet is passed by if ratios are as level as that */
#define LEVEL_RATIO_PART 0.999
/* the root of the branch ratio may have changed its sign between two stages if a line through the
 * roots at one of them and at the stage beyond it leads to less than this part of the root at the
 * other one */
#define SIGN_CHANGE_PART 0.2
/* safety factor of a step length that follows from a longest motion of bodies */
#define LIMITED_STEP_PART 0.98

/* minimum of a parabola through branch ratios of a step, and of those at its stages */
static double least_of_parabola(const Trial *trial, const State *s)
{
    const double first = s->position_ratio, last = trial->end_ratio, x = trial->inner;
    const double quadratic = ((trial->inner_ratio - first) / x - (last - first)) / (x - 1.0);
    const double slope = last - first - quadratic;
    const int is_inside = slope < 0.0 && 0.0 < 2.0 * quadratic + slope;
    const double least = is_inside ? first - slope * slope / (4.0 * quadratic) : last;
    return smaller(least, smaller(trial->dip_ratio, last));
}

/* whether the smallest branch ratio of a step is below a part of the larger one at its ends */
static int falls_to(double part, const Trial *trial, const State *s)
{
    const double ends = larger(s->position_ratio, trial->end_ratio);
    return least_of_parabola(trial, s) < part * smaller(ends, usual_ratio(s));
}

/* part of a step at which branches seem to meet, from roots of branch ratios at its ends. These
 * roots go with the distance from the place where branches meet */
static double meeting_part(double first, double last)
{
    return first + last > 0.0 ? first / (first + last) : 0.5;
}

/* part at which branches seem to meet, before or behind a stage with a small branch ratio */
static double dipping_part(double first, double last, const Trial *trial)
{
    const double dip = sqrt(trial->dip_ratio), x = trial->dip;
    return meeting_part(first, last) > x ? x + (1.0 - x) * dip / (dip + last)
                                         : x * first / (first + dip);
}

/* part of a step at which roots of branch ratios change their sign, and their slope there. These
 * roots go with the distance from a place where branches meet, but are known without a sign: lines
 * through two of them tell the sign of the next. The slope is 0 if none changes its sign */
static double sign_change(const Trial *trial, double *slope)
{
    const double *x = trial->parts, *r = trial->roots;
    double part = 0.0, least = HUGE_VAL;
    *slope = 0.0;
    for (size_t k = 0; k + 1 < trial->count; ++k) {
        const double width = x[k + 1] - x[k], both = r[k] + r[k + 1];
        double ahead = HUGE_VAL, back = HUGE_VAL;
        if (!(x[k + 1] > 0.0) || !(both < least)) continue;
        if (k > 0) ahead = r[k] + width * (r[k] - r[k - 1]) / (x[k] - x[k - 1]);
        if (k + 2 < trial->count)
            back = r[k + 1] - width * (r[k + 2] - r[k + 1]) / (x[k + 2] - x[k + 1]);
        if (!(ahead < SIGN_CHANGE_PART * r[k + 1]) && !(back < SIGN_CHANGE_PART * r[k])) continue;
        part = x[k] + width * meeting_part(r[k], r[k + 1]);
        *slope = both / width;
        least = both;
    }
    return part;
}

/* longest motion of a step whose stages show branches, in lengths and rad, or infinite */
static double longest_way(const Attempts *tried, const Trial *trial, const State *s)
{
    const int is_loose = IS_DRIVEN || tried->settings->tolerance > LOOSE_TOLERANCE;
    if (!HAS_REFINEMENT || !is_loose || tried->is_fixed) return HUGE_VAL;
    const double top = larger(s->position_ratio, trial->top_ratio);
    if (smaller(trial->dip_ratio, trial->end_ratio) > LEVEL_RATIO_PART * top) return HUGE_VAL;
    return IS_DRIVEN && tried->m->stages >= MANY_STAGES ? LONGEST_OF_MANY_STAGES : LONGEST_IF_LOOSE;
}

/* whether bodies move in a step by no more than the longest way: else it is made again. Where
 * bodies are free it is made much shorter: they pass places where branches meet by momentum */
static int is_short(double longest, Trial *trial, const State *s, const Work *work)
{
    const double way = longest < HUGE_VAL ? way_of(trial->h, s->y, work->y) : 0.0;
    if (!(way > longest)) return 1;
    if (IS_DRIVEN) trial->longest = LIMITED_STEP_PART * trial->h * (longest / way);
    return 0;
}

/* whether a step may end on another branch: BRANCH_LOST, ON_BRANCH or BIFURCATION */
static int branch_of(const Attempts *tried, Trial *trial, Work *work, State *s)
{
    if (!HAS_REFINEMENT) return ON_BRANCH;
    const double first = s->position_ratio, last = trial->end_ratio, most = usual_ratio(s);
    if (!is_short(longest_way(tried, trial, s), trial, s, work)) return BRANCH_LOST;
    const int is_dip = trial->dip_ratio < DIPPED_RATIO_PART * smaller(first, last);
    double slope = 0.0, part = TRACKS_ROOTS ? sign_change(trial, &slope) : 0.0;
    const int is_falling = is_dip || slope > 0.0 || falls_to(FALLEN_RATIO_PART, trial, s);
    if (!is_falling && !(smaller(first, last) < SMALL_RATIO_PART * most)) return ON_BRANCH;
    const double far = FAR_WAY_PART * sqrt(larger(first, last) / most);
    if (!is_falling && !(way_of(trial->h, s->y, work->y) > far)) return ON_BRANCH;
    if (!tried->is_fixed && !is_short(LONGEST_NEAR_BRANCHES, trial, s, work)) return BRANCH_LOST;
    const double before = sqrt(first), after = sqrt(last), *f = work->k[tried->m->stages];
    if (!(slope > 0.0)) {
        part = is_dip ? dipping_part(before, after, trial) : meeting_part(before, after);
        slope = before + after;
    }
    return follow_branch(trial->h, work->y, f, part, slope, work, s);
}
