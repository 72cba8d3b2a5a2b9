/* Records of the tables that describe a mechanism: its unknown coordinates and its blocks. */
#ifndef KOUSOKU_KINEMATICS_MECHANISM_H
#define KOUSOKU_KINEMATICS_MECHANISM_H

#include <stddef.h>

/* An unknown coordinate. */
typedef struct Unknown {
    double start; /* near the first position */
    double scale; /* length that a change by 1 moves */
    int is_angle;
} Unknown;

/* A block of the block-triangular equations: unknowns that are solved together.
 *
 * Its coordinates are x[first] ... x[first + size - 1]; known_count places among the inputs and,
 * after them, all unknowns stand in known_places from `known` on; its Jacobian begins at
 * `jacobian` in the workspace. */
typedef struct Block {
    size_t first, size;
    size_t known, known_count;
    size_t jacobian;
} Block;

#endif
