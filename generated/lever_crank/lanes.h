/* One number in each lane of the processor's vectors: what kernels_batch.c of every package includes.
 *
 * LANES is their count, 1 where the compiler has no vectors. KOUSOKU_LANES sets it. What loads and
 * stores rows, load_K, load_rows, store_K and store_rows, stands at the end.
 */
#ifndef KOUSOKU_LANES_H
#define KOUSOKU_LANES_H

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) || \
    defined(__NO_SIGNED_ZEROS__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "kousoku: verified numbers need IEEE arithmetic; compile without -ffast-math and its parts"
#endif

/* what kernels_batch.c was written for: one more with each change that it could notice */
#define KOUSOKU_LANES_VERSION 1

#include <stddef.h>

#if defined(KOUSOKU_LANES)
#define LANES KOUSOKU_LANES
#elif !defined(__GNUC__)
#define LANES 1
#elif defined(__AVX512F__)
#define LANES 8
#elif defined(__AVX__)
#define LANES 4
#else
#define LANES 2
#endif

#ifdef __GNUC__
#define INLINE static inline __attribute__((always_inline, unused))
#else
#define INLINE static inline
#endif

#if LANES == 1
typedef double vec;
#define NUMBER(x) (x)
#define CALL(y, function, a) const vec y = function(a)
#define CALL_2(y, function, a, b) const vec y = function(a, b)

INLINE void load_rows(const double *in, size_t i, size_t stride, size_t size, vec *y)
{
    for (size_t element = 0; element < size; ++element) {
        y[element] = in[i * stride + element];
    }
}

INLINE void store_rows(const vec *y, double *out, size_t i, size_t size)
{
    for (size_t element = 0; element < size; ++element) {
        out[i * size + element] = y[element];
    }
}

#define SHORT_ROWS(k) \
    INLINE void load_##k(const double *in, size_t i, size_t stride, vec *y) \
    { \
        load_rows(in, i, stride, k, y); \
    } \
    INLINE void store_##k(const vec *y, double *out, size_t i) { store_rows(y, out, i, k); }
#else
/* at any address that a double may have */
typedef double vec __attribute__((vector_size(8 * LANES), aligned(8), may_alias));
#define NUMBER(x) ((vec){0} + (x))

/* Functions for one lane after the other. What calls the C library stays apart, and takes the lanes
 * from memory: where a compiler takes them apart in the registers of a kernel, some of those leave
 * the processor in a state in which the library is slow. */
#define CALL(y, function, a) const vec y = vec_##function(a)
#define CALL_2(y, function, a, b) const vec y = vec_##function(a, b)
#ifdef __clang__
#define LIBRARY static __attribute__((noinline, const, unused))
#else
#pragma GCC diagnostic ignored "-Wpsabi" /* none of them is called from elsewhere */
/* What it says does not reach a copy that the compiler makes for one argument. */
#define LIBRARY static __attribute__((noinline, noclone, const, unused))
#endif
#define OF_1(kind, LANES_ARE, function) \
    kind vec vec_##function(vec a) \
    { \
        double x[LANES], y[LANES]; \
        *(vec *)x = a; \
        LANES_ARE(x) \
        for (size_t lane = 0; lane < LANES; ++lane) { \
            y[lane] = function(x[lane]); \
        } \
        return *(const vec *)y; \
    }
#define OF_2(kind, LANES_ARE, function) \
    kind vec vec_##function(vec a, vec b) \
    { \
        double x[LANES], x_2[LANES], y[LANES]; \
        *(vec *)x = a; \
        *(vec *)x_2 = b; \
        LANES_ARE(x) \
        LANES_ARE(x_2) \
        for (size_t lane = 0; lane < LANES; ++lane) { \
            y[lane] = function(x[lane], x_2[lane]); \
        } \
        return *(const vec *)y; \
    }
#define ANYWHERE(x)
#define IN_MEMORY(x) __asm__("" : "+m"(x));
OF_1(INLINE, ANYWHERE, sqrt)
OF_1(INLINE, ANYWHERE, fabs)
OF_2(INLINE, ANYWHERE, fmax)
OF_1(LIBRARY, IN_MEMORY, sin)
OF_1(LIBRARY, IN_MEMORY, cos)
OF_1(LIBRARY, IN_MEMORY, exp)
OF_1(LIBRARY, IN_MEMORY, log)
OF_2(LIBRARY, IN_MEMORY, atan2)

#if LANES == 8
#define EACH(PICK, k, e, s) PICK(k, e, s, 0), PICK(k, e, s, 1), PICK(k, e, s, 2), \
    PICK(k, e, s, 3), PICK(k, e, s, 4), PICK(k, e, s, 5), PICK(k, e, s, 6), PICK(k, e, s, 7)
#elif LANES == 4
#define EACH(PICK, k, e, s) PICK(k, e, s, 0), PICK(k, e, s, 1), PICK(k, e, s, 2), PICK(k, e, s, 3)
#else
#define EACH(PICK, k, e, s) PICK(k, e, s, 0), PICK(k, e, s, 1)
#endif
#if defined(__clang__) || __GNUC__ >= 12
#define SHUFFLE(a, b, PICK, k, e, s) __builtin_shufflevector(a, b, EACH(PICK, k, e, s))
#else
typedef long long lane_index __attribute__((vector_size(8 * LANES)));
#define SHUFFLE(a, b, PICK, k, e, s) __builtin_shuffle(a, b, (lane_index){EACH(PICK, k, e, s)})
#endif

/* Which of the 2 * LANES numbers of (a, b) goes to lane l. PAIRS: the even (e = 0) or odd (e = 1)
 * lanes of both, in turn. UNITS: the even or odd pairs of lanes of a, then those of b. HALVES: the
 * low or high pairs of lanes of both, in turn. */
#define PAIRS(k, e, s, l) ((l) % 2 ? LANES + (l) - 1 + (e) : (l) + (e))
#define UNITS(k, e, s, l) (2 * (l) - (l) % 2 + 2 * (e))
#define HALVES(k, e, s, l) ((l) / 2 % 2 * LANES + (l) / 4 * 2 + (l) % 2 + LANES / 2 * (e))

/* Rows of k < LANES numbers lie end to end in k vectors, number e of row l at k l + e.
 * UNZIP parts the numbers at even places from those at odd ones; ZIP is the way back. For odd k,
 * TAKE blends number e of all rows into one vector, step s, and SORT puts it in order of the rows;
 * SPREAD and GIVE are the way back (k is its own inverse modulo 2, 4 and 8). */
#define UNZIP(k, e, s, l) (2 * (l) + (e))
#define ZIP(k, e, s, l) ((l) % 2 * LANES + (l) / 2 + LANES / 2 * (e))
#define TAKE(k, e, s, l) ((LANES * (s) + (l)) % (k) == (e) ? LANES + (l) : (l))
#define SORT(k, e, s, l) (((k) * (l) + (e)) % LANES)
#define SPREAD(k, e, s, l) (((l) + 8 * LANES - (e)) * (k) % LANES)
#define GIVE(k, e, s, l) ((LANES * (e) + (l)) % (k) == (s) ? LANES + (l) : (l))

/* rows of k = 2 to 7 numbers in v, to k vectors y: PART; the way back: JOIN */
#define MIX_3(PICK, v, e) SHUFFLE(SHUFFLE(v[0], v[1], PICK, 3, e, 1), v[2], PICK, 3, e, 2)
#define MIX_5(PICK, v, e) SHUFFLE(SHUFFLE(SHUFFLE(SHUFFLE( \
    v[0], v[1], PICK, 5, e, 1), v[2], PICK, 5, e, 2), v[3], PICK, 5, e, 3), v[4], PICK, 5, e, 4)
#define MIX_7(PICK, v, e) SHUFFLE(SHUFFLE(SHUFFLE(SHUFFLE(SHUFFLE(SHUFFLE( \
    v[0], v[1], PICK, 7, e, 1), v[2], PICK, 7, e, 2), v[3], PICK, 7, e, 3), \
    v[4], PICK, 7, e, 4), v[5], PICK, 7, e, 5), v[6], PICK, 7, e, 6)
#define SORTED(k, e) { const vec t = MIX_##k(TAKE, v, e); y[e] = SHUFFLE(t, t, SORT, k, e, 0); }
#define SPREAD_OUT(k, e) s[e] = SHUFFLE(v[e], v[e], SPREAD, k, e, 0);
#define GIVEN(k, e) y[e] = MIX_##k(GIVE, s, e);
#define ALL_3(DO) DO(3, 0) DO(3, 1) DO(3, 2)
#define ALL_5(DO) DO(5, 0) DO(5, 1) DO(5, 2) DO(5, 3) DO(5, 4)
#define ALL_7(DO) DO(7, 0) DO(7, 1) DO(7, 2) DO(7, 3) DO(7, 4) DO(7, 5) DO(7, 6)
#define ODD(k) \
    INLINE void part_##k(const vec *v, vec *y) { ALL_##k(SORTED) } \
    INLINE void join_##k(const vec *v, vec *y) \
    { \
        vec s[k]; \
        ALL_##k(SPREAD_OUT) \
        ALL_##k(GIVEN) \
    }
#define EVEN(k, half) \
    INLINE void part_##k(const vec *v, vec *y) \
    { \
        vec even[half], odd[half], y_even[half], y_odd[half]; \
        for (size_t j = 0; j < half; ++j) { \
            even[j] = SHUFFLE(v[2 * j], v[2 * j + 1], UNZIP, k, 0, 0); \
            odd[j] = SHUFFLE(v[2 * j], v[2 * j + 1], UNZIP, k, 1, 0); \
        } \
        part_##half(even, y_even); \
        part_##half(odd, y_odd); \
        for (size_t j = 0; j < half; ++j) { \
            y[2 * j] = y_even[j]; \
            y[2 * j + 1] = y_odd[j]; \
        } \
    } \
    INLINE void join_##k(const vec *v, vec *y) \
    { \
        vec v_even[half], v_odd[half], even[half], odd[half]; \
        for (size_t j = 0; j < half; ++j) { \
            v_even[j] = v[2 * j]; \
            v_odd[j] = v[2 * j + 1]; \
        } \
        join_##half(v_even, even); \
        join_##half(v_odd, odd); \
        for (size_t j = 0; j < half; ++j) { \
            y[2 * j] = SHUFFLE(even[j], odd[j], ZIP, k, 0, 0); \
            y[2 * j + 1] = SHUFFLE(even[j], odd[j], ZIP, k, 1, 0); \
        } \
    }
INLINE void part_1(const vec *v, vec *y) { y[0] = v[0]; }
INLINE void join_1(const vec *v, vec *y) { y[0] = v[0]; }
EVEN(2, 1)
ODD(3)
EVEN(4, 2)
ODD(5)
EVEN(6, 3)
ODD(7)

/* the square of LANES vectors, turned over its diagonal */
INLINE void transpose(vec *x)
{
    vec even[LANES / 2], odd[LANES / 2];
    for (size_t row = 0; row < LANES / 2; ++row) {
        even[row] = SHUFFLE(x[2 * row], x[2 * row + 1], PAIRS, 0, 0, 0);
        odd[row] = SHUFFLE(x[2 * row], x[2 * row + 1], PAIRS, 0, 1, 0);
    }
#if LANES == 2
    x[0] = even[0];
    x[1] = odd[0];
#elif LANES == 4
    x[0] = SHUFFLE(even[0], even[1], UNITS, 0, 0, 0);
    x[1] = SHUFFLE(odd[0], odd[1], UNITS, 0, 0, 0);
    x[2] = SHUFFLE(even[0], even[1], UNITS, 0, 1, 0);
    x[3] = SHUFFLE(odd[0], odd[1], UNITS, 0, 1, 0);
#else
#define QUARTERS(from, to, second) { \
        const vec a = SHUFFLE(from[0], from[1], UNITS, 0, second, 0); \
        const vec b = SHUFFLE(from[2], from[3], UNITS, 0, second, 0); \
        x[to] = SHUFFLE(a, b, UNITS, 0, 0, 0); \
        x[to + 4] = SHUFFLE(a, b, UNITS, 0, 1, 0); \
    }
    QUARTERS(even, 0, 0)
    QUARTERS(even, 2, 1)
    QUARTERS(odd, 1, 0)
    QUARTERS(odd, 3, 1)
#endif
}

#if LANES > 2
typedef double half __attribute__((vector_size(4 * LANES), aligned(8), may_alias));

INLINE void store_halves(const vec *y, double *x, size_t stride)
{
    *(half *)x = ((const half *)y)[0];
    *(half *)(x + stride) = ((const half *)y)[1];
}
#endif

/* The square of LANES vectors, turned over its diagonal, to rows at x. The last step of turning
 * is left to the stores, of half a row each. */
INLINE void store_square(const vec *y, double *x, size_t stride)
{
#if LANES == 2
    *(vec *)x = SHUFFLE(y[0], y[1], PAIRS, 0, 0, 0);
    *(vec *)(x + stride) = SHUFFLE(y[0], y[1], PAIRS, 0, 1, 0);
#else
    for (size_t odd = 0; odd < 2; ++odd) {
        vec pairs[LANES / 2];
        for (size_t row = 0; row < LANES / 2; ++row) {
            pairs[row] = odd ? SHUFFLE(y[2 * row], y[2 * row + 1], PAIRS, 0, 1, 0)
                             : SHUFFLE(y[2 * row], y[2 * row + 1], PAIRS, 0, 0, 0);
        }
#if LANES == 4
        for (size_t row = 0; row < 2; ++row) {
            store_halves(&pairs[row], x + odd * stride + 2 * row, 2 * stride);
        }
#else
        for (size_t row = 0; row < 2; ++row) {
            double *to = x + odd * stride + 4 * row;
            const vec low = SHUFFLE(pairs[2 * row], pairs[2 * row + 1], HALVES, 0, 0, 0);
            const vec high = SHUFFLE(pairs[2 * row], pairs[2 * row + 1], HALVES, 0, 1, 0);
            store_halves(&low, to, 2 * stride);
            store_halves(&high, to + 4 * stride, 2 * stride);
        }
#endif
    }
#endif
}

/* LANES rows of `size` numbers from evaluation i on, one every `stride`, to as many vectors */
INLINE void load_rows(const double *in, size_t i, size_t stride, size_t size, vec *y)
{
    const double *x = in + i * stride;
    for (size_t at = 0; at < size; at += LANES) {
        const size_t first = at + LANES < size ? at : size - LANES;
        for (size_t lane = 0; lane < LANES; ++lane) {
            y[first + lane] = *(const vec *)(x + lane * stride + first);
        }
        transpose(y + first);
    }
}

/* vectors to LANES rows of `size` numbers end to end */
INLINE void store_rows(const vec *y, double *out, size_t i, size_t size)
{
    for (size_t at = 0; at < size; at += LANES) {
        const size_t first = at + LANES < size ? at : size - LANES;
        store_square(y + first, out + i * size + first, size);
    }
}

/* the same for rows that may be shorter than a vector */
#define SHORT_ROWS(k) \
    INLINE void load_##k(const double *in, size_t i, size_t stride, vec *y) \
    { \
        const double *x = in + i * stride; \
        if (LANES <= k) { \
            load_rows(in, i, stride, k, y); \
        } else if (stride == k) { \
            part_##k((const vec *)x, y); \
        } else { \
            for (size_t element = 0; element < k; ++element) { \
                double column[LANES]; \
                for (size_t lane = 0; lane < LANES; ++lane) { \
                    column[lane] = x[lane * stride + element]; \
                } \
                y[element] = *(const vec *)column; \
            } \
        } \
    } \
    INLINE void store_##k(const vec *y, double *out, size_t i) \
    { \
        if (LANES <= k) { \
            store_rows(y, out, i, k); \
        } else { \
            join_##k(y, (vec *)(out + i * k)); \
        } \
    }
#endif

/* what expressions.h is written in */
typedef vec real;
SHORT_ROWS(1)
SHORT_ROWS(2)
SHORT_ROWS(3)
SHORT_ROWS(4)
SHORT_ROWS(5)
SHORT_ROWS(6)
SHORT_ROWS(7)

#endif
