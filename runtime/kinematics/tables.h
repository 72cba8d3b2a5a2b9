/* Records of the tables that describe a mechanism: its unknown coordinates and its blocks. */
#ifndef KOUSOKU_KINEMATICS_TABLES_H
#define KOUSOKU_KINEMATICS_TABLES_H

#include <stddef.h>

/* An unknown coordinate. */
typedef struct Unknown {
    double start; /* near the position of the scene */
    double scale; /* length that a change by 1 moves */
    int is_angle;
} Unknown;

/* A part of a sum of coordinates, whose places are among the inputs and, after them, all unknowns;
 * the factor is 0 where there is none. */
typedef struct Term {
    size_t place;
    double factor;
} Term;

/* A link that bends an equation: all that a block has of second derivatives.
 *
 * With d = (sum of x, sum of y) from its first to its second node, the equation is |d| = length,
 * or with an arm one of d = length (cos beta, sin beta), in any direction. */
typedef struct Curve {
    size_t row; /* of the block */
    int is_arm;
    double length;
    Term x[2], y[2], angle;
} Curve;

/* A block of the block-triangular equations: unknowns that are solved together.
 *
 * Its coordinates are x[first] ... x[first + size - 1]; curve_count links stand in curves from
 * `curve` on; its Jacobian begins at `jacobian` in the workspace. */
typedef struct Block {
    size_t first, size;
    size_t curve, curve_count;
    size_t jacobian;
} Block;

#endif
