/* One turn of the lever crank without Python: cc main.c solver.c -lm */
#include <stdio.h>
#include "solver.h"

enum { ROWS = 61, O3 = 2 };

int main(void)
{
    static double position[ROWS][KOUSOKU_LEVER_CRANK_NODES][2];
    static double velocity[ROWS][KOUSOKU_LEVER_CRANK_NODES][2];
    kousoku_lever_crank_workspace workspace;
    kousoku_lever_crank_run run;
    int status;
    size_t row;

    kousoku_lever_crank_defaults(&run); /* one turn in 60 divisions, full Newton */
    run.position = &position[0][0][0];
    run.velocity = &velocity[0][0][0];
    status = kousoku_lever_crank_solve(&run, &workspace);
    for (row = 0; row < run.done; ++row) {
        printf("%2d  %.15e  %.15e  %.15e  %.15e\n", (int)row,
            position[row][O3][0], position[row][O3][1],
            velocity[row][O3][0], velocity[row][O3][1]);
    }
    if (status != 0) {
        fprintf(stderr, "%s\n", kousoku_lever_crank_message(status));
    }
    return status;
}
