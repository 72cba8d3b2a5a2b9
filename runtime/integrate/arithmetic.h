/* Comparisons and sums that say what becomes of a NaN and of rounding. */

#if defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__) ||     \
    defined(__NO_SIGNED_ZEROS__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__)
#error "kousoku: verified numbers need IEEE arithmetic; compile without -ffast-math and its parts"
#endif

/* the larger number, the second if the first is a NaN */
static double larger(double a, double b) { return a > b ? a : b; }

/* the smaller number, the second if the first is a NaN */
static double smaller(double a, double b) { return a < b ? a : b; }

static int are_finite(const double *x, size_t n)
{
    for (size_t i = 0; i < n; ++i) {
        if (!isfinite(x[i])) return 0;
    }
    return 1;
}

/* what the rounding of sum = a + b has left over, exactly (Knuth's TwoSum) */
static double rounding_of_sum(double a, double b, double sum)
{
    const double part = sum - a;
    return (a - (sum - part)) + (b - part);
}
