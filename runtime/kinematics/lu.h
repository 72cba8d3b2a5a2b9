/* LU factorisation with row exchanges, and norms in which all unknowns count as lengths. */
#ifndef KOUSOKU_KINEMATICS_LU_H
#define KOUSOKU_KINEMATICS_LU_H

#include <math.h>
#include <stddef.h>

#include "tables.h"

/* LU factors of an (n, n) matrix in place; returns the smallest pivot, of columns scaled to
 * lengths, with the sign of the determinant: 0 is a dead centre, the sign is the side of it */
static double factorise(size_t n, double *matrix, size_t *pivot, const Unknown *unknown)
{
    double side = 1.0, weakest = HUGE_VAL;
    for (size_t k = 0; k < n; ++k) {
        size_t best = k;
        for (size_t i = k + 1; i < n; ++i) {
            if (fabs(matrix[i * n + k]) > fabs(matrix[best * n + k])) {
                best = i;
            }
        }
        pivot[k] = best;
        if (best != k) {
            for (size_t j = 0; j < n; ++j) {
                const double kept = matrix[k * n + j];
                matrix[k * n + j] = matrix[best * n + j];
                matrix[best * n + j] = kept;
            }
            side = -side;
        }
        const double size = fabs(matrix[k * n + k]) / unknown[k].scale;
        if (!(size > 0.0)) {
            return 0.0;
        }
        side = matrix[k * n + k] < 0.0 ? -side : side;
        weakest = size < weakest ? size : weakest;
        for (size_t i = k + 1; i < n; ++i) {
            const double factor = matrix[i * n + k] / matrix[k * n + k];
            matrix[i * n + k] = factor;
            for (size_t j = k + 1; j < n; ++j) {
                matrix[i * n + j] -= factor * matrix[k * n + j];
            }
        }
    }
    return side * weakest;
}

/* forward and back substitution; b becomes the solution */
static void substitute(size_t n, const double *matrix, const size_t *pivot, double *b)
{
    for (size_t k = 0; k < n; ++k) {
        const double moved = b[pivot[k]];
        b[pivot[k]] = b[k];
        b[k] = moved;
    }
    for (size_t i = 1; i < n; ++i) {
        for (size_t j = 0; j < i; ++j) {
            b[i] -= matrix[i * n + j] * b[j];
        }
    }
    for (size_t i = n; i-- > 0;) {
        for (size_t j = i + 1; j < n; ++j) {
            b[i] -= matrix[i * n + j] * b[j];
        }
        b[i] /= matrix[i * n + i];
    }
}

/* the larger of two magnitudes; NaN and infinity come out as infinity */
static double larger(double most, double size)
{
    if (size <= most) {
        return most;
    }
    return size < HUGE_VAL ? size : HUGE_VAL;
}

/* largest magnitude of n residuals */
static double largest_residual(size_t n, const double *epsilon)
{
    double most = 0.0;
    for (size_t k = 0; k < n; ++k) {
        most = larger(most, fabs(epsilon[k]));
    }
    return most;
}

/* largest length that n corrections move */
static double largest_correction(size_t n, const double *correction, const Unknown *unknown)
{
    double most = 0.0;
    for (size_t k = 0; k < n; ++k) {
        most = larger(most, fabs(correction[k]) * unknown[k].scale);
    }
    return most;
}

#endif
