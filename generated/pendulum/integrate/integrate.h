/* The motion of a scene of bodies: explicit Runge-Kutta on the manifold of the constraints.
 *
 * The vector field is f(project(y)): equal to f on the manifold, so that the method keeps its
 * order, and every stage is evaluated where the constraints hold. y is q and v: r and p of all
 * bodies, turns and works, then v and omega of all bodies.
 *
 * This library is included by the source of a scene, solver.c, once that has defined
 *
 *     PUBLIC(name)     the exported name, with the prefix of the scene
 *     DIGEST, KEY      of all that it was made of; what a state of it begins with
 *     LENGTH ...       numbers of the scene
 *     HAS_ROWS ...     what it has, and others may lack: see lacking.h
 *     NQ ... W_SIZE    counts, and places of regions in the workspace, as enumerators, so that the
 *                      compiler drops what the scene does not need
 *     is_length ...    its tables
 *     geometry() ...   its segments: what is computed at a state
 *
 * All is static, without heap or globals; the caller owns state and workspace. Strict C99. */
#ifndef KOUSOKU_INTEGRATE_H
#define KOUSOKU_INTEGRATE_H

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "arithmetic.h"
#include "lacking.h"
#include "methods.h"
#include "memory.h"
#include "pivot_monitor.h"
#include "row_switch.h"
#include "projection.h"
#include "dense_output.h"
#include "search.h"
#include "roots.h"
#include "poles.h"
#include "crossing.h"
#include "variation.h"
#if defined HAS_DISTANCE || defined HAS_BREAKS
#include "cuts.h"
#endif
#ifdef HAS_DISTANCE
#include "distances.h"
#endif
#ifdef HAS_BREAKS
#include "breaks.h"
#endif
#include "branches.h"
#include "switching.h"
#include "motion_scales.h"
#include "trial.h"
#include "step_error.h"
#include "branch_watch.h"
#include "step_end.h"
#include "stepper.h"
#if IS_DRIVEN
#include "kinematics.h"
#endif
#include "rows.h"
#include "continuation.h"
#if HAS_RANK
#include "rank.h"
#endif
#include "trust.h"
#include "calls.h"

#endif
