/* The pendulum of scenes/pendulum.toml, moved from C:
 *   kousoku generate scenes/pendulum.toml --out .
 *   cc -O2 -Ipendulum docs/examples/pendulum.c pendulum/solver.c -lm -o program */
#include <stdio.h>
#include <stdlib.h>

#include "solver.h"

int main(void)
{
    const double q[] = { -0.75, 0, 1, 0 }, v[] = { 0, 0, 0 }; /* x, y, e0, e3 of the rod; at rest */
    const kousoku_pendulum_settings settings = { 1e-12, 1e300, 0, 0, 1 };
    double times[11], *state, *work, *rows;
    size_t written = 0, total = 0, row = kousoku_pendulum_row_size();
    int status;
    for (int k = 0; k <= 10; ++k) times[k] = k;
    state = (double *)calloc(kousoku_pendulum_state_size(), sizeof *state);
    work = (double *)calloc(kousoku_pendulum_work_size(), sizeof *work);
    rows = (double *)calloc(2 * row, sizeof *rows);
    status = kousoku_pendulum_start(0, q, v, NULL, state, work);
    while (status >= 0 && total < 11) { /* at most two rows a call */
        status = kousoku_pendulum_run(&settings, times, 11, 100, 2, state, work, rows, &written);
        for (size_t k = 0; k < written; ++k, ++total) {
            printf("%g %.17g %.17g\n", rows[k * row], rows[k * row + 1], rows[k * row + 2]);
        }
    }
    free(state), free(work), free(rows);
    return status;
}
