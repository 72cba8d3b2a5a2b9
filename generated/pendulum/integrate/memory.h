/* The memory that a caller owns: the state of a run, which solver.h lays out, and the workspace. */

/* what a call returns, without the prefix of the scene */
enum { GOOD = PUBLIC(GOOD), BUFFER_FULL = PUBLIC(BUFFER_FULL), PAUSED = PUBLIC(PAUSED) };
enum { EVENT = PUBLIC(EVENT), STOPPED = PUBLIC(STOPPED), NOT_CLOSED = PUBLIC(NOT_CLOSED) };
enum { BAD_ARGUMENT = PUBLIC(BAD_ARGUMENT), WRONG_STATE = PUBLIC(WRONG_STATE) };
enum { NOT_ASSEMBLED = PUBLIC(NOT_ASSEMBLED), NOT_PROJECTED = PUBLIC(NOT_PROJECTED) };
enum {
    STEP_TOO_SMALL = PUBLIC(STEP_TOO_SMALL),
    NO_VALUE = PUBLIC(NO_VALUE),
    BENDS = PUBLIC(BENDS),
    INFINITE = PUBLIC(INFINITE),
    DEPENDENT = PUBLIC(DEPENDENT),
    NO_DIRECTION = PUBLIC(NO_DIRECTION)
};

/* violation, in closure tolerances, above which a dropped row is not redundant */
#define CLEARLY 10.0
/* tolerances are from this one on, and below 1; run_arguments.py has it, too */
#define LEAST_TOLERANCE 1e-15
/* motion of bodies in a step, in lengths of the scene or radians, up to which they count as at
 * rest: velocities are then compared with it */
#define NOTHING_MOVES 1e-4
/* time that is no longer than rounding of times, in smallest steps: settings.py has it, too */
#define NO_TIME 8.0
/* part of a rate by which it changes unevenly within this time where its law bends: settings.py has
 * it, too */
#define BENT 1e-6

typedef PUBLIC(settings) Settings;
typedef PUBLIC(state) State;
typedef PUBLIC(verdict) Verdict;

enum {
    NY = NQ + NV, /* count of numbers in y */
    WAY = 12,     /* count of coefficients of a polynomial through a step, see branches.h */
    ALL_ROWS = HAS_ROW_SWITCH * NCHECK,
    FREE_ROWS = HAS_ROW_SWITCH * (NCHECK - NC), /* rows that are not solved for */
    MISSED_ROWS = HAS_MISSES * (NCHECK - NC)    /* those that may miss more than rounding */
};

/* all rows of the constraints, where they take over: see row_switch.h */
typedef struct {
    double is_active; /* whether all rows were factorised */
    double ratio;     /* their pivot ratio */
    double tried;     /* that of the rows kept where all were no better, or 0 */
    double rows[ROOM(ALL_ROWS)][ROOM(NV)];         /* C_q */
    double matrix[ROOM(ALL_ROWS)][ROOM(ALL_ROWS)]; /* C_q M^-1 C_q^T, then its factors */
    double order[ROOM(ALL_ROWS)];                  /* in which rows are solved for */
    double solution[ROOM(ALL_ROWS)];
    double lam[ROOM(ALL_ROWS)];   /* multipliers */
    double rates[ROOM(ALL_ROWS)]; /* of the rows at rest, -nu */
    double v[ROOM(NV)];
    /* for forces of joints: multipliers that move no body, and what they are in forces */
    double ways[ROOM(FREE_ROWS)][ROOM(ALL_ROWS)];
    double wrenches[ROOM(FREE_ROWS)][ROOM(N_WRENCHES)];
    double square[ROOM(FREE_ROWS)][ROOM(FREE_ROWS)];
    double mu[ROOM(FREE_ROWS)];
} RowSwitch;

/* rows whose rank is looked at, scaled: see rank.h */
typedef struct {
    double rows[ROOM(RANK_ROWS)][ROOM(HAS_RANK * NV)]; /* C_q, then a basis */
    double columns_by[ROOM(HAS_RANK * NV)], rows_by[ROOM(RANK_ROWS)], rates[ROOM(RANK_ROWS)];
} Rank;

typedef struct {
    double w[W_SIZE];                  /* the workspace of the scene, at the places W_... */
    double k[STAGES][ROOM(NY)];        /* derivatives of the stages */
    double y[ROOM(NY)], low[ROOM(NY)]; /* end of a step, and what its rounding leaves over */
    double scratch[ROOM(NY)], u[ROOM(NY)];
    double missed[ROOM(MISSED_ROWS)];                 /* at the end of a step, what they miss */
    double way[ROOM(HAS_REFINEMENT * WAY)][ROOM(NQ)]; /* that of a step: see branches.h */
    RowSwitch row_switch;
    Rank rank;
} Work;

/* writes what no step changes: the numbers of the scene, and the parameters of the run */
static void prepare(const double *parameters, double *w)
{
    memcpy(w + W_CONSTANTS, constants, CONSTANTS * sizeof *w);
    memcpy(w + W_PARAMETERS, parameters, N_PARAMETERS * sizeof *w);
    if (HAS_DESIGN) setup(w);
}

/* puts a state into the workspace */
static void place(double t, const double *y, double *w)
{
    w[W_T] = t;
    memcpy(w + W_Q, y, NQ * sizeof *w);
    memcpy(w + W_V, y + NQ, NV * sizeof *w);
}

/* moves q by the correction in the workspace and brings Euler parameters back to norm one; what
 * rounding leaves over of lengths is added to low if it is not NULL */
static void displace(double *w, double *low)
{
    move(w);
    for (size_t k = 0; low && k != ADDED; ++k) {
        const size_t i = shifts[k][0];
        low[i] += rounding_of_sum(w[W_Q + i], w[W_DQ + shifts[k][1]], w[W_Q_MOVED + i]);
    }
    memcpy(w + W_Q, w + W_Q_MOVED, NQ * sizeof *w);
}

/* what makes a mass [kg] of the inverse of a row's pivot, 1 or 1/m^2: that of an angle is a moment
 * of inertia, which is compared with masses at LENGTH, so that units of length decide nothing */
static double inverse_pivot_factor(size_t row)
{
    const double x = row_is_length[row] ? 1.0 : 1.0 / LENGTH;
    return x * x;
}

/* the largest element of a correction, lengths relative to LENGTH */
static double size_of(const double *u)
{
    double size = 0.0;
    for (size_t k = 0; k < NV; ++k) {
        const double x = is_length[k] ? fabs(u[k]) / LENGTH : fabs(u[k]);
        if (x > size || isnan(x)) size = x; /* a NaN stays */
    }
    return size;
}

/* how far bodies move in a step of length h from y to an end, in lengths and radians */
static double way_of(double h, const double *y, const double *end)
{
    return h * larger(size_of(y + NQ), size_of(end + NQ));
}
