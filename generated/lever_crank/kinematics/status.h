/* What an analysis ends with, and the tolerances that decide it; status.py states the same. */
#ifndef KOUSOKU_KINEMATICS_STATUS_H
#define KOUSOKU_KINEMATICS_STATUS_H

enum {
    GOOD,
    NOT_ASSEMBLED,
    ON_DEAD_CENTRE,
    OTHER_SIDE,
    DEAD_CENTRE,
    LIMIT_TOO_SMALL,
    NOT_FINITE,
    BAD_ARGUMENT,
    TOO_FAR
};

/* a correction this small, relative to LENGTH, leaves nothing to correct: Newton squares it */
#define SETTLED 0x1p-28
/* corrections this small, relative to LENGTH, are rounding */
#define ROUNDING_OF_POSITIONS 0x1p-48
/* below this pivot, of columns scaled to lengths, a block has a dead centre */
#define SINGULAR 1e-7
/* most that the Jacobian may turn along a step, relative to itself: at 1 it might be singular */
#define MOST_TILT 0.75
/* smallest part of a division that is stepped before the continuation gives up */
#define SMALLEST_STEP 0x1p-24
/* steps, good or not, from one row to the next before it gives up */
#define MOST_TRIES 1000000

static const char *message_of(int status)
{
    static const char *const messages[] = {
        "good",
        "the linkage cannot be assembled from the positions of the scene",
        "the positions of the scene lie on a dead centre, where the side is not clear",
        "the linkage assembles only on the other side of a dead centre than the scene shows",
        "a dead centre, or a change point, on the way",
        "the residual limit is smaller than rounding allows",
        "a number is not finite",
        "an option is not finite, not positive, or start is beyond first; or times do not ascend",
        "the inputs go too far, to the first row or from row to row: more than 1,000,000 steps",
    };
    return status >= GOOD && status <= TOO_FAR ? messages[status] : "unknown status";
}

#endif
