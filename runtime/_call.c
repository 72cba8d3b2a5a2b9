/* Call a compiled kernel from Python with little overhead.
 *
 * A Plan holds the addresses of a kernel and the shapes of its arrays. plan(inputs, out, mask)
 * takes only arguments that need no conversion: aligned C-contiguous float64 arrays of the exact
 * shapes, batched over the same leading axes or shared, that do not overlap. For anything else it
 * returns None, and kousoku.runtime.arguments converts, or says what is wrong.
 */
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#define NPY_NO_DEPRECATED_API NPY_1_7_API_VERSION
#include <numpy/arrayobject.h>
#include <stddef.h>
#include <stdint.h>

/* Kernels that exceed these limits are called without a Plan. */
#define MAX_ARRAYS 24
#define MAX_AXES 4
#define MAX_BATCH_AXES 4
/* A batch of as many doubles takes longer than giving up the interpreter lock. */
#define LONG_BATCH 4096

typedef void (*single_function)(const double *const *in, double *const *out);
typedef void (*batch_function)(
    size_t n, const double *const *in, const size_t *stride, double *const *out);

typedef struct {
    int n_axes;
    npy_intp axes[MAX_AXES];
    npy_intp size;
} Shape;

typedef struct {
    PyObject_HEAD
    vectorcallfunc vectorcall;
    single_function single;
    batch_function batch;
    int n_in;
    int n_out;
    npy_intp numbers;
    Shape in[MAX_ARRAYS];
    Shape out[MAX_ARRAYS];
} Plan;

/* The arguments of one call. n_axes < 0: no input has batch axes so far. */
typedef struct {
    int n_axes;
    npy_intp axes[MAX_BATCH_AXES + MAX_AXES];
    npy_intp n;
    double scalars[MAX_ARRAYS];
    const double *in[MAX_ARRAYS];
    size_t stride[MAX_ARRAYS];
    double *out[MAX_ARRAYS];
} Call;

static int same_axes(int n, const npy_intp *a, const npy_intp *b)
{
    for (int k = 0; k < n; k++) {
        if (a[k] != b[k]) {
            return 0;
        }
    }
    return 1;
}

static int take_input(Call *call, int k, const Shape *shape, PyObject *value)
{
    if (PyArray_CheckExact(value)) {
        PyArrayObject *array = (PyArrayObject *)value;
        const int n_axes = PyArray_NDIM(array) - shape->n_axes;
        const npy_intp *axes = PyArray_DIMS(array);
        if (PyArray_TYPE(array) != NPY_DOUBLE || !PyArray_ISCARRAY_RO(array) || n_axes < 0
            || n_axes > MAX_BATCH_AXES || !same_axes(shape->n_axes, axes + n_axes, shape->axes)) {
            return 0;
        }
        call->in[k] = PyArray_DATA(array);
        call->stride[k] = n_axes ? (size_t)shape->size : 0;
        if (n_axes == 0) {
            return 1;
        }
        if (call->n_axes < 0) {
            call->n_axes = n_axes;
            for (int axis = 0; axis < n_axes; axis++) {
                call->axes[axis] = axes[axis];
                call->n *= axes[axis];
            }
        }
        return n_axes == call->n_axes && same_axes(n_axes, axes, call->axes);
    }
    if (PyFloat_CheckExact(value) && shape->n_axes == 0) {
        call->scalars[k] = PyFloat_AS_DOUBLE(value);
        call->in[k] = &call->scalars[k];
        call->stride[k] = 0;
        return 1;
    }
    return 0;
}

static int take_output(Call *call, int k, const Shape *shape, PyObject *value)
{
    if (value == Py_None) {
        call->out[k] = NULL;
        return 1;
    }
    if (!PyArray_CheckExact(value)) {
        return 0;
    }
    PyArrayObject *array = (PyArrayObject *)value;
    const npy_intp *axes = PyArray_DIMS(array);
    call->out[k] = PyArray_DATA(array);
    return PyArray_TYPE(array) == NPY_DOUBLE && PyArray_ISCARRAY(array)
        && PyArray_NDIM(array) == call->n_axes + shape->n_axes
        && same_axes(call->n_axes, axes, call->axes)
        && same_axes(shape->n_axes, axes + call->n_axes, shape->axes);
}

static int overlap(const double *a, npy_intp n_a, const double *b, npy_intp n_b)
{
    const uintptr_t start_a = (uintptr_t)a, start_b = (uintptr_t)b;
    return start_a < start_b + (uintptr_t)n_b * sizeof(double)
        && start_b < start_a + (uintptr_t)n_a * sizeof(double);
}

static int are_apart(const Plan *plan, const Call *call)
{
    for (int i = 0; i < plan->n_out; i++) {
        if (!call->out[i]) {
            continue;
        }
        const npy_intp n_i = call->n * plan->out[i].size;
        for (int k = 0; k < plan->n_in; k++) {
            const npy_intp n_k = (call->stride[k] ? call->n : 1) * plan->in[k].size;
            if (overlap(call->out[i], n_i, call->in[k], n_k)) {
                return 0;
            }
        }
        for (int k = 0; k < i; k++) {
            if (call->out[k] && overlap(call->out[i], n_i, call->out[k], call->n * plan->out[k].size)) {
                return 0;
            }
        }
    }
    return 1;
}

static void evaluate(const Plan *plan, const Call *call, int is_batch)
{
    if (!is_batch) {
        plan->single(call->in, call->out);
    } else if (call->n * plan->numbers < LONG_BATCH) {
        if (call->n > 0) {
            plan->batch((size_t)call->n, call->in, call->stride, call->out);
        }
    } else {
        Py_BEGIN_ALLOW_THREADS
        plan->batch((size_t)call->n, call->in, call->stride, call->out);
        Py_END_ALLOW_THREADS
    }
}

/* Return the tuple of the entries that are not None. */
static PyObject *wanted_of(PyObject *out)
{
    const Py_ssize_t n = PyTuple_GET_SIZE(out);
    Py_ssize_t count = 0;
    for (Py_ssize_t k = 0; k < n; k++) {
        count += PyTuple_GET_ITEM(out, k) != Py_None;
    }
    if (count == n) {
        Py_INCREF(out);
        return out;
    }
    PyObject *wanted = PyTuple_New(count);
    for (Py_ssize_t k = 0, i = 0; wanted && k < n; k++) {
        PyObject *array = PyTuple_GET_ITEM(out, k);
        if (array != Py_None) {
            Py_INCREF(array);
            PyTuple_SET_ITEM(wanted, i++, array);
        }
    }
    return wanted;
}

/* Allocate the outputs that a mask asks for, and return them as a tuple. */
static PyObject *allocate(const Plan *plan, Call *call, unsigned long mask)
{
    Py_ssize_t count = 0;
    for (int k = 0; k < plan->n_out; k++) {
        count += mask >> k & 1;
    }
    PyObject *results = PyTuple_New(count);
    for (int k = 0, i = 0; results && k < plan->n_out; k++) {
        const Shape *shape = &plan->out[k];
        call->out[k] = NULL;
        if (!(mask >> k & 1)) {
            continue;
        }
        for (int axis = 0; axis < shape->n_axes; axis++) {
            call->axes[call->n_axes + axis] = shape->axes[axis];
        }
        PyObject *array = PyArray_SimpleNew(call->n_axes + shape->n_axes, call->axes, NPY_DOUBLE);
        if (!array) {
            Py_CLEAR(results);
            break;
        }
        call->out[k] = PyArray_DATA((PyArrayObject *)array);
        PyTuple_SET_ITEM(results, i++, array);
    }
    return results;
}

static PyObject *plan_call(
    PyObject *self, PyObject *const *args, size_t nargsf, PyObject *names)
{
    const Plan *plan = (const Plan *)self;
    if (PyVectorcall_NARGS(nargsf) != 3 || names || !PyTuple_CheckExact(args[0])) {
        PyErr_SetString(PyExc_TypeError, "wanted a tuple of inputs, out, and a mask");
        return NULL;
    }
    PyObject *inputs = args[0], *out = args[1];
    Call call;
    call.n_axes = -1;
    call.n = 1;
    if (PyTuple_GET_SIZE(inputs) != plan->n_in) {
        Py_RETURN_NONE;
    }
    for (int k = 0; k < plan->n_in; k++) {
        if (!take_input(&call, k, &plan->in[k], PyTuple_GET_ITEM(inputs, k))) {
            Py_RETURN_NONE;
        }
    }
    const int is_batch = call.n_axes >= 0;
    call.n_axes = is_batch ? call.n_axes : 0;
    PyObject *results = NULL;
    if (out == Py_None) {
        const unsigned long mask = PyLong_AsUnsignedLong(args[2]);
        if (mask == (unsigned long)-1 && PyErr_Occurred()) {
            return NULL;
        }
        results = allocate(plan, &call, mask);
    } else {
        if (!PyTuple_CheckExact(out) || PyTuple_GET_SIZE(out) != plan->n_out) {
            Py_RETURN_NONE;
        }
        for (int k = 0; k < plan->n_out; k++) {
            if (!take_output(&call, k, &plan->out[k], PyTuple_GET_ITEM(out, k))) {
                Py_RETURN_NONE;
            }
        }
        if (!are_apart(plan, &call)) {
            Py_RETURN_NONE;
        }
        results = wanted_of(out);
    }
    if (results) {
        evaluate(plan, &call, is_batch);
    }
    return results;
}

/* Read a tuple of shapes; return their count, -1 with an exception set if there are too many. */
static int read_shapes(PyObject *shapes, Shape *to)
{
    const Py_ssize_t n = PyTuple_GET_SIZE(shapes);
    int fits = n <= MAX_ARRAYS;
    for (Py_ssize_t k = 0; fits && k < n; k++) {
        PyObject *shape = PyTuple_GET_ITEM(shapes, k);
        fits = PyTuple_Check(shape) && PyTuple_GET_SIZE(shape) <= MAX_AXES;
        to[k].n_axes = fits ? (int)PyTuple_GET_SIZE(shape) : 0;
        to[k].size = 1;
        for (int axis = 0; axis < to[k].n_axes; axis++) {
            to[k].axes[axis] = PyLong_AsSsize_t(PyTuple_GET_ITEM(shape, axis));
            to[k].size *= to[k].axes[axis];
        }
    }
    if (!fits && !PyErr_Occurred()) {
        PyErr_SetString(PyExc_ValueError, "too many arrays or axes for a plan");
    }
    return PyErr_Occurred() ? -1 : (int)n;
}

static PyObject *plan_new(PyTypeObject *type, PyObject *args, PyObject *names)
{
    unsigned long long single, batch;
    PyObject *in, *out;
    if (names || !PyArg_ParseTuple(
            args, "KKO!O!", &single, &batch, &PyTuple_Type, &in, &PyTuple_Type, &out)) {
        return NULL;
    }
    Plan *plan = (Plan *)type->tp_alloc(type, 0);
    if (!plan) {
        return NULL;
    }
    plan->vectorcall = plan_call;
    plan->single = (single_function)(uintptr_t)single;
    plan->batch = (batch_function)(uintptr_t)batch;
    plan->n_in = read_shapes(in, plan->in);
    plan->n_out = plan->n_in < 0 ? -1 : read_shapes(out, plan->out);
    if (plan->n_out < 0) {
        Py_DECREF(plan);
        return NULL;
    }
    for (int k = 0; k < plan->n_in; k++) {
        plan->numbers += plan->in[k].size;
    }
    for (int k = 0; k < plan->n_out; k++) {
        plan->numbers += plan->out[k].size;
    }
    return (PyObject *)plan;
}

static PyTypeObject PlanType = {
    PyVarObject_HEAD_INIT(NULL, 0)
    .tp_name = "kousoku_call.Plan",
    .tp_basicsize = sizeof(Plan),
    .tp_flags = Py_TPFLAGS_DEFAULT | Py_TPFLAGS_HAVE_VECTORCALL,
    .tp_vectorcall_offset = offsetof(Plan, vectorcall),
    .tp_call = PyVectorcall_Call,
    .tp_new = plan_new,
    .tp_doc = "Plan(single, batch, input_shapes, output_shapes): a kernel ready to be called.",
};

static struct PyModuleDef module = {
    PyModuleDef_HEAD_INIT,
    .m_name = "kousoku_call",
    .m_size = -1,
};

PyMODINIT_FUNC PyInit_kousoku_call(void)
{
    import_array();
    if (PyType_Ready(&PlanType) < 0) {
        return NULL;
    }
    PyObject *self = PyModule_Create(&module);
    if (!self || PyModule_AddObjectRef(self, "Plan", (PyObject *)&PlanType) < 0) {
        Py_XDECREF(self);
        return NULL;
    }
#ifdef Py_GIL_DISABLED
    PyUnstable_Module_SetGIL(self, Py_MOD_GIL_NOT_USED);
#endif
    return self;
}
