/* What a scene lacks.
 *
 * solver.c defines counts, places in the workspace, tables and segments of what the scene has, and
 * a macro that is 1 for each part that other scenes may lack. Parts that it lacks are 0 here, with
 * their counts and places, and their segments do nothing: the compiler drops all that is only for
 * them. */
#ifndef KOUSOKU_INTEGRATE_LACKING_H
#define KOUSOKU_INTEGRATE_LACKING_H

/* C has no empty arrays */
#define ROOM(n) ((n) > 0 ? (n) : 1)

/* numbers that are put into the workspace, where tasks read them; numbers that formulas depend on,
 * and a run may vary */
#ifndef HAS_CONSTANTS
#define CONSTANTS 0
#define W_CONSTANTS 0
#endif
#ifndef HAS_PARAMETERS
#define N_PARAMETERS 0
#define W_PARAMETERS 0
#endif

/* the design: numbers of the scene that depend on parameters; what begins there, and what must be
 * positive */
#ifndef HAS_DESIGN
#define HAS_DESIGN 0
#define N_DESIGN 0
#define STARTS 0
#define POSITIVE 0
#define W_DESIGN 0
static void setup(double *w) { (void)w; }
#endif

/* entries at the end of q that are works, and those that count turns; momenta that are constant */
#ifndef HAS_WORKS
#define WORKS 0
#endif
#ifndef HAS_UNWRAPPED_ANGLES
#define UNWRAPPED_ANGLES 0
#define UNWRAPPED_ANGLES_END 0
#endif
#ifndef HAS_MOMENTA
#define MOMENTA 0
#define W_MOMENTA 0
static void momentum(double *w) { (void)w; }
#endif

/* rows of the constraints that are solved for; whether bodies are put onto joints with the ground,
 * whether constraints depend on time, and whether they leave no freedom */
#ifndef HAS_ROWS
#define NC 0
static void position(double *w) { memset(w + W_DQ, 0, NV * sizeof *w); }
#endif
#ifndef HAS_JOINT_COORDINATES
#define HAS_JOINT_COORDINATES 0
#endif
#ifndef HAS_DRIVERS
#define HAS_DRIVERS 0
#endif
#ifndef IS_DRIVEN
#define IS_DRIVEN 0
#endif

/* rows whose rank is looked at where parameters are given */
#ifndef HAS_RANK
#define HAS_RANK 0
#define RANK_ROWS 0
#endif

/* rows that are left out and may miss more than rounding, and that take over where others lose
 * rank; inverse masses of the design; the refinement of accelerations where they lose digits */
#ifndef HAS_MISSES
#define HAS_MISSES 0
#endif
#ifndef HAS_ROW_SWITCH
#define HAS_ROW_SWITCH 0
#endif
#if !(HAS_ROW_SWITCH && HAS_DRIVERS)
#define DRIVERS 0
#endif
#ifndef HAS_VARYING_MASSES
#define HAS_VARYING_MASSES 0
#endif
#ifndef HAS_REFINEMENT
#define HAS_REFINEMENT 0
static void refinement(double *w) { (void)w; }
#endif
#if !(HAS_REFINEMENT && HAS_DRIVERS)
#define N_POWER 0
#define W_MORE_POWER 0
#endif

/* parts of a row: forces of joints, which loops share out where many rows are dependent, energies,
 * coordinates; whether any of them needs accelerations */
#ifndef HAS_REACTIONS
#define HAS_REACTIONS 0
#define W_LAM 0
#endif
#if !(HAS_REFINEMENT && HAS_REACTIONS)
#define W_MORE_LAM 0
#endif
#ifndef SHARES_OUT
#define SHARES_OUT 0
#endif
#if !HAS_REACTIONS || SHARES_OUT
static void reaction(double *w) { (void)w; }
#endif
#ifndef HAS_WRENCHES
#define N_WRENCHES 0
#define W_ALL_LAM 0
#define W_WRENCHES 0
static void wrench(double *w) { (void)w; }
#endif
#ifndef HAS_ENERGIES
#define HAS_ENERGIES 0
#endif
#ifndef HAS_COORDINATES
#define N_SHOWN 0
#define PER_SHOWN 0
#define W_COORDINATES 0
static void coordinate(double *w) { (void)w; }
#endif
#ifndef ACCELERATES
#define ACCELERATES 0
#endif

/* formulas of time that switch or vary; gaps and laws of drivers; events, and formulas of the
 * state that do so */
#ifndef HAS_SWITCHING
#define N_SWITCHES 0
#define N_FEATURES 0
#define W_SPAN 0
#define W_SWITCHES 0
#define W_FEATURES 0
static void switching(double *w) { (void)w; }
#endif
#ifndef HAS_GAPS
#define N_GAPS 0
#define W_GAPS 0
#endif
#ifndef HAS_BENDING
#define N_LAWS 0
#define W_LAW_SPAN 0
#define W_LAWS 0
static void bending(double *w) { (void)w; }
#endif
#ifndef HAS_MEASURE
#define N_MEASURES 0
#define W_MEASURES 0
static void measure(double *w) { (void)w; }
#endif
#ifndef HAS_DISTANCE
#define N_LENGTHS 0
#define N_DISTANCES 0
#define W_LENGTHS 0
#define W_DISTANCES 0
#endif
#ifndef HAS_FRACTIONAL_POWERS /* of what may be zero, in forces */
#define HAS_FRACTIONAL_POWERS 0
#endif
#ifndef HAS_BREAKS
#define N_BREAKS 0
#define W_BREAKS 0
#endif
#ifndef HAS_CROSSING
#define N_CROSSINGS 0
#define N_POLES 0
#define N_NARROW 0
#define N_INFINITE 0
#define EVENTS 0
#define W_RANGES 0
#define W_CROSSINGS 0
#define W_POLES 0
#define W_NARROW 0
static void crossing(double *w) { (void)w; }
#endif

/* The tables. A scene defines those that have rows; of the others these declarations, which are
 * tentative definitions, make zeros. */
static const double constants[ROOM(CONSTANTS)];
/* values of the parameters, unless a run is given others */
static const double values[ROOM(N_PARAMETERS)];
/* for each velocity whether it is that of a length; what changes of q are compared with */
static const unsigned char is_length[ROOM(NV)];
static const double floor_of[ROOM((IS_DRIVEN || HAS_RANK) * NQ)];
/* where each length is in q and v; where Euler parameters are in q, their turn in v, their count */
static const size_t shifts[ROOM(SHIFTS)][2];
static const size_t orientations[ROOM(ORIENTATIONS)][3];
/* the parts of a row behind time, q and v: places and sizes */
static const size_t parts[ROOM(PARTS)][2];
/* for the row switch-over: the diagonal of M^-1; where it is in the design, or -1; rows of drivers,
 * and where their works are in q */
static const double inverse_masses[ROOM(HAS_ROW_SWITCH * NV)];
static const int mass_places[ROOM(HAS_VARYING_MASSES * NV)];
static const size_t drivers[ROOM(DRIVERS)][2];
/* what depends on parameters at the start: places in y and in the design; what must be positive */
static const size_t starts[ROOM(STARTS)][2];
static const size_t positive[ROOM(POSITIVE)];
/* for each row of the constraints whether its residual is a length */
static const unsigned char row_is_length[ROOM(NCHECK)];
/* of rows whose rank is looked at: which, and whether they are left out */
static const size_t rank_rows[ROOM(RANK_ROWS)][2];
/* what errors of measures are compared with */
static const double measure_sizes[ROOM(N_MEASURES)];
/* what variations of features, and of narrow parts, are compared with, and 1 where that is over the
 * square of times */
static const double feature_scales[ROOM(N_FEATURES)][2];
static const double narrow_scales[ROOM(N_NARROW)][2];
/* of events the direction, what a run does then, and whether the formula may jump */
static const int events[ROOM(EVENTS)][3];
enum { RECORD, COUNT, STOP }; /* what that may be */

#endif
