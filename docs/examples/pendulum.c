/* The pendulum of scenes/pendulum.toml, moved from C; ends with 3 if the run cannot be trusted:
 *   kousoku generate scenes/pendulum.toml --out .
 *   cc -O2 -Ipendulum docs/examples/pendulum.c pendulum/solver.c -lm -o program */
#include <stdio.h>
#include <stdlib.h>

#include "solver.h"

int main(void)
{
    const double q[] = { -0.75, 0, 1, 0 }, v[] = { 0, 0, 0 }; /* x, y, e0, e3 of the rod; at rest */
    const kousoku_pendulum_settings settings = { 1e-12, 1e300, 0, 1, 1 };
    kousoku_pendulum_verdict verdict;
    kousoku_pendulum_state run;
    size_t written = 0, total = 0, row = kousoku_pendulum_row_size();
    double times[11], *state = (double *)&run;
    double *work = (double *)calloc(kousoku_pendulum_work_size(), sizeof *work);
    double *rows = (double *)calloc(2 * row, sizeof *rows);
    int status = kousoku_pendulum_start(0, q, v, NULL, state, work);
    for (int k = 0; k <= 10; ++k) times[k] = k;
    while (status >= 0 && total < 11) { /* at most two rows a call */
        status = kousoku_pendulum_run(&settings, times, 11, 100, 2, state, work, rows, &written);
        for (size_t k = 0; k < written; ++k, ++total)
            printf("%g %.17g %.17g\n", rows[k * row], rows[k * row + 1], rows[k * row + 2]);
    }
    free(work), free(rows);
    if (status != 0) return status;
    status = kousoku_pendulum_trust(&settings, state, &verdict);
    fprintf(stderr, "%strusted: doubts %d, energy off by %.1e J, wanted at most %.1e J\n",
        status == 0 ? "" : "not ", verdict.doubts, run.energy_error, verdict.energy_limit);
    return status == 0 ? 0 : 3;
}
