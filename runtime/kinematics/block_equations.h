/* The equations of the blocks: residuals, Jacobians, and the motion that they determine. */
#ifndef KOUSOKU_KINEMATICS_BLOCK_EQUATIONS_H
#define KOUSOKU_KINEMATICS_BLOCK_EQUATIONS_H

#include <string.h>

#include "lu.h"

/* the segments of a block, in their order; behind those of all blocks stand those of the results */
enum { POSITION, VELOCITY, ACCELERATION, ORDERS, RESULTS = ORDERS * BLOCKS };

static void run_segment(size_t number, size_t order, Workspace *w)
{
    segments[ORDERS * number + order](w->w);
}

static void copy(double *to, const double *from, size_t n) { memcpy(to, from, n * sizeof *to); }

/* puts a position where the segments look at it */
static void look_at(Workspace *w, const double *alpha, const double *x)
{
    copy(w->w + W_ALPHA, alpha, INPUTS);
    copy(w->w + W_X, x, UNKNOWNS);
}

/* the unknowns of a block where the segments look at them */
static double *looked_at(size_t number, Workspace *w) { return w->w + W_X + blocks[number].first; }

/* residuals of a block */
static void find_residuals(size_t number, Workspace *w, double *epsilon)
{
    run_segment(number, POSITION, w);
    copy(epsilon, w->w + W_EPSILON, blocks[number].size);
}

/* residuals of a block and the LU factors of its Jacobian; returns the smallest pivot */
static double evaluate(size_t number, Workspace *w, double *epsilon)
{
    const Block *block = &blocks[number];
    double *jacobian = w->matrix + block->jacobian;
    find_residuals(number, w, epsilon);
    copy(jacobian, w->w + W_D, block->size * block->size);
    return factorise(block->size, jacobian, w->pivot + block->first, unknowns + block->first);
}

/* solve with the factors that `evaluate` left; the right-hand side becomes the solution */
static void solve_block(size_t number, const Workspace *w, double *side)
{
    const Block *block = &blocks[number];
    substitute(block->size, w->matrix + block->jacobian, w->pivot + block->first, side);
}

/* derivatives of x at the position of the workspace, along given ones of the inputs, (22)-(25) */
static void differentiate(
    Workspace *w, const double *alpha_dot, const double *alpha_ddot, double *x_dot, double *x_ddot)
{
    look_at(w, w->alpha, w->x);
    copy(w->w + W_ALPHA_DOT, alpha_dot, INPUTS);
    copy(w->w + W_ALPHA_DDOT, alpha_ddot, INPUTS);
    for (size_t number = 0; number < BLOCKS; ++number) {
        const size_t first = blocks[number].first, n = blocks[number].size;
        run_segment(number, VELOCITY, w);
        solve_block(number, w, w->w + W_NU);
        copy(w->w + W_X_DOT + first, w->w + W_NU, n);
        run_segment(number, ACCELERATION, w);
        solve_block(number, w, w->w + W_GAMMA);
        copy(w->w + W_X_DDOT + first, w->w + W_GAMMA, n);
    }
    copy(x_dot, w->w + W_X_DOT, UNKNOWNS);
    copy(x_ddot, w->w + W_X_DDOT, UNKNOWNS);
}

#endif
