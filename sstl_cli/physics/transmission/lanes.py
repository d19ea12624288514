"""Vectors for compiled code: numbers of several lines side by side, one to a lane, which the processor handles at once.

A compiler turns loops over lanes into vector instructions only where it can prove a great deal. Here a row of an array is one
value, and arithmetic on it is vector arithmetic on every machine. Results are those of scalar code bit by bit, but for
``exp`` and ``log``.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

import numpy as np
from llvmlite import ir
from numba import njit, types
from numba.core import cgutils
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import intrinsic, lower_builtin, models, register_model

# lines that go side by side
WIDTH = 8
# exp of less is 0 in any sum with numbers of ordinary size
FAINTEST = -700.0
# adding it leaves the nearest whole number in the last bits of the sum
ROUNDER = 1.5 * 2.0**52
PER_LN2, ROOT_2 = 1.4426950408889634, 1.4142135623730951
# ln 2 in two parts, the first with zeros at its end
LN2_HIGH, LN2_LOW = 6.93147180369123816490e-01, 1.90821492927058770002e-10
FRACTION_BITS = 52
ONE_AND_HALF_TOP = (1023 + 52) << 52 | 1 << 51

_INDEX = ir.IntType(32)
_VECTOR, _BITS, _WORDS, _INDICES = (ir.VectorType(t, WIDTH) for t in (ir.DoubleType(), ir.IntType(1), ir.IntType(64), _INDEX))


class _Vector(types.Type):
    """A number to each lane."""


class _Mask(types.Type):
    """Yes or no to each lane."""


VECTOR, MASK = _Vector(f"vector{WIDTH}"), _Mask(f"mask{WIDTH}")


@register_model(_Vector)
class _VectorModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: types.Type) -> None:
        super().__init__(manager, kind, _VECTOR)  # type: ignore[no-untyped-call]


@register_model(_Mask)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager: Any, kind: types.Type) -> None:
        super().__init__(manager, kind, _BITS)  # type: ignore[no-untyped-call]


def _spread(builder: Any, kind: types.Type, value: Any) -> Any:
    """Return a scalar in every lane, and a vector as it is."""
    if kind in (VECTOR, MASK):
        return value
    nothing = ir.Constant(_VECTOR, ir.Undefined)
    first = builder.insert_element(nothing, value, ir.Constant(_INDEX, 0))
    return builder.shuffle_vector(first, nothing, ir.Constant(_INDICES, None))


def _define(op: Callable[..., Any], result: types.Type, made: Callable[..., Any], *forms: tuple[types.Type, ...]) -> None:
    """Give an operator a meaning for vectors: ``made`` builds its instruction."""
    infer_global(op)(type(f"_{op.__name__}", (ConcreteTemplate,), {"cases": [signature(result, *f) for f in forms]}))

    def lowered(_: Any, builder: Any, sig: Any, args: Any) -> Any:
        return made(builder, *(_spread(builder, t, x) for t, x in zip(sig.args, args, strict=True)))

    for form in forms:
        lower_builtin(op, *form)(lowered)


def _plain(name: str) -> Callable[..., Any]:
    return lambda builder, *args: getattr(builder, name)(*args)


def _compare(sign: str) -> Callable[..., Any]:
    name = "fcmp_unordered" if sign == "!=" else "fcmp_ordered"
    return lambda builder, a, b: getattr(builder, name)(sign, a, b)


_PAIRS = ((VECTOR, VECTOR), (VECTOR, types.float64), (types.float64, VECTOR))
for _op, _name in ((operator.add, "fadd"), (operator.sub, "fsub"), (operator.mul, "fmul"), (operator.truediv, "fdiv")):
    _define(_op, VECTOR, _plain(_name), *_PAIRS)
for _op, _name in (
    (operator.lt, "<"), (operator.le, "<="), (operator.gt, ">"), (operator.ge, ">="), (operator.eq, "=="), (operator.ne, "!="),
):  # fmt: skip
    _define(_op, MASK, _compare(_name), *_PAIRS)
_define(operator.neg, VECTOR, _plain("fneg"), (VECTOR,))
_define(operator.and_, MASK, _plain("and_"), (MASK, MASK))
_define(operator.or_, MASK, _plain("or_"), (MASK, MASK))
_define(operator.invert, MASK, _plain("not_"), (MASK,))


def _instructions(made: Callable[..., Any]) -> Any:
    """Give compiled code a function by the instructions that it is made of."""
    return intrinsic(made)


def _place(context: Any, builder: Any, sig: Any, args: Any) -> Any:
    """Return where row ``args[1]`` of the array ``args[0]`` lies; its rows are as long as a vector, one after the other."""
    data = context.make_array(sig.args[0])(context, builder, args[0]).data
    data = builder.bitcast(data, ir.DoubleType().as_pointer())
    first = builder.gep(data, [builder.mul(args[1], ir.Constant(ir.IntType(64), WIDTH))])
    return builder.bitcast(first, _VECTOR.as_pointer())


@_instructions
def row(_: Any, rows: Any, index: Any) -> Any:
    """Return a row of an array of shape (rows, WIDTH)."""

    def made(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return builder.load(_place(context, builder, sig, args), align=8)

    return VECTOR(rows, types.int64), made


@_instructions
def put(_: Any, rows: Any, index: Any, value: Any) -> Any:
    """Write a vector to a row of an array of shape (rows, WIDTH)."""

    def made(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        builder.store(args[2], _place(context, builder, sig, args[:2]), align=8)
        return context.get_dummy_value()

    return types.void(rows, types.int64, VECTOR), made


@_instructions
def wide(_: Any, value: Any) -> Any:
    """Return a scalar in every lane."""
    return VECTOR(types.float64), lambda context, builder, sig, args: _spread(builder, sig.args[0], args[0])


@_instructions
def select(_: Any, mask: Any, yes: Any, no: Any) -> Any:
    """Return ``yes`` where the mask holds, else ``no``."""

    def made(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        yes, no = (_spread(builder, t, x) for t, x in zip(sig.args[1:], args[1:], strict=True))
        return builder.select(args[0], yes, no)

    return VECTOR(MASK, yes if yes == VECTOR else types.float64, no if no == VECTOR else types.float64), made


@_instructions
def some(_: Any, mask: Any) -> Any:
    """Tell whether a mask holds in any lane."""

    def made(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", bits, ir.Constant(ir.IntType(WIDTH), 0))

    return types.boolean(MASK), made


def _of_each(name: str) -> Callable[..., Any]:
    """Return how a function that the compiler knows is called for vectors."""

    def made(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        kind = ir.FunctionType(_VECTOR, [_VECTOR])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64"), args)

    return made


@_instructions
def size(_: Any, x: Any) -> Any:
    """Return the absolute values."""
    return VECTOR(VECTOR), _of_each("fabs")


@_instructions
def root(_: Any, x: Any) -> Any:
    """Return the square roots."""
    return VECTOR(VECTOR), _of_each("sqrt")


@_instructions
def _to_power(_: Any, x: Any, rounded: Any) -> Any:
    """Return x 2^k for k in the last bits of ``rounded``."""

    def made(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits = ir.Constant(_WORDS, [FRACTION_BITS] * WIDTH)
        power = builder.shl(builder.bitcast(args[1], _WORDS), bits)
        return builder.bitcast(builder.add(builder.bitcast(args[0], _WORDS), power), _VECTOR)

    return VECTOR(VECTOR, VECTOR), made


@_instructions
def _parted(_: Any, x: Any) -> Any:
    """Return k and x 2^-k of numbers above 0, the latter from 1 to 2."""

    def made(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        bits = builder.bitcast(args[0], _WORDS)
        # a power of at most 2^11 in the last bits of a number whose rest is known
        base = ir.Constant(_WORDS, [ONE_AND_HALF_TOP] * WIDTH)
        power = builder.or_(builder.lshr(bits, ir.Constant(_WORDS, [FRACTION_BITS] * WIDTH)), base)
        top = ir.Constant(_VECTOR, [ROUNDER + 1023.0] * WIDTH)
        whole = builder.fsub(builder.bitcast(power, _VECTOR), top)
        fraction = builder.and_(bits, ir.Constant(_WORDS, [2**FRACTION_BITS - 1] * WIDTH))
        fraction = builder.or_(fraction, ir.Constant(_WORDS, [1023 << FRACTION_BITS] * WIDTH))
        return context.make_tuple(builder, sig.return_type, (whole, builder.bitcast(fraction, _VECTOR)))

    return types.UniTuple(VECTOR, 2)(VECTOR), made


@njit(error_model="numpy", inline="always")
def larger(a: Any, b: Any) -> Any:
    """Return the larger numbers."""
    return select(b > a, b, a)


@njit(error_model="numpy", inline="always")
def exp(x: Any) -> Any:
    """Return exp of numbers of at most 0, to within two units in the last place.

    What is left beside a power of two is at most half of ln 2, and Taylor's series for it ends where doubles do.
    """
    x = larger(x, FAINTEST)
    rounded = x * PER_LN2 + ROUNDER
    whole = rounded - ROUNDER
    r = (x - whole * LN2_HIGH) - whole * LN2_LOW
    p = r * (1.0 / 6227020800.0) + 1.0 / 479001600.0
    p = p * r + 1.0 / 39916800.0
    p = p * r + 1.0 / 3628800.0
    p = p * r + 1.0 / 362880.0
    p = p * r + 1.0 / 40320.0
    p = p * r + 1.0 / 5040.0
    p = p * r + 1.0 / 720.0
    p = p * r + 1.0 / 120.0
    p = p * r + 1.0 / 24.0
    p = p * r + 1.0 / 6.0
    p = p * r + 0.5
    return _to_power(p * r * r + r + 1.0, rounded)


@njit(error_model="numpy", inline="always")
def log(x: Any) -> Any:
    """Return natural logarithms of ordinary numbers above 0, to within two units in the last place of the larger of them and 1.

    What is left beside a power of two is within a root of two of 1, and the series of the inverse hyperbolic tangent is short.
    """
    whole, part = _parted(x)
    high = part > ROOT_2
    whole, part = select(high, whole + 1.0, whole), select(high, 0.5 * part, part)
    s = (part - 1.0) / (part + 1.0)
    z = s * s
    p = z * (2.0 / 23.0) + 2.0 / 21.0
    p = p * z + 2.0 / 19.0
    p = p * z + 2.0 / 17.0
    p = p * z + 2.0 / 15.0
    p = p * z + 2.0 / 13.0
    p = p * z + 2.0 / 11.0
    p = p * z + 2.0 / 9.0
    p = p * z + 2.0 / 7.0
    p = p * z + 2.0 / 5.0
    p = p * z + 2.0 / 3.0
    return whole * LN2_HIGH + (whole * LN2_LOW + (2.0 * s + s * z * p))


@njit(cache=True, error_model="numpy")
def rows(count: int) -> Any:
    """Return an array of zeros, shape (count, WIDTH), in which no row lies across two lines of the processor's cache."""
    flat = np.zeros((count + 1) * WIDTH)
    first = -(flat.ctypes.data // flat.itemsize) % WIDTH
    return flat[first : first + count * WIDTH].reshape((count, WIDTH))
