/* The four-bar of conftest.py: what a generated solver.c has, written by hand. */
#include <math.h>
#include <stddef.h>

#include "kinematics/tables.h"

#define PUBLIC(name) test_##name
#define DIGEST "written by hand"
#define LENGTH FRAME
#define WANTS_ANGLES 1

enum {
    INPUTS = 1,
    UNKNOWNS = 4,
    BLOCKS = 2,
    NODES = 2,
    LINKS = 3,
    SEGMENTS = 8,
    LARGEST_BLOCK = 2
};

enum {
    W_ALPHA = 0, W_X = 1, W_ALPHA_DOT = 5, W_X_DOT = 6, W_ALPHA_DDOT = 10, W_X_DDOT = 11,
    W_EPSILON = 15, W_D = 17, W_NU = 21, W_GAMMA = 23, W_POSITION = 25, W_VELOCITY = 29,
    W_ACCELERATION = 33, W_ANGLE = 37, W_ANGLE_DOT = 40, W_ANGLE_DDOT = 43, W_SIZE = 46
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
    double w[W_SIZE];
} Workspace;

static const Unknown unknowns[UNKNOWNS] = {
    {CRANK, 1.0, 0},
    {0.0, 1.0, 0},
    {PHI, COUPLER, 1},
    {PSI, ROCKER, 1},
};
static const Block blocks[BLOCKS] = {{0, 2, 0, 2, 0}, {2, 2, 2, 4, 4}};
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
static const double input_scales[INPUTS] = {CRANK};
static const Run defaults = {
    .max_iterations = 50, .limit = 1e-12, .divisions = 12, .rows = 13, .origin = {ALPHA}, .turns = {1}
};

const char *test_digest(void);
size_t test_run_size(void);
size_t test_workspace_size(void);
void test_defaults(Run *run);
int test_solve(Run *run, Workspace *workspace);
const char *test_message(int status);
void test_evaluate(size_t segment, double *w);

static const double quarter = 1.5707963267948966;

static void position_1(double *w)
{
    const double *alpha = w + W_ALPHA, *x = w + W_X;
    double *epsilon = w + W_EPSILON, *D = w + W_D;
    epsilon[0] = x[0] - CRANK * cos(alpha[0]);
    epsilon[1] = x[1] - CRANK * sin(alpha[0]);
    D[0] = D[3] = 1.0;
    D[1] = D[2] = 0.0;
}

static void velocity_1(double *w)
{
    const double alpha = w[W_ALPHA], rate = w[W_ALPHA_DOT];
    w[W_NU] = CRANK * cos(alpha + quarter) * rate;
    w[W_NU + 1] = CRANK * sin(alpha + quarter) * rate;
}

static void acceleration_1(double *w)
{
    const double alpha = w[W_ALPHA], rate = w[W_ALPHA_DOT], rate_dot = w[W_ALPHA_DDOT];
    w[W_GAMMA] = CRANK * cos(alpha + quarter) * rate_dot - CRANK * cos(alpha) * rate * rate;
    w[W_GAMMA + 1] = CRANK * sin(alpha + quarter) * rate_dot - CRANK * sin(alpha) * rate * rate;
}

static void position_2(double *w)
{
    const double *x = w + W_X;
    double *epsilon = w + W_EPSILON, *D = w + W_D;
    epsilon[0] = x[0] + COUPLER * cos(x[2]) - (ROCKER * cos(x[3]) + FRAME);
    epsilon[1] = x[1] + COUPLER * sin(x[2]) - ROCKER * sin(x[3]);
    D[0] = COUPLER * cos(x[2] + quarter);
    D[1] = -(ROCKER * cos(x[3] + quarter));
    D[2] = COUPLER * sin(x[2] + quarter);
    D[3] = -(ROCKER * sin(x[3] + quarter));
}

static void velocity_2(double *w)
{
    w[W_NU] = -w[W_X_DOT];
    w[W_NU + 1] = -w[W_X_DOT + 1];
}

static void acceleration_2(double *w)
{
    const double *x = w + W_X, *x_dot = w + W_X_DOT;
    const double phi = x_dot[2] * x_dot[2], psi = x_dot[3] * x_dot[3];
    w[W_GAMMA] = COUPLER * cos(x[2]) * phi - ROCKER * cos(x[3]) * psi - w[W_X_DDOT];
    w[W_GAMMA + 1] = COUPLER * sin(x[2]) * phi - ROCKER * sin(x[3]) * psi - w[W_X_DDOT + 1];
}

static void nodes(double *w)
{
    const double *x = w + W_X, *x_dot = w + W_X_DOT, *x_ddot = w + W_X_DDOT;
    const double c = cos(x[3]), s = sin(x[3]), square = x_dot[3] * x_dot[3];
    double *r = w + W_POSITION, *v = w + W_VELOCITY, *a = w + W_ACCELERATION;
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

static void angles(double *w)
{
    static const size_t given[] = {W_ALPHA, W_ALPHA_DOT, W_ALPHA_DDOT};
    static const size_t own[] = {W_X, W_X_DOT, W_X_DDOT};
    static const size_t out[] = {W_ANGLE, W_ANGLE_DOT, W_ANGLE_DDOT};
    for (size_t k = 0; k < 3; ++k) {
        w[out[k]] = w[given[k]];
        w[out[k] + 1] = w[own[k] + 2];
        w[out[k] + 2] = w[own[k] + 3];
    }
}

static void (*const segments[SEGMENTS])(double *) = {
    position_1, velocity_1, acceleration_1, position_2, velocity_2, acceleration_2, nodes, angles
};

#include "kinematics/solve.h"
