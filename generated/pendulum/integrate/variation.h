/* Variation: whether samples of a step tell how forces vary with the state. Parts of formulas
 * that vary with the state beyond polynomials are bounded between samples: where these do not
 * show how such a part varies, the step is made shorter. */

/* samples resolve a part if the sum over all cells of the width of its rate bounds, times the
 * length of the cell, is at most this many times the range of the samples */
#define EXPLAINED 2.0
/* where formulas switch and an error is known, samples also resolve a part if the sum over all
 * cells of the width of its value bounds is at most this many times their range: a hill between two
 * samples goes up and down, and would make it twice */
#define SHOWN 1.5
/* samples are few for a part if the sum that EXPLAINED bounds is more than this many times their
 * range */
#define SMOOTH 0.25
/* negligible variation of a part, relative to its size */
#define NEGLIGIBLE_VARIATION 1e-12
/* negligible variation of a force: it moves the lightest body by this part of the tolerance, in
 * lengths of the scene */
#define NEGLIGIBLE_MOTION 1e-3
/* a part needs no samples in an interval where its bounds differ by less than this part of its
 * size */
#define STEADY 0.5
/* bounds count as evenly loose if no cell has more than this part of all by which they exceed the
 * change of samples: a hill between two samples makes one cell stand out */
#define UNEVEN 0.35
/* shortest interval in which the variation of a part is looked at, relative to the step: narrower
 * ones have no bounds */
#define FINEST 1e-9

/* what a part of some size may vary by between two times, in the unit of its formula: a force that
 * acts as long moves a body on meanwhile, and then in as much time as has passed since 0 */
static double negligible_variation(
    double size, const double *scale, double tolerance, double start, double end)
{
    const double span = larger(fabs(start), fabs(end));
    if (scale[1] == 0.0) return NEGLIGIBLE_VARIATION * larger(size, scale[0]);
    return larger(NEGLIGIBLE_VARIATION * size,
        NEGLIGIBLE_MOTION * tolerance * (scale[0] / ((end - start) * span)));
}

/* how a part varies between two times, as samples and bounds of the cells between them tell */
typedef struct {
    double last, least, most;   /* the last sample, the least and largest */
    double low, high;           /* bounds of all cells */
    double reach, change;       /* sums of what bounds let it vary by, and of what rates may */
    double hidden, most_hidden; /* by how much bounds of cells exceed samples: sum, and largest */
} VariationBounds;

/* how well samples tell how parts vary */
enum { UNRESOLVED, COARSE, RESOLVED };

static void begin_variation(double sample, VariationBounds *v)
{
    *v = (VariationBounds){
        .last = sample, .least = sample, .most = sample, .low = sample, .high = sample
    };
}

/* adds a cell of length h: the sample at its end, and bounds of values and rates in it */
static void add_cell(double h, double sample, const double *bounds, VariationBounds *v)
{
    const double width = bounds[1] - bounds[0], hidden = width - fabs(sample - v->last);
    v->least = smaller(sample, v->least);
    v->most = larger(sample, v->most);
    v->low = smaller(bounds[0], v->low);
    v->high = larger(bounds[1], v->high);
    v->reach += width;
    v->change += h * (bounds[3] - bounds[2]);
    v->hidden += hidden;
    v->most_hidden = larger(hidden, v->most_hidden);
    v->last = sample;
}

/* how well samples tell how a part varies, but for what counts as nothing. Samples resolve it in
 * one of three ways: its rate bounds are narrow beside the range of the samples (EXPLAINED); its
 * bounds are steady (STEADY) and no looser in one cell, where a hill may hide, than in the others
 * (UNEVEN); or, where formulas switch and an error is known, its value bounds exceed the samples by
 * little (SHOWN), as of a root, at whose end no rate is bounded */
static int sampling_of(const VariationBounds *v, double steady, int has_error, double nothing)
{
    const double range = v->most - v->least;
    const int is_even = v->most_hidden <= UNEVEN * v->hidden + nothing;
    const int is_steady = is_even && v->high - v->low <= steady + nothing;
    const int is_shown = has_error && v->reach <= SHOWN * range + nothing;
    if (!(is_steady || is_shown || v->change <= EXPLAINED * range + nothing)) return UNRESOLVED;
    return is_steady || v->change <= SMOOTH * range + nothing ? RESOLVED : COARSE;
}

/* whether samples between two times tell how parts vary with the state; whether they are few for
 * that is noted */
static int are_narrow_resolved(double start, double end, Search *search, const State *s, Work *work)
{
    VariationBounds variations[ROOM(N_NARROW)];
    double band[ROOM(N_NARROW)];
    const double h = (end - start) / CELLS;
    int is_coarse = 0;
    TimeNode a, b;
    node_at(start, search, s, work, &a);
    for (size_t k = 0; k != N_NARROW; ++k) {
        begin_variation(middle(&a, N_CROSSINGS + k), &variations[k]);
        band[k] = half_width(&a, N_CROSSINGS + k);
    }
    for (int cell = 1; cell <= CELLS; ++cell) {
        node_at(start + cell * h, search, s, work, &b);
        bound_functions(&a, &b, search, work->w);
        for (size_t k = 0; k != N_NARROW; ++k) {
            add_cell(h, middle(&b, N_CROSSINGS + k), work->w + W_NARROW + 4 * k, &variations[k]);
            band[k] = larger(half_width(&b, N_CROSSINGS + k), band[k]);
        }
        a = b;
    }
    for (size_t k = 0; k != N_NARROW; ++k) {
        const double size = larger(-variations[k].least, variations[k].most);
        const double nothing = band[k] + negligible_variation(
                                             size, narrow_scales[k], search->tolerance, start, end);
        /* no error tells of what works miss along drivers */
        const double steady = IS_DRIVEN ? 0.0 : STEADY * size;
        const int sampling = sampling_of(&variations[k], steady, search->has_error, nothing);
        if (sampling == UNRESOLVED) return 0;
        is_coarse = is_coarse || sampling == COARSE;
    }
    search->is_coarse = search->is_coarse || is_coarse;
    return 1;
}

/* whether at both times a function is near to zero at which a force may be infinite, or in between:
 * no bound tells there how it varies, and of what is narrow the energy does */
static int is_at_pole(
    int in_between, double first, double last, const Search *search, const State *s, Work *work)
{
    TimeNode a, b;
    if (N_POLES == 0) return 0;
    node_with_noise(search->noise, first, search, s, work, &a);
    node_with_noise(search->noise, last, search, s, work, &b);
    for (size_t k = N_SWITCHING; k != N_CROSSINGS; ++k) {
        const int before = side_at(&a, k), after = side_at(&b, k);
        if ((before == 0 && after == 0) || (in_between && before * after != 1)) return 1;
    }
    return 0;
}

/* where a step to an end must end so that samples tell how parts vary with the state; what they do
 * not tell in the finest intervals either is gone over, and noted */
static double resolved_end(double end, Search *search, const State *s, Work *work)
{
    const double start = search->start, whole = end - start;
    double first = start, allowed = whole, width = whole;
    /* the sum may be rounded up, beyond the end */
    for (size_t n = 0; first < smaller(start + allowed, end); ++n) {
        if (n == MOST_NODES) {
            search->is_unresolved = search->is_unresolved ||
                                    !is_at_pole(1, first, end, search, s, work);
            break;
        }
        const double last = smaller(first + width, end);
        const int is_there = is_at_pole(0, first, last, search, s, work);
        const int good = !is_there && are_narrow_resolved(first, last, search, s, work);
        if (!good && !is_there && width > FINEST * search->h) {
            width = 0.5 * width;
            continue;
        }
        if (good) {
            allowed = smaller(allowed, larger(first - start, last - first));
        } else if (!is_at_pole(1, first, last, search, s, work)) {
            search->is_unresolved = 1;
        }
        first = last;
        width = 2.0 * width;
    }
    return allowed < whole ? start + allowed : end;
}
