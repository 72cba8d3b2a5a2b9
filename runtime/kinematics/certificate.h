/* Certificate of a step: that the position it leads to is on the branch it came from.
 *
 * Along a step, s from 0 to 1, coordinates are taken to go by cubics: value and two derivatives as
 * where it began, value as where it ended. The equations of links leave little there, and bounds of
 * their derivatives are known exactly, so that the theorem of Newton and Kantorovich (Krawczyk's
 * form of it, with the inverse Jacobian of where the step ended) can tell that in a tube around
 * them, at every s, there is one solution and no singular Jacobian. Its solutions are the way from
 * the one end to the other; no assembly but the one that was followed is reached by it. */
#ifndef KOUSOKU_KINEMATICS_CERTIFICATE_H
#define KOUSOKU_KINEMATICS_CERTIFICATE_H

#include "block_equations.h"
#include "status.h"

/* of s^3 - s^4 the most in [0, 1]; s^3 - s^(3 + m) is at most m times as much */
#define CUBIC_END (27.0 / 256.0)
/* of s - s^2 and s - s^3 the most in [0, 1] */
#define SQUARE_BOW 0.25
#define CUBIC_BOW 0.385

/* Where inputs and, after them, unknowns go along a step: x(0) + first s + second s^2 + third s^3,
 * and how far from there they are at most, found block after block. */
typedef struct CubicTube {
    double first[INPUTS + UNKNOWNS], second[INPUTS + UNKNOWNS], third[INPUTS + UNKNOWNS];
    double radius[INPUTS + UNKNOWNS];
} CubicTube;

/* What a curve does to its equation: what the cubics leave of it, how its row of the Jacobian turns
 * along the step, and how much more for each length that unknowns are off, all at most. */
typedef struct Bend {
    double error, turn, more;
} Bend;

/* A sum of coordinates along a way: its coefficients, how far it is off by what is known, and how
 * far unknowns of the block move it that are off by a length of 1. */
typedef struct Sum {
    double first, second, third, off, reach;
} Sum;

static Sum sum_along(size_t number, const CubicTube *way, size_t count, const Term *terms)
{
    const size_t own = INPUTS + blocks[number].first, end = own + blocks[number].size;
    Sum sum = { 0.0, 0.0, 0.0, 0.0, 0.0 };
    for (size_t k = 0; k < count; ++k) {
        const size_t place = terms[k].place;
        const double factor = terms[k].factor;
        sum.first += factor * way->first[place];
        sum.second += factor * way->second[place];
        sum.third += factor * way->third[place];
        if (place < own || place >= end) {
            sum.off += fabs(factor) * way->radius[place];
        } else {
            sum.reach += fabs(factor) / unknowns[place - INPUTS].scale;
        }
    }
    return sum;
}

/* of |d| = length, as (|d|^2 - length^2) / 2 length, a polynomial of s: what it has of s^3 to s^6
 * vanishes together at s = 1 */
static Bend bend_of_distance(double length, Sum x, Sum y)
{
    const double fourth = fabs(
        x.second * x.second + y.second * y.second + 2.0 * (x.first * x.third + y.first * y.third));
    const double fifth = fabs(2.0 * (x.second * x.third + y.second * y.third));
    const double sixth = x.third * x.third + y.third * y.third;
    const double left = 0.5 * CUBIC_END * (fourth + 2.0 * fifth + 3.0 * sixth) / length;
    const double off = hypot(x.off, y.off), reach = hypot(x.reach, y.reach);
    const double bow = SQUARE_BOW * hypot(x.second, y.second) +
                       CUBIC_BOW * hypot(x.third, y.third) + off;
    const double error = left + off * (1.0 + (left + off) / length);
    return (Bend){ error, bow * reach / length, reach * reach / length };
}

/* of d = length (cos beta, sin beta), by the fourth derivative of the direction */
static Bend bend_of_arm(double length, Sum x, Sum y, Sum angle)
{
    const double a = fabs(angle.first), b = fabs(angle.second), c = fabs(angle.third);
    const double rate = a + 2.0 * b + 3.0 * c, bend = 2.0 * b + 6.0 * c, jerk = 6.0 * c;
    const double rate_2 = rate * rate;
    const double fourth = rate_2 * rate_2 + 6.0 * rate_2 * bend + 3.0 * bend * bend +
                          4.0 * rate * jerk;
    const double off = hypot(x.off, y.off) + length * angle.off;
    const double error = length * fourth * (CUBIC_END / 24.0) + off;
    const double swept = fabs(angle.first + angle.second + angle.third) + SQUARE_BOW * b +
                         CUBIC_BOW * c;
    const double swing = length * angle.reach;
    return (Bend){ error, swing * swept, swing * angle.reach };
}

/* what the curves do to the equations of a block; how distances turn their rows from one end of
 * the step to the other stands in `slope` with its signs */
static void bend_rows(size_t number, const CubicTube *way, Bend *rows, double *slope)
{
    const Block *block = &blocks[number];
    const size_t own = INPUTS + block->first, n = block->size;
    for (size_t k = 0; k < block->curve_count; ++k) {
        const Curve *curve = &curves[block->curve + k];
        const Sum x = sum_along(number, way, 2, curve->x), y = sum_along(number, way, 2, curve->y);
        const Bend bend = curve->is_arm ? bend_of_arm(curve->length, x, y,
                                              sum_along(number, way, 1, &curve->angle))
                                        : bend_of_distance(curve->length, x, y);
        rows[curve->row].error += bend.error;
        rows[curve->row].turn += bend.turn;
        rows[curve->row].more += bend.more;
        for (size_t j = 0; !curve->is_arm && j < 4; ++j) {
            const Term term = j < 2 ? curve->x[j] : curve->y[j - 2];
            const Sum side = j < 2 ? x : y;
            if (term.place >= own && term.place < own + n) {
                slope[curve->row * n + term.place - own] +=
                    term.factor * (side.first + side.second + side.third) / curve->length;
            }
        }
    }
}

/* solve with the factors at hand, and make the solution lengths */
static void solve_lengths(size_t number, const Workspace *w, double *side)
{
    const Unknown *own = unknowns + blocks[number].first;
    solve_block(number, w, side);
    for (size_t i = 0; i < blocks[number].size; ++i) {
        side[i] = fabs(side[i]) * own[i].scale;
    }
}

/* how far the unknowns of a block are moved by a residual of 1 in one of its rows */
static void moved_by_row(size_t number, const Workspace *w, size_t row, double *side)
{
    for (size_t i = 0; i < blocks[number].size; ++i) {
        side[i] = i == row;
    }
    solve_lengths(number, w, side);
}

/* the most that residuals of 1 move unknowns, as lengths, with the factors at hand */
static double condition_of(const Workspace *w)
{
    double most = 0.0;
    for (size_t number = 0; number < BLOCKS; ++number) {
        double sums[LARGEST_BLOCK] = { 0.0 }, side[LARGEST_BLOCK];
        for (size_t k = 0; k < blocks[number].size; ++k) {
            moved_by_row(number, w, k, side);
            for (size_t i = 0; i < blocks[number].size; ++i) {
                sums[i] += side[i];
            }
        }
        most = larger(most, largest_residual(blocks[number].size, sums));
    }
    return most;
}

/* with the factors of where the step ended, how far the Jacobian of a block turns in the tube,
 * relative to itself; `residual` is left of the equations at both ends */
static double tilt_of(size_t number, const Workspace *w, CubicTube *way, double residual)
{
    const size_t first = blocks[number].first, n = blocks[number].size;
    const Unknown *own = unknowns + first;
    Bend rows[LARGEST_BLOCK], sums[LARGEST_BLOCK], most = { 0.0, 0.0, 0.0 };
    double slope[LARGEST_BLOCK * LARGEST_BLOCK] = { 0.0 }, side[LARGEST_BLOCK];
    for (size_t i = 0; i < n; ++i) {
        rows[i] = (Bend){ residual, 0.0, 0.0 };
        sums[i] = (Bend){ 0.0, 0.0, 0.0 };
    }
    bend_rows(number, way, rows, slope);
    for (size_t k = 0; k < n; ++k) {
        moved_by_row(number, w, k, side);
        for (size_t i = 0; i < n; ++i) {
            sums[i].error += side[i] * rows[k].error;
            sums[i].turn += side[i] * rows[k].turn;
            sums[i].more += side[i] * rows[k].more;
            side[i] = slope[i * n + k];
        }
        solve_lengths(number, w, side);
        for (size_t i = 0; i < n; ++i) {
            sums[i].turn += side[i] / own[k].scale;
        }
    }
    for (size_t i = 0; i < n; ++i) {
        most.error = larger(most.error, sums[i].error);
        most.turn = larger(most.turn, sums[i].turn);
        most.more = larger(most.more, sums[i].more);
    }
    const double tilt = most.turn + most.more * most.error / (1.0 - MOST_TILT);
    for (size_t i = 0; i < n; ++i) {
        way->radius[INPUTS + first + i] = most.error / (1.0 - tilt) / own[i].scale;
    }
    return tilt;
}

#endif
