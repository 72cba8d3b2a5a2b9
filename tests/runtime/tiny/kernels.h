#ifndef KOUSOKU_TINY_H
#define KOUSOKU_TINY_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#define KOUSOKU_RESTRICT
#else
#define KOUSOKU_RESTRICT restrict
#endif

void kousoku_tiny_sphere(const double r[3], const double *length,
                         double *KOUSOKU_RESTRICT C, double *KOUSOKU_RESTRICT C_q);
void kousoku_tiny_sphere_call(const double *const *in, double *const *out);
void kousoku_tiny_sphere_batch(size_t n, const double *const *in, const size_t *stride,
                               double *const *out);
void kousoku_tiny_sphere_lanes(size_t n_blocks, const double *const *in, double *const *out);
const char *kousoku_tiny_digest(void);
size_t kousoku_tiny_lanes(void);
const char *kousoku_tiny_sphere_signature(void);

#ifdef __cplusplus
}
#endif

#endif
