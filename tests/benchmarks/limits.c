/* What a processor can do at most: products and sums in registers, numbers read and written.
 * KOUSOKU_LANES=1 makes it scalar; without -ffp-contract=off a product and a sum become one. */
#include "lanes.h"

#define EACH(X) X(0) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9) X(10) X(11)
enum { CHAINS = 12 };

/* products and sums: chains that do not wait for each other, each on one vector */
size_t operations(size_t rounds, double *found);
size_t operations(size_t rounds, double *found)
{
    const vec a = NUMBER(found[0]), b = NUMBER(found[1]);
#define START(k) vec y##k = NUMBER(found[2] + k);
    EACH(START)
    for (size_t n = 0; n < rounds; ++n) {
#define STEP(k) y##k = y##k * a + b;
        EACH(STEP)
    }
#define ADD(k) sum += y##k;
    vec sum = NUMBER(0.0);
    EACH(ADD)
    *(vec *)(found + 8) = sum;
    return rounds * CHAINS * LANES * 2;
}

/* bytes: y = x / 2, and y = a + b / 2, over again; in whole vectors, as batches in lanes are */
void scale(size_t passes, size_t blocks, const double *x, double *y);
void scale(size_t passes, size_t blocks, const double *x, double *y)
{
    const vec *from = (const vec *)x;
    vec *to = (vec *)y;
    for (size_t k = 0; k < passes; ++k) {
        for (size_t n = 0; n < blocks; ++n) to[n] = NUMBER(0.5) * from[n];
    }
}

void triad(size_t passes, size_t blocks, const double *a, const double *b, double *y);
void triad(size_t passes, size_t blocks, const double *a, const double *b, double *y)
{
    const vec *x = (const vec *)a, *z = (const vec *)b;
    vec *to = (vec *)y;
    for (size_t k = 0; k < passes; ++k) {
        for (size_t n = 0; n < blocks; ++n) to[n] = x[n] + NUMBER(0.5) * z[n];
    }
}

size_t width(void);
size_t width(void) { return LANES; }
