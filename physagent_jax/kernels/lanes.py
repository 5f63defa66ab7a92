"""Several numbers at once in Numba: the SIMD values of which the kernels are written.

LLVM maps them to whatever registers the machine has. The transfers take sixteen lanes for a row of grid nodes: three
along z with four numbers each (momentum and mass), contiguous in memory, and a fourth node of weight zero. What is left
per particle is done with vectors and rows of matrices, four lanes of which three count. The 3x3 algebra takes eight
lanes for eight particles.
"""

# pyright: reportCallIssue=false, reportGeneralTypeIssues=false, reportPrivateImportUsage=false, reportAttributeAccessIssue=false

from __future__ import annotations

import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable
from numba.np.arrayobj import populate_array

ROW = 16  # lanes of a row of nodes
BATCH = 8  # particles of which the 3x3 algebra is done, or nodes put in another order, at a time
_NODE = 4  # numbers per node
_CONTRACT = ("contract", "nsz")  # multiply-add in one rounding; NaN and infinity keep their meaning
_INDEX = ir.IntType(32)


class Lanes(types.Type):
    """float32 or float64 values, side by side."""

    def __init__(self, dtype: types.Float, count: int = ROW):
        self.dtype, self.count = dtype, count
        super().__init__(name=f"Lanes({dtype}, {count})")


@register_model(Lanes)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, lanes: Lanes):
        scalar = manager.lookup(lanes.dtype).get_value_type()
        super().__init__(manager, lanes, ir.VectorType(scalar, lanes.count))


@intrinsic
def load(typing, array, index):
    """Lanes from ``array[index : index + 16]``, a contiguous one-dimensional array."""
    lanes = Lanes(array.dtype)

    def generate(context, builder, signature, arguments):
        pointer = _find_pointer(context, builder, signature.args[0], arguments, lanes)
        return builder.load(pointer, align=array.dtype.bitwidth // 8)

    return lanes(array, types.intp), generate


@intrinsic
def load_batch(typing, array, index):
    """Eight lanes from ``array[index : index + 8]``, a contiguous one-dimensional array."""
    lanes = Lanes(array.dtype, BATCH)

    def generate(context, builder, signature, arguments):
        pointer = _find_pointer(context, builder, signature.args[0], arguments, lanes)
        return builder.load(pointer, align=array.dtype.bitwidth // 8)

    return lanes(array, types.intp), generate


@intrinsic
def load_one(typing, array, index):
    """One lane, ``array[index]``: code for lanes does a rest with it."""
    lanes = Lanes(array.dtype, 1)

    def generate(context, builder, signature, arguments):
        pointer = _find_pointer(context, builder, signature.args[0], arguments, lanes)
        return builder.load(pointer, align=array.dtype.bitwidth // 8)

    return lanes(array, types.intp), generate


@intrinsic
def store(typing, array, index, value):
    """Write lanes to ``array[index : index + n]``, n being their number."""

    def generate(context, builder, signature, arguments):
        pointer = _find_pointer(context, builder, signature.args[0], arguments, value)
        builder.store(arguments[2], pointer, align=array.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(array, types.intp, value), generate


@intrinsic
def tile(typing, three, fourth):
    """a, b, c, d, a, b, c, d and so on: the numbers of a node, for each node (as `numpy.tile`)."""
    return Lanes(fourth)(three, fourth), _shuffle_numbers([k % _NODE for k in range(ROW)])


@intrinsic
def repeat(typing, three):
    """a, a, a, a, b, b, b, b and so on: a value for all numbers of a node, zero for the fourth (as `numpy.repeat`)."""
    return Lanes(three.dtype)(three), _shuffle_numbers([k // _NODE for k in range(ROW)])


@intrinsic
def splat(typing, value):
    """The value in all lanes."""
    return Lanes(value)(value), _shuffle_numbers([0] * ROW)


@intrinsic
def reduce_add_nodes(typing, lanes):
    """The numbers, each summed over the first three nodes: a `Lanes` of four."""
    result = Lanes(lanes.dtype, _NODE)

    def generate(context, builder, signature, arguments):
        first, second, third = (
            _shuffle(builder, arguments[0], range(_NODE * node, _NODE * (node + 1))) for node in range(3)
        )
        return builder.fadd(builder.fadd(first, second, flags=_CONTRACT), third, flags=_CONTRACT)

    return result(lanes), generate


@intrinsic
def deinterleave(typing, a, b):
    """Of eight nodes' numbers, four nodes in a and four in b: all first ones, all second ones and so on."""
    kind = Lanes(a.dtype, BATCH)
    result = types.UniTuple(kind, _NODE)

    def generate(context, builder, signature, arguments):
        parts = [
            builder.shuffle_vector(*arguments, _make_mask(range(d, 2 * ROW, _NODE))) for d in range(_NODE)
        ]
        return context.make_tuple(builder, result, parts)

    return result(a, a), generate


@intrinsic
def interleave(typing, a, b, c, d):
    """The numbers of eight nodes, four nodes in each result: one of a, of b, of c and of d for each node."""
    result = types.UniTuple(Lanes(a.dtype), 2)

    def generate(context, builder, signature, arguments):
        a, b, c, d = arguments
        everything = _make_mask(range(2 * BATCH))
        ab = builder.shuffle_vector(a, b, everything)
        cd = builder.shuffle_vector(c, d, everything)
        half = ROW // _NODE
        parts = [
            builder.shuffle_vector(
                ab, cd, _make_mask([n * BATCH + k for k in range(k0, k0 + half) for n in range(_NODE)])
            )
            for k0 in (0, half)
        ]
        return context.make_tuple(builder, result, parts)

    return result(a, a, a, a), generate


@intrinsic
def pack(typing, three):
    """A vector: three numbers and a zero."""

    def generate(context, builder, signature, arguments):
        vector = ir.Constant(context.get_value_type(signature.return_type), None)
        for k, number in enumerate(cgutils.unpack_tuple(builder, arguments[0])):
            vector = builder.insert_element(vector, number, _INDEX(k))
        return vector

    return Lanes(three.dtype, _NODE)(three), generate


@intrinsic
def unpack(typing, vector):
    """The three numbers of a vector."""
    result = types.UniTuple(vector.dtype, 3)

    def generate(context, builder, signature, arguments):
        numbers = [builder.extract_element(arguments[0], _INDEX(k)) for k in range(3)]
        return context.make_tuple(builder, result, numbers)

    return result(vector), generate


@intrinsic
def unpack_node(typing, vector):
    """The four numbers of a node."""
    result = types.UniTuple(vector.dtype, _NODE)

    def generate(context, builder, signature, arguments):
        numbers = [builder.extract_element(arguments[0], _INDEX(k)) for k in range(_NODE)]
        return context.make_tuple(builder, result, numbers)

    return result(vector), generate


@intrinsic
def broadcast_each(typing, vector):
    """Three vectors, each with one number of the given one in all lanes."""
    result = types.UniTuple(vector, 3)

    def generate(context, builder, signature, arguments):
        vectors = [_shuffle(builder, arguments[0], [k] * _NODE) for k in range(3)]
        return context.make_tuple(builder, result, vectors)

    return result(vector), generate


@intrinsic
def rotate(typing, vector):
    """The second, third and first number of a vector: its lanes rotated by one."""

    def generate(context, builder, signature, arguments):
        return _shuffle(builder, arguments[0], [1, 2, 0, 3])

    return vector(vector), generate


@intrinsic
def transpose(typing, a, b, c):
    """The rows of the matrix with columns a, b, c."""
    result = types.UniTuple(a, 3)

    def generate(context, builder, signature, arguments):
        a, b, c = arguments
        rows = []
        for k in range(3):
            pair = builder.shuffle_vector(a, b, _make_mask([k, _NODE + k, k, k]))
            rows.append(builder.shuffle_vector(pair, c, _make_mask([0, 1, _NODE + k, 3])))
        return context.make_tuple(builder, result, rows)

    return result(a, a, a), generate


@intrinsic
def load_rows(typing, array, index):
    """Three vectors from ``array[index : index + 9]``: the rows of a matrix. Nothing beyond them is read."""
    vector = Lanes(array.dtype, _NODE)
    result = types.UniTuple(vector, 3)

    def generate(context, builder, signature, arguments):
        loaded = []
        for offset in (
            0,
            3,
            5,
        ):  # the third from within the second, so as not to read beyond the ninth number
            pointer = _find_pointer(context, builder, signature.args[0], arguments, vector, offset)
            loaded.append(builder.load(pointer, align=array.dtype.bitwidth // 8))
        loaded[2] = _shuffle(builder, loaded[2], [1, 2, 3, 3])
        return context.make_tuple(builder, result, loaded)

    return result(array, types.intp), generate


@intrinsic
def store_rows(typing, array, index, a, b, c):
    """Write the rows a, b, c of a matrix to ``array[index : index + 9]``."""

    def generate(context, builder, signature, arguments):
        a, b, c = arguments[2:]
        tail = builder.shuffle_vector(b, c, _make_mask([2, _NODE, _NODE + 1, _NODE + 2]))
        for offset, vector in ((0, a), (3, b), (5, tail)):
            pointer = _find_pointer(context, builder, signature.args[0], arguments, signature.args[2], offset)
            builder.store(vector, pointer, align=array.dtype.bitwidth // 8)
        return context.get_dummy_value()

    return types.void(array, types.intp, a, a, a), generate


@intrinsic
def load_strided(typing, array, start, stride):
    """Eight lanes from ``array[start]``, ``array[start + stride]`` and so on, of a flat array."""
    lanes = Lanes(array.dtype, BATCH)

    def generate(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        vector = ir.Constant(context.get_value_type(lanes), ir.Undefined)
        index = arguments[1]
        for k in range(BATCH):
            vector = builder.insert_element(vector, builder.load(builder.gep(data, [index])), _INDEX(k))
            index = builder.add(index, arguments[2])
        return vector

    return lanes(array, types.intp, types.intp), generate


@intrinsic
def store_strided(typing, array, start, stride, value):
    """Write eight lanes to ``array[start]``, ``array[start + stride]`` and so on."""

    def generate(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        index = arguments[1]
        for k in range(BATCH):
            builder.store(builder.extract_element(arguments[3], _INDEX(k)), builder.gep(data, [index]))
            index = builder.add(index, arguments[2])
        return context.get_dummy_value()

    return types.void(array, types.intp, types.intp, value), generate


@intrinsic
def concatenate(typing, a, b):
    """The lanes of a and then those of b: two batches in one, for arithmetic that would wait for its own results."""
    both = Lanes(a.dtype, 2 * a.count)

    def generate(context, builder, signature, arguments):
        return builder.shuffle_vector(*arguments, _make_mask(range(both.count)))

    return both(a, a), generate


@intrinsic
def split(typing, both):
    """Split a value that `concatenate` made."""
    half = both.count // 2
    result = types.UniTuple(Lanes(both.dtype, half), 2)

    def generate(context, builder, signature, arguments):
        parts = [_shuffle(builder, arguments[0], range(k, k + half)) for k in (0, half)]
        return context.make_tuple(builder, result, parts)

    return result(both), generate


@intrinsic
def splat_like(typing, number, lanes):
    """A number in as many lanes as ``lanes`` has."""

    def generate(context, builder, signature, arguments):
        return _splat(builder, arguments[0], lanes.count)

    return lanes(lanes.dtype, lanes), generate


@intrinsic
def select_greater(typing, a, b, yes, no):
    """``yes`` where a > b, else ``no``, lane by lane."""

    def generate(context, builder, signature, arguments):
        return builder.select(
            builder.fcmp_ordered(">", arguments[0], arguments[1]), arguments[2], arguments[3]
        )

    return yes(a, a, yes, yes), generate


@intrinsic
def has_positive(typing, a):
    """True if any lane is above zero."""

    def generate(context, builder, signature, arguments):
        above = builder.fcmp_ordered(">", arguments[0], ir.Constant(arguments[0].type, None))
        bits = builder.bitcast(above, ir.IntType(a.count))
        return builder.icmp_unsigned("!=", bits, ir.Constant(bits.type, 0))

    return types.boolean(a), generate


@intrinsic
def lesser(typing, a, b):
    """The lesser of a and b, lane by lane."""

    def generate(context, builder, signature, arguments):
        return builder.select(builder.fcmp_ordered("<", *arguments), *arguments)

    return a(a, a), generate


@intrinsic
def sqrt(typing, a):
    """Square roots."""

    def generate(context, builder, signature, arguments):
        return _call_intrinsic(builder, "llvm.sqrt", a, arguments)

    return a(a), generate


@intrinsic
def fabs(typing, a):
    """Absolute values."""

    def generate(context, builder, signature, arguments):
        return _call_intrinsic(builder, "llvm.fabs", a, arguments)

    return a(a), generate


@intrinsic
def exp(typing, a):
    """e^a of float32 lanes, to about 1e-7 relative; a is taken to lie in [-87, 88].

    2^n e^f with n the whole number next to a / ln 2 and a polynomial in f, |f| <= ln 2 / 2 (Cephes, expf). LLVM's own
    intrinsic would call the C library lane by lane.
    """
    if a.dtype != types.float32:
        return None

    def generate(context, builder, signature, arguments):
        def all_lanes(number):
            return _splat(builder, ir.Constant(ir.FloatType(), number), a.count)

        def fma(x, y, z):
            return builder.fadd(builder.fmul(x, y, flags=_CONTRACT), z, flags=_CONTRACT)

        x = arguments[0]
        low, high = all_lanes(-87.0), all_lanes(88.0)
        x = builder.select(builder.fcmp_ordered("<", x, low), low, x)
        x = builder.select(builder.fcmp_ordered(">", x, high), high, x)
        n = _call_intrinsic(builder, "llvm.rint", a, [builder.fmul(x, all_lanes(1.44269504))])
        f = fma(n, all_lanes(-0.693359375), x)
        f = fma(n, all_lanes(2.12194440e-4), f)
        y = all_lanes(1.9875691500e-4)
        for coefficient in (
            1.3981999507e-3,
            8.3334519073e-3,
            4.1665795894e-2,
            1.6666665459e-1,
            5.0000001201e-1,
        ):
            y = fma(y, f, all_lanes(coefficient))
        y = fma(builder.fmul(y, f), f, builder.fadd(f, all_lanes(1.0)))
        whole = ir.VectorType(_INDEX, a.count)
        bits = builder.add(builder.fptosi(n, whole), _splat(builder, _INDEX(127), a.count))
        power = builder.bitcast(builder.shl(bits, _splat(builder, _INDEX(23), a.count)), x.type)
        return builder.fmul(y, power)

    return a(a), generate


@intrinsic
def any_greater(typing, a, b):
    """Return whether a > b in any lane."""

    def generate(context, builder, signature, arguments):
        mask = builder.fcmp_ordered(">", arguments[0], arguments[1])
        bits = ir.IntType(a.count)
        return builder.icmp_unsigned("!=", builder.bitcast(mask, bits), bits(0))

    return types.boolean(a, a), generate


@intrinsic
def reduce_add(typing, a):
    """The sum over the lanes, halves first."""

    def generate(context, builder, signature, arguments):
        vector, count = arguments[0], a.count
        while count > 1:
            count //= 2
            low = _shuffle(builder, vector, range(count))
            high = _shuffle(builder, vector, range(count, 2 * count))
            vector = builder.fadd(low, high, flags=_CONTRACT)
        return builder.extract_element(vector, _INDEX(0))

    return a.dtype(a), generate


@intrinsic
def iota(typing, number):
    """The sixteen numbers 0, 1, 2, ... in the precision of ``number``."""
    lanes = Lanes(number)

    def generate(context, builder, signature, arguments):
        vector = context.get_value_type(lanes)
        return ir.Constant(vector, [float(k) for k in range(ROW)])

    return lanes(number), generate


@intrinsic
def clear(typing, array, first, last):
    """Zeros in ``array[first:last]``, contiguous and with last >= first; a loop over indices is not vectorised."""

    def generate(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        bytes_each = arguments[1].type(array.dtype.bitwidth // 8)
        size = builder.mul(builder.sub(arguments[2], arguments[1]), bytes_each)
        cgutils.memset(builder, builder.gep(data, [arguments[1]]), size, 0)
        return context.get_dummy_value()

    return types.void(array, types.intp, types.intp), generate


@intrinsic
def flatten(typing, array):
    """A C-ordered array's numbers in one dimension; NumPy's ``reshape`` is slow to compile."""
    row = types.Array(array.dtype, 1, "C")

    def generate(context, builder, signature, arguments):
        whole = context.make_array(array)(context, builder, arguments[0])
        made = context.make_array(row)(context, builder)
        populate_array(made, whole.data, [whole.nitems], [whole.itemsize], whole.itemsize, meminfo=None)
        return made._getvalue()

    return row(array), generate


def _call_intrinsic(builder, name: str, lanes: Lanes, arguments):
    vector = arguments[0].type
    full_name = f"{name}.v{lanes.count}f{lanes.dtype.bitwidth}"
    function = cgutils.get_or_insert_function(builder.module, ir.FunctionType(vector, [vector]), full_name)
    return builder.call(function, arguments)


def _splat(builder, number, count: int):
    vector = builder.insert_element(
        ir.Constant(ir.VectorType(number.type, 1), ir.Undefined), number, _INDEX(0)
    )
    return _shuffle(builder, vector, [0] * count)


def _define_operator(symbol, instruction: str) -> None:
    """Give lanes an operator."""

    @type_callable(symbol)
    def typed(context):
        return lambda a, b: a if isinstance(a, Lanes) and a == b else None

    @lower_builtin(symbol, Lanes, Lanes)
    def generate(context, builder, signature, arguments):
        return getattr(builder, instruction)(*arguments, flags=_CONTRACT)


_define_operator(operator.add, "fadd")
_define_operator(operator.sub, "fsub")
_define_operator(operator.mul, "fmul")
_define_operator(operator.truediv, "fdiv")


def _find_pointer(context, builder, array_type, arguments, lanes: Lanes, offset: int = 0):
    array = context.make_array(array_type)(context, builder, arguments[0])
    index = builder.add(arguments[1], arguments[1].type(offset)) if offset else arguments[1]
    address = builder.gep(array.data, [index])
    return builder.bitcast(address, context.get_value_type(lanes).as_pointer())


def _shuffle_numbers(pattern: list[int]):
    """Code that puts its k-th number into the lanes where ``pattern`` says k; those missing are zero."""

    def generate(context, builder, signature, arguments):
        numbers = []
        for kind, argument in zip(signature.args, arguments):
            several = isinstance(kind, types.BaseTuple)
            numbers += cgutils.unpack_tuple(builder, argument) if several else [argument]
        vector = ir.Constant(ir.VectorType(numbers[0].type, _NODE), None)
        for k, number in enumerate(numbers):
            vector = builder.insert_element(vector, number, _INDEX(k))
        return _shuffle(builder, vector, pattern)

    return generate


def _shuffle(builder, vector, pattern):
    return builder.shuffle_vector(vector, ir.Constant(vector.type, ir.Undefined), _make_mask(pattern))


def _make_mask(pattern):
    return ir.Constant(ir.VectorType(_INDEX, len(pattern)), [_INDEX(k) for k in pattern])
