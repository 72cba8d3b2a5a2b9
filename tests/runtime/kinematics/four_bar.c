/* The four-bar of conftest.py: what a generated kernels.c has, written by hand. */
#include <math.h>
#include <stddef.h>

#include "kinematics/mechanism.h"

#define PUBLIC(name) test_##name
#define LENGTH FRAME
#define WANTS_ANGLES 1

enum {
    INPUTS = 1,
    UNKNOWNS = 4,
    BLOCKS = 2,
    NODES = 2,
    LINKS = 3,
    LARGEST_BLOCK = 2,
    LARGEST_KNOWN = 2
};

typedef struct Run {
    int method, max_iterations;
    double limit;
    long long divisions, start, first;
    size_t rows;
    double origin[1], span[1];
    long long turns[1];
    double rate[1], rate_dot[1];
    const double *times;
    double *alpha, *position, *velocity, *acceleration, *angle, *angle_dot, *angle_ddot;
    int *iterations;
    double *residual, *condition;
    size_t done, block;
    double reached[1];
} Run;

typedef struct Workspace {
    long long division;
    double time, step, alpha[1], rate[1], matrix[8], orientation[2];
    double x[4], x1[4], x2[4], trial[4];
    size_t pivot[4];
} Workspace;

static const Unknown unknowns[UNKNOWNS] = {
    {CRANK, 1.0, 0},
    {0.0, 1.0, 0},
    {PHI, COUPLER, 1},
    {PSI, ROCKER, 1},
};
static const Block blocks[BLOCKS] = {{0, 2, 0, 1, 0, 2, 0}, {2, 2, 1, 2, 2, 4, 4}};
/* A = crank (cos alpha, sin alpha), and the two arms of the loop in each of its rows */
#define A {{1, 1.0}}, {{2, 1.0}}
#define NONE {{0, 0.0}}, {{0, 0.0}}
static const Curve curves[] = {
    {0, 1, CRANK, A, {0, 1.0}},
    {1, 1, CRANK, A, {0, 1.0}},
    {0, 1, COUPLER, A, {3, 1.0}},
    {1, 1, COUPLER, A, {3, 1.0}},
    {0, 1, ROCKER, NONE, {4, 1.0}},
    {1, 1, ROCKER, NONE, {4, 1.0}},
};
static const size_t known_places[] = {0, 1, 2};
static const double input_scales[INPUTS] = {CRANK};
static const Run defaults = {.max_iterations = 50, .limit = 1e-12, .divisions = 12, .rows = 13};

size_t test_run_size(void);
size_t test_workspace_size(void);
void test_defaults(Run *run);
int test_solve(Run *run, Workspace *workspace);
const char *test_message(int status);

static const double quarter = 1.5707963267948966;

static void position_kernel(
    size_t number, const double *known, const double *x, double *epsilon, double *jacobian)
{
    if (number == 0) {
        epsilon[0] = x[0] - CRANK * cos(known[0]);
        epsilon[1] = x[1] - CRANK * sin(known[0]);
    } else {
        epsilon[0] = known[0] + COUPLER * cos(x[0]) - (ROCKER * cos(x[1]) + FRAME);
        epsilon[1] = known[1] + COUPLER * sin(x[0]) - ROCKER * sin(x[1]);
    }
    if (jacobian != NULL) {
        jacobian[0] = number ? COUPLER * cos(x[0] + quarter) : 1.0;
        jacobian[1] = number ? -(ROCKER * cos(x[1] + quarter)) : 0.0;
        jacobian[2] = number ? COUPLER * sin(x[0] + quarter) : 0.0;
        jacobian[3] = number ? -(ROCKER * sin(x[1] + quarter)) : 1.0;
    }
}

static void velocity_kernel(
    size_t number, const double *known, const double *x, const double *known_dot, double *nu)
{
    (void)x;
    nu[0] = number ? -known_dot[0] : CRANK * cos(known[0] + quarter) * known_dot[0];
    nu[1] = number ? -known_dot[1] : CRANK * sin(known[0] + quarter) * known_dot[0];
}

static void acceleration_kernel(
    size_t number, const double *known, const double *x, const double *known_dot,
    const double *x_dot, const double *known_ddot, double *gamma_)
{
    if (number == 0) {
        const double square = known_dot[0] * known_dot[0];
        gamma_[0] = CRANK * cos(known[0] + quarter) * known_ddot[0] - CRANK * cos(known[0]) * square;
        gamma_[1] = CRANK * sin(known[0] + quarter) * known_ddot[0] - CRANK * sin(known[0]) * square;
    } else {
        const double phi = x_dot[0] * x_dot[0], psi = x_dot[1] * x_dot[1];
        gamma_[0] = COUPLER * cos(x[0]) * phi - ROCKER * cos(x[1]) * psi - known_ddot[0];
        gamma_[1] = COUPLER * sin(x[0]) * phi - ROCKER * sin(x[1]) * psi - known_ddot[1];
    }
}

static void test_nodes(
    const double *alpha, const double *x, const double *alpha_dot, const double *x_dot,
    const double *alpha_ddot, const double *x_ddot, double *r, double *v, double *a)
{
    const double c = cos(x[3]), s = sin(x[3]), square = x_dot[3] * x_dot[3];
    (void)alpha, (void)alpha_dot, (void)alpha_ddot;
    for (size_t i = 0; i < 2; ++i) {
        r[i] = x[i];
        v[i] = x_dot[i];
        a[i] = x_ddot[i];
    }
    r[2] = ROCKER * c + FRAME;
    r[3] = ROCKER * s;
    v[2] = -ROCKER * s * x_dot[3];
    v[3] = ROCKER * c * x_dot[3];
    a[2] = -ROCKER * s * x_ddot[3] - ROCKER * c * square;
    a[3] = ROCKER * c * x_ddot[3] - ROCKER * s * square;
}

static void test_angles(
    const double *alpha, const double *x, const double *alpha_dot, const double *x_dot,
    const double *alpha_ddot, const double *x_ddot, double *angle, double *rate, double *rate_dot)
{
    const double *inputs[] = {alpha, alpha_dot, alpha_ddot}, *own[] = {x, x_dot, x_ddot};
    double *const out[] = {angle, rate, rate_dot};
    for (size_t k = 0; k < 3; ++k) {
        out[k][0] = inputs[k][0];
        out[k][1] = own[k][2];
        out[k][2] = own[k][3];
    }
}

#include "kinematics/solve.h"
