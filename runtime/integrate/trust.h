/* Verdict on a run: what speaks against it, and what its numbers may be. */

/* largest loss of a healthy run in each thousand steps, in tolerances */
#define HEALTHY 100.0
/* number of steps in which a run may lose that */
#define PER_STEPS 1000.0
/* largest loss of a healthy run however many steps it has, relative to all that moves */
#define MOST_LOST 0.5
/* value in place of the tolerance where steps have a fixed length: the tolerance does not decide
 * their error */
#define FIXED 1e-9
/* smallest tolerance that the limit of corrections is computed with: near singular configurations
 * rounding makes them larger */
#define LEAST 1e-11
/* rounding of energies and of constraints, relative to what they are compared with */
#define KNOWN 1e-12
/* misses of rows that are left out, in lengths of the scene or radians, below which they are
 * rounding */
#define MISSES 1e-9
/* energy that is no motion where hardly anything moves [J]: the heat of one freedom at room
 * temperature */
#define HEAT 4e-21

/* the largest residual in position of some rows, lengths relative to LENGTH; a NaN stays */
static double largest_residual(const State *s, size_t first, size_t end)
{
    double size = 0.0;
    for (size_t k = first; k != end; ++k) {
        const double x = s->violations[0][k] / (row_is_length[k] ? LENGTH : 1.0);
        if (x > size || isnan(x)) size = x;
    }
    return size;
}

/* a doubt where a number is larger than it may be, or a NaN */
static int beyond(double size, double most, int doubt) { return size <= most ? 0 : doubt; }

/* which part of the energy that has moved may be lost: the limit, unless bodies move so little in
 * the longest step that velocities and their errors are compared with more: at rest all that moves
 * may be such an error */
static double allowed_part(double limit, const Settings *settings, const State *s)
{
    const double travel = s->fastest * s->stride;
    if (settings->fixed_step > 0.0 || !(0.0 < travel && travel < NOTHING_MOVES)) return limit;
    const double part = limit * (NOTHING_MOVES / travel);
    return part + part * part;
}

/* what energies are known to [J]: below that they are rounding, or heat of what hardly moves */
static double known_energy(const State *s)
{
    const double known = larger(larger(fabs(s->energy), fabs(s->potential)), s->energy_moved);
    return larger(KNOWN * known, s->fastest * s->stride < NOTHING_MOVES ? HEAT : 0.0);
}

/* the largest speed so far, or where nothing moves what counts as none, in lengths of the scene and
 * radians [1/s] */
static double fastest_or_nothing(const State *s)
{
    const double nothing = s->stride > 0.0 ? NOTHING_MOVES / s->stride : 0.0;
    return larger(s->fastest, nothing);
}

/* what speaks against a run; no energy is known of drivers that move what has no mass: they do no
 * work. Where joints hold all that could move what energy there is is rounding */
static void judge(const Settings *settings, const State *s, Verdict *verdict)
{
    enum { HELD = HAS_JOINT_COORDINATES ? NCHECK : NC, IS_FREE = HELD != NV };
    enum { KNOWS_ENERGY = IS_DRIVEN ? WORKS > 0 : IS_FREE };
    const double moved = s->energy_moved, allowance = HEALTHY * larger(1.0, s->steps / PER_STEPS);
    const double constraints = largest_residual(s, 0, HELD);
    const double missed = largest_residual(s, HELD, NCHECK);
    double tolerance = settings->fixed_step > 0.0 ? FIXED : settings->tolerance;
    /* where rows take over from others bodies go on where these hold: as far off as rows miss */
    if (s->fallbacks > 0.0 && missed > MISSES) tolerance = larger(tolerance, missed);
    const double limit = smaller(allowance * tolerance, MOST_LOST);
    const double correction_limit = smaller(allowance * larger(tolerance, LEAST), MOST_LOST);
    const double part = allowed_part(limit, settings, s);
    const double energy_limit = larger(part * moved, known_energy(s));
    /* without signs, so that errors of steps add up that are none in all */
    const double work_limit = larger(
        energy_limit, smaller(s->steps * tolerance, MOST_LOST) * moved);
    int doubts = beyond(s->not_finite, 0.0, PUBLIC(DOUBT_NOT_FINITE));
    doubts |= beyond(missed, CLEARLY * CLOSURE_TOLERANCE, PUBLIC(DOUBT_OPEN));
    if (settings->checks && KNOWS_ENERGY) {
        doubts |= beyond(s->energy_error, energy_limit, PUBLIC(DOUBT_ENERGY));
        if (settings->method == METHODS)
            doubts |= beyond(s->work_error, work_limit, PUBLIC(DOUBT_WORKS));
    }
    doubts |= beyond(constraints, correction_limit, PUBLIC(DOUBT_CONSTRAINTS));
    if (IS_FREE) { /* else corrections take away all of the error of a step or row */
        doubts |= beyond(s->drift, correction_limit, PUBLIC(DOUBT_DRIFT));
        doubts |= beyond(s->row_drift, correction_limit, PUBLIC(DOUBT_ROW_DRIFT));
    }
    doubts |= beyond(s->branch_points, 0.0, PUBLIC(DOUBT_BRANCH_POINTS));
    doubts |= beyond(s->unresolved, 0.0, PUBLIC(DOUBT_NARROW));
    doubts |= beyond(s->impulse, limit * fastest_or_nothing(s), PUBLIC(DOUBT_IMPULSE));
    *verdict = (Verdict){ doubts, limit, correction_limit, energy_limit, work_limit, constraints,
        missed };
}
