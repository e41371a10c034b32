"""A step in machine code: C written from the expression of a CasADi function, for one car or for many side by side.

Each instruction of the expression becomes one line inside a loop over cars, on arrays that hold one row per state. The compiler turns that into
vector instructions, sine and its kin included. A C compiler is never required: what needs one says so.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import VehicleError
from ..symbolic import ca

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import NDArray

    Floats = NDArray[np.float64]

#: Fast but not reckless: results may differ from the interpreted step in the last digits; NaN and infinity keep their meaning.
FLAGS = (
    *("-O3", "-march=native", "-mprefer-vector-width=512"),
    *("-fno-math-errno", "-fno-trapping-math", "-fassociative-math", "-fno-signed-zeros", "-freciprocal-math"),
)
#: glibc declares its vector mathematics only to who announces OpenMP and fast arithmetic; neither OpenMP's runtime nor `-ffast-math` is used.
_VECTOR = ("-fopenmp-simd", "-D_OPENMP=201307", "-D__FAST_MATH__")

_BINARY = {"ADD": "{0} + {1}", "SUB": "{0} - {1}", "MUL": "{0} * {1}", "DIV": "{0} / {1}", "POW": "pow({0}, {1})", "CONSTPOW": "pow({0}, {1})"}
_BINARY |= {"FMIN": "({0} < {1} ? {0} : {1})", "FMAX": "({0} > {1} ? {0} : {1})", "ATAN2": "atan2({0}, {1})", "HYPOT": "sqrt({0} * {0} + {1} * {1})"}
_BINARY |= {"LT": "({0} < {1})", "LE": "({0} <= {1})", "EQ": "({0} == {1})", "NE": "({0} != {1})", "AND": "({0} && {1})", "OR": "({0} || {1})"}
_BINARY |= {"IF_ELSE_ZERO": "({0} ? {1} : 0.0)", "COPYSIGN": "copysign({0}, {1})"}
_UNARY = {"NEG": "-{0}", "SQ": "{0} * {0}", "TWICE": "2.0 * {0}", "INV": "1.0 / {0}", "FABS": "fabs({0})", "NOT": "(!{0})", "ASSIGN": "{0}"}
_UNARY |= {"SIGN": "(({0} > 0.0) - ({0} < 0.0))"}
# a cosine beside the sine of the same angle would be joined to `sincos`, which has no vector form
_UNARY |= {"COS": "sin({0} + 1.5707963267948966)"}
_UNARY |= {name.upper(): f"{name}({{0}})" for name in ("sqrt", "sin", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "exp", "log")}
_TEMPLATES = {getattr(ca, f"OP_{name}"): text for name, text in (_BINARY | _UNARY).items() if hasattr(ca, f"OP_{name}")}


def source(function: Any, name: str) -> str:
    """C text of `function` (inputs and outputs dense columns) over `n` cars: `void name(const double** in, double** out, long n)`.

    Row k of an input or output is at `k * n`.

    Raises:
        VehicleError: an operation that this writer does not know.
    """
    lines = []
    for k in range(function.n_instructions()):
        code, to, of = function.instruction_id(k), function.instruction_output(k), function.instruction_input(k)
        if code == ca.OP_CONST:
            lines.append(f"w{to[0]} = {function.instruction_constant(k)!r};")
        elif code == ca.OP_INPUT:
            lines.append(f"w{to[0]} = in{of[0]}[{of[1]} * n + i];")
        elif code == ca.OP_OUTPUT:
            lines.append(f"out{to[0]}[{to[1]} * n + i] = w{of[0]};")
        elif code in _TEMPLATES:
            lines.append(f"w{to[0]} = {_TEMPLATES[code].format(*(f'w{j}' for j in of))};")
        else:
            raise VehicleError(f"operation {code} of {function.name()} has no counterpart in C here")
    inputs = "".join(f"  const double* restrict in{j} = in[{j}];\n" for j in range(function.n_in()))
    outputs = "".join(f"  double* restrict out{j} = out[{j}];\n" for j in range(function.n_out()))
    work = ", ".join(f"w{j}" for j in range(function.sz_w()))
    body = "\n      ".join(lines)
    head = f"#include <math.h>\nvoid {name}(const double** in, double** out, long n) {{\n{inputs}{outputs}"
    return f"{head}  #pragma omp simd\n  for (long i = 0; i < n; i++) {{\n      double {work};\n      {body}\n  }}\n}}\n"


def compiler() -> str:
    """Path of the C compiler.

    Raises:
        VehicleError: there is none.
    """
    for name in ("cc", "gcc", "clang"):
        if found := shutil.which(name):
            return found
    raise VehicleError("no C compiler (cc, gcc, clang) on the path, expected one for compiled steps; interpreted steps need none")


def scalar(function: Any) -> Any:
    """`function` in machine code as a CasADi function, for calls through buffers.

    Raises:
        VehicleError: no compiler, or it refused.
    """
    with tempfile.TemporaryDirectory(prefix="powertrain-") as folder:
        generator = ca.CodeGenerator("step.c")
        generator.add(function)
        generator.generate(f"{folder}/")
        # straight-line code gains nothing from more optimisation, which takes several times as long
        _compile([f"{folder}/step.c"], f"{folder}/step.so", ("-O1",))
        # loaded, the library outlives its file
        return ca.external(function.name(), f"{folder}/step.so")


def _compile(files: list[str], library: str, more: tuple[str, ...]) -> None:
    command = [compiler(), *FLAGS, *more, "-shared", "-fPIC", *files, "-o", library, "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        raise VehicleError(f"{command[0]} refused the step: {(done.stderr.strip().splitlines() or ['no message'])[0]}")


def build(function: Any) -> Callable[[list[Floats], list[Floats], int], None]:
    """`function` in machine code: called with lists of C-contiguous arrays (rows, n) for inputs and outputs, and n.

    Raises:
        VehicleError: no compiler, or it refused.
    """
    with tempfile.TemporaryDirectory(prefix="powertrain-") as folder:
        text = Path(folder, "step.c")
        text.write_text(source(function, "step"), encoding="utf-8")
        _compile([str(text)], f"{folder}/step.so", _VECTOR)
        step = ctypes.CDLL(f"{folder}/step.so").step
    step.argtypes, step.restype = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_long], None

    def call(inputs: list[Floats], outputs: list[Floats], count: int) -> None:
        given = (ctypes.c_void_p * len(inputs))(*(array.ctypes.data for array in inputs))
        taken = (ctypes.c_void_p * len(outputs))(*(array.ctypes.data for array in outputs))
        step(given, taken, count)

    return call
