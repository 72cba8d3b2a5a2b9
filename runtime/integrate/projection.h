/* Projection onto the constraints, by Newton's method, and the accelerations there. */

/* a correction this small, relative to LENGTH, is rounding */
#define ROUNDING_CORRECTION 4e-16
/* Newton squares a correction this small away */
#define QUADRATIC_CORRECTION 1e-9
/* at a pivot ratio this much smaller than the largest so far accelerations are refined */
#define REFINED_PIVOT_RATIO 1e-4
/* so are they all along where the first of them are wrong by more than this part */
#define MOST_ACCELERATION_ERROR 2e-12
/* the same of any accelerations */
#define MOST_TEST_ERROR 2e-11
/* where a run begins with more than this part of that much, more may be lost on the way: there they
 * are looked at where steps end */
#define WATCHED_ERROR_PART 2e-2
#define LOOKED_AT 0.5
/* corrections in Newton's method, and steps of refinement */
enum { MOST_CORRECTIONS = 20 };
enum { MOST_REFINEMENTS = 4 };

static void correct_position(Work *work)
{
    double *w = work->w;
    if (HAS_ROW_SWITCH && work->row_switch.is_active != 0.0) solve_rows(w + W_C, work, w + W_DQ);
    else position(w);
}

static void correct_velocity(Work *work)
{
    double *w = work->w;
    if (HAS_ROW_SWITCH && work->row_switch.is_active != 0.0) {
        check(w);
        solve_rows(w + W_C_DOT, work, w + W_DV);
    } else {
        velocity(w);
    }
}

/* refines accelerations with the factors in the workspace until what is left is rounding */
static void refine(double *w)
{
    double before = HUGE_VAL;
    for (int n = 0; n < MOST_REFINEMENTS; ++n) {
        refinement(w);
        const double size = size_of(w + W_DV);
        if (!(size < 0.5 * before)) return;
        for (size_t k = 0; k < NV; ++k) w[W_V_DOT + k] += w[W_DV + k];
        for (size_t k = 0; HAS_REACTIONS && k != NC; ++k) w[W_LAM + k] += w[W_MORE_LAM + k];
        for (size_t k = 0; k != N_POWER; ++k) w[W_Q_DOT + NQ - N_POWER + k] += w[W_MORE_POWER + k];
        if (size <= ROUNDING_CORRECTION * size_of(w + W_V_DOT)) return;
        before = size;
    }
}

/* q_dot, v_dot and the multipliers. Where much of them was lost, they are brought nearer by
 * what is left of C_q v_dot = gamma: S = C_q M^-1 C_q^T squares the condition of C_q, which
 * this takes back */
static void accelerate(Work *work, State *s)
{
    const int has_all = HAS_ROW_SWITCH && work->row_switch.is_active != 0.0;
    if (has_all) accelerate_all_rows(work);
    else acceleration(work->w);
    if (!HAS_REFINEMENT) return;
    s->pivot_ratio = pivot_ratio(work, s);
    if (s->is_refined == 1.0 || s->pivot_ratio < REFINED_PIVOT_RATIO * s->largest_pivot_ratio) {
        s->refinements += 1;
        if (has_all) refine_all_rows(work);
        else refine(work->w);
    }
    if (HAS_DRIVERS && has_all) drive(work);
}

/* which part of accelerations in the workspace is not what rows ask for */
static double lost_part(double *w)
{
    refinement(w);
    return size_of(w + W_DV) / size_of(w + W_V_DOT);
}

/* has accelerations refined all along from here on, and those in the workspace: its derivative */
static void begin_refining(double *f, Work *work, State *s)
{
    s->is_refined = 1.0;
    accelerate(work, s);
    memcpy(f, work->w + W_Q_DOT, NQ * sizeof *f);
    memcpy(f + NQ, work->w + W_V_DOT, NV * sizeof *f);
}

/* notes whether accelerations lose digits where a run begins, as between very unequal masses: then
 * they are refined all along, or where few are lost looked at where steps end. Pivots tell of
 * digits that are lost in addition. At rest, or without a load, nothing is lost yet: so any
 * accelerations are brought onto the rows, too. */
static void note_lost_digits(Work *work, State *s)
{
    double *w = work->w, *v_dot = w + W_V_DOT;
    if (!HAS_REFINEMENT || (HAS_ROW_SWITCH && work->row_switch.is_active != 0.0)) return;
    double lost = lost_part(w) / MOST_ACCELERATION_ERROR;
    if (!(lost > 1.0)) {
        for (size_t k = 0; k < NV; ++k) v_dot[k] = (double)(k * 5 % 7) - 3.0;
        for (size_t k = 0; k < NV; ++k) v_dot[k] *= is_length[k] ? LENGTH : 1.0;
        refinement(w);
        for (size_t k = 0; k < NV; ++k) v_dot[k] += w[W_DV + k];
        lost = larger(lost, lost_part(w) / MOST_TEST_ERROR);
        memcpy(v_dot, s->f + NQ, NV * sizeof *w);
    }
    s->is_refined = lost > WATCHED_ERROR_PART ? LOOKED_AT : 0.0;
    if (lost > 1.0) begin_refining(s->f, work, s);
}

/* checks accelerations in the workspace, where some digits were lost before */
static void check_digits(double *f, Work *work, State *s)
{
    if (!HAS_REFINEMENT || s->is_refined != LOOKED_AT) return;
    if (HAS_ROW_SWITCH && work->row_switch.is_active != 0.0) return;
    if (lost_part(work->w) > MOST_ACCELERATION_ERROR) begin_refining(f, work, s);
}

/* the pivot ratio where accelerations were found last */
static double last_ratio(const Work *work, const State *s)
{
    return HAS_REFINEMENT ? s->pivot_ratio : pivot_ratio(work, s);
}

/* Newton on C(q) = 0, from the q in the workspace, until what is left is rounding, or enough: it is
 * the square of the correction before. The geometry in the workspace is then that of q. Returns the
 * first correction, negative if it does not converge. */
static double project_position(double enough, Work *work, double *low, State *s)
{
    double *w = work->w, first = 0.0, before = HUGE_VAL;
    memset(w + W_DQ, 0, NV * sizeof *w);
    displace(w, low);
    for (int k = 0; k < MOST_CORRECTIONS; ++k) {
        find_geometry(work, s);
        if (NC == 0) return 0.0;
        s->factorisations += 1;
        if (before * before <= enough) return first;
        correct_position(work);
        s->corrections += 1;
        const double size = size_of(w + W_DQ);
        if (!(size < HUGE_VAL)) return -1.0;
        if (k == 0) first = size;
        if (size <= ROUNDING_CORRECTION) return first;
        if (size >= 0.5 * before && (size <= QUADRATIC_CORRECTION || size <= blur_of(work, s)))
            return first;
        displace(w, low);
        before = size;
    }
    return -1.0;
}

/* brings y to the manifold, or near enough to it, and gives its derivative if f is not NULL, and
 * what rounding leaves over to low if that is not NULL; 0 where that is impossible */
static int project(
    double t, double enough, double *y, double *low, double *f, Work *work, State *s, double *drift)
{
    double *w = work->w;
    place(t, y, w);
    const double first = project_position(enough, work, low, s);
    if (!(first >= 0.0)) return 0;
    if (drift) *drift = first;
    if (NC > 0 || HAS_JOINT_COORDINATES) {
        correct_velocity(work);
        for (size_t k = 0; k < NV; ++k) {
            const double v = w[W_V + k], dv = w[W_DV + k];
            w[W_V + k] = v + dv;
            if (low) low[NQ + k] += rounding_of_sum(v, dv, v + dv);
        }
    }
    memcpy(y, w + W_Q, NQ * sizeof *y);
    memcpy(y + NQ, w + W_V, NV * sizeof *y);
    if (f) {
        accelerate(work, s);
        s->derivatives += 1;
        memcpy(f, w + W_Q_DOT, NQ * sizeof *f);
        memcpy(f + NQ, w + W_V_DOT, NV * sizeof *f);
        if (!are_finite(f, NY)) return 0;
    }
    return 1;
}

/* takes a part of what is normal to the constraints, at the geometry in the workspace, from a
 * displacement or a change of the velocity v: without all of it u is in the tangent space. Where
 * drivers lead it is added to v as large as v is, so that it is not lost in the rounding of fast
 * motions */
static void take_normal_part(double part, const double *v, Work *work, double *u)
{
    double *w = work->w;
    if (NC == 0 && !HAS_JOINT_COORDINATES) return;
    const double factor = HAS_DRIVERS ? larger(1.0, size_of(v)) : 1.0;
    for (size_t k = 0; k < NV; ++k) w[W_V + k] = HAS_DRIVERS ? v[k] + factor * u[k] : u[k];
    correct_velocity(work);
    for (size_t k = 0; k < NV; ++k) u[k] += part * (w[W_DV + k] / factor);
}

/* the displacements that belong to a small change of q */
static void displacement_of(const double *q, const double *dq, double *u)
{
    for (size_t k = 0; k != SHIFTS; ++k) u[shifts[k][1]] = dq[shifts[k][0]];
    for (size_t k = 0; k != ORIENTATIONS; ++k) {
        const double *p = q + orientations[k][0], *d = dq + orientations[k][0];
        double *theta = u + orientations[k][1];
        if (orientations[k][2] == 2) { /* in a plane */
            theta[0] = 2.0 * (p[0] * d[1] - p[1] * d[0]);
        } else { /* twice the vector part of the conjugate of p times dp */
            theta[0] = 2.0 * (p[0] * d[1] - p[1] * d[0] - p[2] * d[3] + p[3] * d[2]);
            theta[1] = 2.0 * (p[0] * d[2] - p[2] * d[0] - p[3] * d[1] + p[1] * d[3]);
            theta[2] = 2.0 * (p[0] * d[3] - p[3] * d[0] - p[1] * d[2] + p[2] * d[1]);
        }
    }
}

/* the pivot ratio at a q that need not be on the constraints; its geometry is then in the
 * workspace */
static double ratio_at(const double *q, Work *work, State *s)
{
    memcpy(work->w + W_Q, q, NQ * sizeof *q);
    memset(work->w + W_DQ, 0, NV * sizeof *q);
    displace(work->w, NULL);
    find_geometry(work, s);
    return pivot_ratio(work, s);
}
