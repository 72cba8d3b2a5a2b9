/* The equations of the blocks: residuals, Jacobians, and the motion that they determine. */
#ifndef KOUSOKU_KINEMATICS_EQUATIONS_H
#define KOUSOKU_KINEMATICS_EQUATIONS_H

#include "lu.h"

/* All coordinates of the mechanism, or their first or second derivatives. */
typedef struct Coordinates {
    const double *alpha; /* of the inputs */
    const double *x;     /* of the unknowns */
} Coordinates;

/* what a block depends on */
static void gather(const Block *block, Coordinates all, double *known)
{
    for (size_t k = 0; k < block->known_count; ++k) {
        const size_t place = known_places[block->known + k];
        known[k] = place < INPUTS ? all.alpha[place] : all.x[place - INPUTS];
    }
}

/* residuals of a block and, unless it is NULL, its Jacobian */
static void position_equations(
    size_t number, Coordinates position, double *epsilon, double *jacobian)
{
    const Block *block = &blocks[number];
    double known[LARGEST_KNOWN];
    gather(block, position, known);
    position_kernel(number, known, position.x + block->first, epsilon, jacobian);
}

/* right-hand side of the velocities of a block, (22) and (24) */
static void velocity_equations(
    size_t number, Coordinates position, Coordinates velocity, double *nu)
{
    const Block *block = &blocks[number];
    double known[LARGEST_KNOWN], known_dot[LARGEST_KNOWN];
    gather(block, position, known);
    gather(block, velocity, known_dot);
    velocity_kernel(number, known, position.x + block->first, known_dot, nu);
}

/* right-hand side of the accelerations of a block, (23) and (25) */
static void acceleration_equations(size_t number, Coordinates position, Coordinates velocity,
    Coordinates acceleration, double *gamma_)
{
    const Block *block = &blocks[number];
    double known[LARGEST_KNOWN], known_dot[LARGEST_KNOWN], known_ddot[LARGEST_KNOWN];
    gather(block, position, known);
    gather(block, velocity, known_dot);
    gather(block, acceleration, known_ddot);
    acceleration_kernel(number, known, position.x + block->first, known_dot,
        velocity.x + block->first, known_ddot, gamma_);
}

/* residuals of a block and the LU factors of its Jacobian; returns the smallest pivot */
static double evaluate(size_t number, Coordinates position, Workspace *w, double *epsilon)
{
    const Block *block = &blocks[number];
    double *jacobian = w->matrix + block->jacobian;
    position_equations(number, position, epsilon, jacobian);
    return factorise(block->size, jacobian, w->pivot + block->first, unknowns + block->first);
}

/* solve with the factors that `evaluate` left; the right-hand side becomes the solution */
static void solve_block(size_t number, const Workspace *w, double *side)
{
    const Block *block = &blocks[number];
    substitute(block->size, w->matrix + block->jacobian, w->pivot + block->first, side);
}

/* derivatives of x at the position of the workspace, along given ones of the inputs */
static void differentiate(const Workspace *w, const double *alpha_dot, const double *alpha_ddot,
    double *x_dot, double *x_ddot)
{
    const Coordinates position = { w->alpha, w->x };
    const Coordinates velocity = { alpha_dot, x_dot }, acceleration = { alpha_ddot, x_ddot };
    for (size_t number = 0; number < BLOCKS; ++number) {
        const size_t first = blocks[number].first, n = blocks[number].size;
        double side[LARGEST_BLOCK];
        velocity_equations(number, position, velocity, side);
        solve_block(number, w, side);
        for (size_t i = 0; i < n; ++i) {
            x_dot[first + i] = side[i];
        }
        acceleration_equations(number, position, velocity, acceleration, side);
        solve_block(number, w, side);
        for (size_t i = 0; i < n; ++i) {
            x_ddot[first + i] = side[i];
        }
    }
}

#endif
