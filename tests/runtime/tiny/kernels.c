#include "kernels.h"

#ifdef __FAST_MATH__
#error "kousoku kernels must not be compiled with -ffast-math: it breaks their error limits"
#endif

void kousoku_tiny_sphere(const double r[3], const double *length,
                         double *restrict C, double *restrict C_q)
{
    if (C) {
        C[0] = length[0] * (r[0] * r[0] + r[1] * r[1] + r[2] * r[2]);
    }
    if (C_q) {
        const double t0 = length[0] + length[0];
        C_q[0] = t0 * r[0];
        C_q[1] = t0 * r[1];
        C_q[2] = t0 * r[2];
        C_q[3] = 0.0;
    }
}

void kousoku_tiny_sphere_call(const double *const *in, double *const *out)
{
    kousoku_tiny_sphere(in[0], in[1], out[0], out[1]);
}

const char *kousoku_tiny_digest(void) { return "=DIGEST="; }
const char *kousoku_tiny_sphere_signature(void) { return "r[3] length[1] -> C[1] C_q[4]"; }
