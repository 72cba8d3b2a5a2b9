/* End of a step: where a trial must end, for crossings, for narrow forces, for events. */

/* largest number of re-locations of an event that cuts a step */
#define MOST_POLISHED 3

/* where a trial must end by what crosses in it. Poles of forces and distances are looked for once
 * more where its polynomial has not all of its stages */
static double crossing_in(Attempts *tried, Trial *trial, Work *work, State *s)
{
    const Method *m = tried->m;
    Search *search = &tried->search;
    const double *f = work->k[m->stages];
    int has_stages = N_SWITCHING > 0 && is_kept(trial);
    /* one that leads beyond its end stays as it is */
#ifdef HAS_DISTANCE
    const int reverses = !tried->is_beyond && may_reverse(s->time, trial->h, work->y, f, s, work);
    if (!reverses && N_FUNCTIONS == 0) return trial->end;
    if (reverses && is_kept(trial) && !has_stages)
        has_stages = make_dense_stages(m, trial, work, s);
#endif
    begin_search(tried->settings, m, has_stages, trial->h, work->y, s->f, f, search, s, work);
    search->least_part = is_kept(trial) && !trial->is_vague ? 0.0 : LEAST_PART;
    search->is_kept = is_kept(trial);
#ifdef HAS_BREAKS
    const int is_leading = leads_over(trial->end, search);
#endif
#ifdef HAS_DISTANCE
    const double reversal = reverses ? reversal_end(trial->end, search, s, work) : HUGE_VAL;
#endif
    const int is_bare = tried->is_beyond || N_FUNCTIONS == 0;
    double seen = is_bare ? trial->end : crossing_end(trial->end, search, s, work);
    if (search->pole && !has_stages && make_dense_stages(m, trial, work, s)) {
        begin_search(tried->settings, m, 1, trial->h, work->y, s->f, f, search, s, work);
        seen = crossing_end(trial->end, search, s, work);
    }
    if (search->pole) return end_before_pole(search, s);
    if (search->undefined) return seen;
    double broken = seen;
#ifdef HAS_BREAKS
    if (!is_bare) broken = break_end(trial->end, seen, is_leading, search, s, work);
#endif
#ifdef HAS_DISTANCE
    if (reversal < broken) return cut_for_place(reversal, seen, search);
#endif
#ifdef HAS_BREAKS
    if (broken < seen) return broken_in(broken, search);
#endif
    return broken;
}

/* time at which a trial must end so that samples up to a time resolve parts of formulas; noted
 * where it cannot be shorter for that. If samples are few, the trial gets the error of blind
 * estimates. In a step that ended beside the middle of a steep rise, with stages on both sides, the
 * estimate was a hundredth of a tolerance and the error 500 */
static double resolved_in(double until, Attempts *tried, Trial *trial, Work *work, State *s)
{
    Search *search = &tried->search;
    double to = trial->end;
    if (N_NARROW == 0 || !is_kept(trial)) return trial->end;
    if (search->is_over && until <= search->place_cut) return trial->end;
    search->is_coarse = 0;
    if (tried->shorter++ < MOST_SHORTER) {
        /* for less the next trial has no digits */
        const double tiny = SMALLEST * larger(fabs(s->time), fabs(tried->end));
        const double there = larger(resolved_end(until, search, s, work), s->time + ONWARD * tiny);
        to = there < until ? there : trial->end;
    } else {
        search->is_unresolved = search->is_unresolved ||
                                (!are_narrow_resolved(s->time, until, search, s, work) &&
                                    !is_at_pole(1, s->time, until, search, s, work));
    }
    if (search->is_coarse && until == trial->end && to == until && !tried->is_fixed)
        trial->error = error_where_coarse(tried, trial);
    return to;
}

/* time at which a trial must end so that its polynomial meets what its stages do. If it has been
 * shortened for that too often, a switch that a stage of the dense output alone meets is noted as
 * unresolved: of those that other stages meet the error tells. At a cut rounding decides */
static double met_in(double until, Attempts *tried, const Trial *trial, Work *work, State *s)
{
    Search *search = &tried->search;
    if (N_SWITCHING == 0 || !is_kept(trial)) return trial->end;
    if (tried->is_beyond || trial->end == search->cut) return trial->end;
    const size_t first = tried->thrown < MOST_SHORTER ? 1 : tried->m->stages + 1;
    const double beyond = stage_beyond(first, until, search, s, work);
    if (!(beyond < until)) return trial->end;
    if (tried->thrown++ < MOST_SHORTER) return beyond;
    search->is_unresolved = 1;
    return trial->end;
}

/* whether a trial that was cut for an event ends there, as its own polynomial tells: else the cut
 * is there */
static int is_at_event(Attempts *tried, const Trial *trial, Work *work, State *s)
{
    Search *search = &tried->search;
    if (EVENTS == 0 || !is_kept(trial) || trial->end != search->cut) return 1;
    if (!(tried->polished++ < MOST_POLISHED)) return 1;
    const double there = smaller(polished_cut(search, s, work), tried->limit);
    if (!(fabs(there - trial->end) > 4.0 * SMALLEST * fabs(trial->end))) return 1;
    tried->end = search->cut = there;
    s->step_size = larger(s->step_size, there - s->time);
    return 0;
}

/* has a step end at a time when it is tried again: one that could be longer and is cut can so
 * still, however short it gets */
static void end_at(double to, Attempts *tried, const Trial *trial, State *s)
{
    const double way = to - s->time;
    tried->is_guessed = tried->is_guessed || to != tried->search.place_cut;
    if (tried->is_fixed) {
        tried->end = to;
        tried->is_beyond = 0;
    }
    s->rejected += 1;
    const double size = is_kept(trial) ? s->step_size : length_by_error(tried->m, trial);
    s->step_size = to == tried->search.cut ? larger(size, way) : way;
}

/* whether a trial ends where it may by what is seen in it: else it is to end there */
static int ends_well(Attempts *tried, Trial *trial, Work *work, State *s)
{
    Search *search = &tried->search;
    if (N_SEARCHED == 0 || !trial->is_whole || !(is_kept(trial) || !tried->is_guessed)) return 1;
    const double seen = crossing_in(tried, trial, work, s);
    tried->status = why_stopped(seen, search, s);
    if (tried->status != GOOD) return 0;
    const double until = smaller(seen, trial->end); /* what follows a cut is seen later */
    const double narrow = resolved_in(until, tried, trial, work, s);
    double to = smaller(narrow, met_in(until, tried, trial, work, s));
    if (seen <= to && seen < trial->end) to = tried->end = cut_at(seen, search);
    else if (!is_at_event(tried, trial, work, s)) return 0;
    if (!(to < trial->end && (is_kept(trial) || to == search->cut))) return 1;
    end_at(to, tried, trial, s);
    return 0;
}
