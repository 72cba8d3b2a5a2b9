#include "kernels.h"

#define LANES 4

void kousoku_tiny_sphere_batch(size_t n, const double *const *in, const size_t *stride,
                               double *const *out)
{
    for (size_t k = 0; k < n; k++) {
        kousoku_tiny_sphere(in[0] + k * stride[0], in[1] + k * stride[1],
                            out[0] ? out[0] + k : NULL, out[1] ? out[1] + 4 * k : NULL);
    }
}

void kousoku_tiny_sphere_lanes(size_t n_blocks, const double *const *in, double *const *out)
{
    for (size_t b = 0; b < n_blocks; b++) {
        for (size_t lane = 0; lane < LANES; lane++) {
            double r[3], C_q[4];
            for (size_t k = 0; k < 3; k++) {
                r[k] = in[0][(3 * b + k) * LANES + lane];
            }
            kousoku_tiny_sphere(r, in[1] + b * LANES + lane,
                                out[0] ? out[0] + b * LANES + lane : NULL, C_q);
            for (size_t k = 0; out[1] && k < 4; k++) {
                out[1][(4 * b + k) * LANES + lane] = C_q[k];
            }
        }
    }
}

size_t kousoku_tiny_lanes(void) { return LANES; }
