"""The peers, each set up as its documentation advises, from the same formula."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from tests.benchmarks.kit import required
from tests.benchmarks.p2 import SIZES, p2, symbols

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence


def casadi_source(folder: Path, *, cse: bool) -> Path:
    """Write CasADi's C of p2, with or without its elimination of common subexpressions."""
    casadi = required("casadi")
    name = "casadi_cse" if cse else "casadi_plain"
    arguments = symbols(casadi.SX.sym)
    c, rows = p2(*arguments)
    outputs = [casadi.vertcat(*c), casadi.vertcat(*(casadi.horzcat(*row) for row in rows))]
    columns = [casadi.vertcat(*argument) for argument in arguments]
    function = casadi.Function(name, columns, outputs, {"cse": cse})
    generator = casadi.CodeGenerator(f"{name}.c", {"with_header": True})
    generator.add(function)
    generator.generate(f"{folder}/")
    return folder / f"{name}.c"


def symforce_header(folder: Path) -> Path:
    """Write SymForce's C++ of p2."""
    required("symforce").set_epsilon_to_number()
    sf = required("symforce.symbolic")
    codegen = required("symforce.codegen")

    def symforce_p2(
        r_i: Any, p_i: Any, a_i_b: Any, s_i_b: Any, r_j: Any, p_j: Any, s_j_b: Any
    ) -> tuple[Any, Any]:
        arguments = (r_i, p_i, a_i_b, s_i_b, r_j, p_j, s_j_b)
        c, rows = p2(*(list(argument.to_storage()) for argument in arguments))
        return sf.V2(*c), sf.Matrix(2, 12, [x for row in rows for x in row])

    made = codegen.Codegen.function(
        symforce_p2,
        config=codegen.CppConfig(),
        input_types=[sf.V3 if size == 3 else sf.V4 for size in SIZES.values()],
        output_names=["C", "C_q"],
    )
    files = made.generate_function(output_dir=folder, skip_directory_nesting=True)
    return Path(files.generated_files[0])


def sympy_source(folder: Path, *, cse: bool) -> Path:
    """Write the C of SymPy's code generation, with or without common subexpressions once."""
    sympy = required("sympy")
    codegen = required("sympy.utilities.codegen")
    name = "sympy_cse" if cse else "sympy_plain"
    arrays = [sympy.MatrixSymbol(key, size, 1) for key, size in SIZES.items()]
    c, rows = p2(*([x[k, 0] for k in range(x.rows)] for x in arrays))
    outputs = sympy.MatrixSymbol("C", 2, 1), sympy.MatrixSymbol("C_q", 2, 12)
    values = sympy.Matrix(c), sympy.Matrix(rows)
    results = [sympy.Eq(one, value) for one, value in zip(outputs, values, strict=True)]
    writer = codegen.C99CodeGen(cse=cse)
    routine = writer.routine(name, results, [*arrays, *outputs])
    for file, text in writer.write([routine], name):
        (folder / file).write_text(text, encoding="utf-8")
    return folder / f"{name}.c"


def heyoka_functions() -> dict[str, Callable[[np.ndarray, np.ndarray], object]]:
    """Calls of heyoka's compiled function, from (23, n) into (26, n), on one thread.

    The first is the call of its tutorial; the second also leaves out the division into tasks.
    """
    heyoka = required("heyoka")
    heyoka.set_nthreads(1)
    arguments = symbols(heyoka.make_vars)
    c, rows = p2(*arguments)
    outputs, variables = [*c, *rows[0], *rows[1]], [x for xs in arguments for x in xs]
    function = heyoka.cfunc(outputs, variables)
    return {
        "cfunc": lambda columns, values: function(columns, outputs=values),
        "cfunc, not divided": lambda columns, values: function(
            columns, outputs=values, batch_parallel=False
        ),
    }


def lambdified() -> Callable[..., Sequence[Any]]:
    """SymPy's NumPy function of 23 arguments, a list of 26 numbers or arrays."""
    sympy = required("sympy")
    arguments = symbols(sympy.Symbol)
    c, rows = p2(*arguments)
    flat = [x for xs in arguments for x in xs]
    made: Callable[..., Sequence[Any]] = sympy.lambdify(
        flat, [*c, *rows[0], *rows[1]], modules="numpy", cse=True
    )
    return made


def stacked(values: Sequence[Any], c: np.ndarray, c_q: np.ndarray) -> None:
    """Write what :func:`lambdified` returns into C (n, 2) and C_q (n, 2, 12)."""
    np.stack(values[:2], axis=-1, out=c)
    np.stack(values[2:], axis=-1, out=c_q.reshape(*c_q.shape[:-2], 24))
