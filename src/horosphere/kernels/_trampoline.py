"""From a Python call to machine code without a detour: the C function behind every direct call (see `_direct`).

It reads the fields of the numpy arrays it is given, and either runs the kernel on their data or answers None, "not the
plain case". In Python it would be

    def direct_call(settings, *items):
        for i, (expected, item) in enumerate(zip(settings.entries, items)):
            if item is None and i >= inputs:
                continue
            array = item.array if expected.slot else item
            if type, dtype, memory order or axes of array are not the expected ones:
                return None
        if an output that was given reaches into an input without being it:
            return None
        make the outputs that were not given
        if not kernel(pointers to the data of all arrays, records):
            return None
        return the outputs, those of a wrapped type read-only in a value of that type

It is emitted as LLVM (one intrinsic in a function of one line): the same text as a loop for numba would take a second to
compile. Objects are addresses, and a structure is read word by word.
"""

from __future__ import annotations

from contextlib import contextmanager

from llvmlite import ir
from numba.core import cgutils, types
from numba.extending import intrinsic

from ._cache import jit

# The fields of an object and of an array that every extension module compiled against numpy 2 reads, in bytes.
OBJECT_TYPE = 8
ARRAY_DATA, ARRAY_AXES, ARRAY_SHAPE, ARRAY_DTYPE, ARRAY_FLAGS = 16, 24, 32, 56, 64
CONTIGUOUS, ALIGNED, WRITEABLE = 0x1, 0x100, 0x400

# The settings, int64 words: these, then one entry for each input and each output.
# LEAD is the input that says what the batch is: the first one that is not alone.
KERNEL, INPUTS, OUTPUTS, NDARRAY, FLOAT64, NONE, NEW_ARRAY, SET_BASE, LEAD, ENTRIES = range(10)
# An entry: type of the argument, where in it the array is (0: it is the array), flags that the array needs, whether it is
# alone (one record that serves the whole batch), number of axes of one record, their lengths; for an output the type of
# the value to return around it (0: none) and where in it the array is.
TYPE, SLOT, FLAGS, ALONE, AXES, LENGTHS, VALUE, VALUE_SLOT, ENTRY = 0, 1, 2, 3, 4, 5, 7, 8, 9
MAX_AXES, MAX_ARRAYS, STACK = 16, 16, 18  # batch axes; inputs and outputs together; what either needs at most
LONG = 4096  # records from which on other Python threads may run meanwhile

_I64, _I32 = ir.IntType(64), ir.IntType(32)


class _Code:
    """The LLVM builder with the few words this function is written in; every value is an int64."""

    def __init__(self, builder, settings, refuse) -> None:
        self.b, self.settings, self.refuse = builder, settings, refuse

    def word(self, address, offset=0):
        """Pointer to the int64 at address + offset bytes."""
        return self.b.inttoptr(self.b.add(address, self.number(offset)), _I64.as_pointer())

    def number(self, value):
        return ir.Constant(_I64, value) if isinstance(value, int) else value

    def read(self, address, offset=0):
        return self.b.load(self.word(address, offset))

    def half(self, address, offset):
        """Pointer to the int32 there."""
        return self.b.inttoptr(self.b.add(address, self.number(offset)), _I32.as_pointer())

    def read_half(self, address, offset):
        return self.b.sext(self.b.load(self.half(address, offset)), _I64)

    def setting(self, index):
        return self.at(self.settings, index)

    def at(self, base, index):
        """Word `index` from the address `base` on."""
        return self.read(base, self.b.mul(self.number(index), self.number(8)))

    def put(self, base, index, value) -> None:
        self.b.store(value, self.word(base, self.b.mul(self.number(index), self.number(8))))

    def stack(self):
        """The address of STACK words."""
        return self.b.ptrtoint(cgutils.alloca_once(self.b, ir.ArrayType(_I64, STACK)), _I64)

    def compare(self, a, how: str, b):
        return self.b.icmp_signed(how, a, self.number(b))

    def need(self, condition) -> None:
        """Answer None unless the condition holds."""
        with self.b.if_then(self.b.not_(condition), likely=False):
            self.b.branch(self.refuse)

    def give_up_if(self, condition) -> None:
        """A Python error has been set: return NULL."""
        with self.b.if_then(condition, likely=False):
            self.b.ret(self.number(0))

    @contextmanager
    def loop(self, count):
        with cgutils.for_range(self.b, self.number(count)) as loop:
            yield loop.index

    def call(self, function, *arguments):
        """Of C, by the address or by name; arguments and result are words."""
        form = ir.FunctionType(_I64, [_I64] * len(arguments))
        if isinstance(function, str):
            function = cgutils.get_or_insert_function(self.b.module, form, function)
        else:
            function = self.b.inttoptr(function, form.as_pointer())
        return self.b.call(function, [self.number(a) for a in arguments])

    # ---- the parts of the function
    def checked_array(self, entry, item):
        """The array that an argument is or holds, if its type, dtype and memory order are the expected ones."""
        slot = self.at(entry, SLOT)
        self.need(self.compare(self.read(item, OBJECT_TYPE), "==", self.at(entry, TYPE)))
        place = cgutils.alloca_once_value(self.b, item)
        with self.b.if_then(self.compare(slot, "!=", 0)):
            inner = self.read(item, slot)
            self.need(self.compare(inner, "!=", 0))
            self.need(self.compare(self.read(inner, OBJECT_TYPE), "==", self.setting(NDARRAY)))
            self.b.store(inner, place)
        array, needed = self.b.load(place), self.at(entry, FLAGS)
        self.need(self.compare(self.read(array, ARRAY_DTYPE), "==", self.setting(FLOAT64)))
        self.need(self.compare(self.b.and_(self.read_half(array, ARRAY_FLAGS), needed), "==", needed))
        return array

    def check_shape(self, entry, array, shape, axes) -> None:
        """Answer None unless the array has the batch axes `shape[:axes]` (alone: at most as many, of length 1), then a record's."""
        own, lengths = self.at(entry, AXES), self.read(array, ARRAY_SHAPE)
        leading = self.b.sub(self.read_half(array, ARRAY_AXES), own)
        alone = self.compare(self.at(entry, ALONE), "!=", 0)
        fewer = self.b.and_(self.compare(leading, ">=", 0), self.compare(leading, "<=", axes))
        self.need(self.b.or_(self.compare(leading, "==", axes), self.b.and_(alone, fewer)))
        with self.loop(leading) as k:
            length = self.at(lengths, k)
            expected = cgutils.alloca_once_value(self.b, self.number(1))
            with self.b.if_then(self.b.not_(alone)):
                self.b.store(self.at(shape, k), expected)
            self.need(self.compare(length, "==", self.b.load(expected)))
        with self.loop(own) as k:
            expected = self.at(entry, self.b.add(k, self.number(LENGTHS)))
            self.need(self.compare(self.at(lengths, self.b.add(leading, k)), "==", expected))

    def size(self, entry, records):
        """Bytes of as many records of an argument."""
        size = cgutils.alloca_once_value(self.b, self.b.mul(records, self.number(8)))
        with self.loop(self.at(entry, AXES)) as k:
            length = self.at(entry, self.b.add(k, self.number(LENGTHS)))
            self.b.store(self.b.mul(self.b.load(size), length), size)
        return self.b.load(size)

    def check_apart(self, out, size, entry, data, records) -> None:
        """Answer None if memory that is written to is also that of an input, unless record by record: those are read first."""
        own = self.size(entry, records)
        before = self.compare(self.b.add(data, own), "<=", out)
        after = self.compare(data, ">=", self.b.add(out, size))
        same = self.b.and_(self.compare(data, "==", out), self.compare(own, "==", size))
        alone = self.compare(self.at(entry, ALONE), "!=", 0)  # read before all others
        self.need(self.b.or_(self.b.or_(before, after), self.b.or_(same, alone)))

    def new_array(self, entry, shape, axes, data, flags):
        """A new array of an output's shape, on `data` if that is not 0."""
        own = self.at(entry, AXES)
        with self.loop(own) as k:
            self.put(shape, self.b.add(axes, k), self.at(entry, self.b.add(k, self.number(LENGTHS))))
        kind, dtype = self.setting(NDARRAY), self.setting(FLOAT64)
        self.call("Py_IncRef", dtype)  # PyArray_NewFromDescr takes over one reference
        array = self.call(self.setting(NEW_ARRAY), kind, dtype, self.b.add(axes, own), shape, 0, data, flags, 0)
        self.give_up_if(self.compare(array, "==", 0))
        return array

    def value_around(self, entry, array):
        """The array in a new value of the output's type."""
        value = self.call("PyType_GenericAlloc", self.at(entry, VALUE), 0)
        self.give_up_if(self.compare(value, "==", 0))
        self.b.store(array, self.word(value, self.at(entry, VALUE_SLOT)))
        return value

    def returned(self, entry, array, given, shape, axes):
        """What an output returns: the array, or a value around it; around a read-only view of one that was given."""
        result = cgutils.alloca_once_value(self.b, array)
        with self.b.if_else(self.compare(given, "==", 0)) as (fresh, written_into):
            with fresh, self.b.if_then(self.compare(self.at(entry, VALUE), "!=", 0)):
                flags = self.half(array, ARRAY_FLAGS)
                self.b.store(self.b.and_(self.b.load(flags), ir.Constant(_I32, ~WRITEABLE)), flags)
                self.b.store(self.value_around(entry, array), result)
            with written_into:
                self.call("Py_IncRef", array)
                with self.b.if_then(self.compare(self.at(entry, VALUE), "!=", 0)):
                    data = self.read(array, ARRAY_DATA)
                    view = self.new_array(entry, shape, axes, data, CONTIGUOUS | ALIGNED)
                    self.call(self.setting(SET_BASE), view, array)  # takes over the reference
                    self.b.store(self.value_around(entry, view), result)
        return self.b.load(result)


def _emit(builder, settings_object, items, count):
    refuse = builder.append_basic_block("refuse")
    c = _Code(builder, None, refuse)
    c.settings = c.call("PyBytes_AsString", settings_object)
    inputs, outputs = c.setting(INPUTS), c.setting(OUTPUTS)
    total = builder.add(inputs, outputs)
    c.need(builder.or_(c.compare(count, "==", inputs), c.compare(count, "==", total)))
    arrays, given, pointers, shape = c.stack(), c.stack(), c.stack(), c.stack()
    axes_place = cgutils.alloca_once_value(builder, c.number(0))
    records_place = cgutils.alloca_once_value(builder, c.number(1))

    def entry_of(i):
        word = builder.add(builder.mul(i, c.number(ENTRY)), c.number(ENTRIES))
        return builder.add(c.settings, builder.mul(word, c.number(8)))

    def find_batch() -> None:
        entry = entry_of(c.setting(LEAD))
        array = c.checked_array(entry, c.at(items, c.setting(LEAD)))
        axes = builder.sub(c.read_half(array, ARRAY_AXES), c.at(entry, AXES))
        c.need(builder.and_(c.compare(axes, ">=", 0), c.compare(axes, "<=", MAX_AXES)))
        builder.store(axes, axes_place)
        lengths = c.read(array, ARRAY_SHAPE)
        with c.loop(axes) as k:
            c.put(shape, k, c.at(lengths, k))
            builder.store(builder.mul(builder.load(records_place), c.at(lengths, k)), records_place)

    find_batch()
    axes, records = builder.load(axes_place), builder.load(records_place)
    with c.loop(total) as i:  # look at what is there
        c.put(given, i, c.number(0))
        is_there = cgutils.alloca_once_value(builder, ir.Constant(ir.IntType(1), 0))
        builder.store(c.compare(i, "<", count), is_there)
        with builder.if_then(c.compare(i, "<", count)):
            is_none = c.compare(c.at(items, i), "==", c.setting(NONE))
            builder.store(builder.not_(builder.and_(is_none, c.compare(i, ">=", inputs))), is_there)
        with builder.if_then(builder.load(is_there)):
            entry = entry_of(i)
            array = c.checked_array(entry, c.at(items, i))
            c.check_shape(entry, array, shape, axes)
            c.put(given, i, array)
            c.put(arrays, i, array)
            c.put(pointers, i, c.read(array, ARRAY_DATA))

    with c.loop(outputs) as k:
        i = builder.add(inputs, k)
        with builder.if_then(c.compare(c.at(given, i), "!=", 0)):
            out, size = c.at(pointers, i), c.size(entry_of(i), records)
            with c.loop(inputs) as j:
                c.check_apart(out, size, entry_of(j), c.at(pointers, j), records)

    with c.loop(outputs) as k:  # make what is not there
        i = builder.add(inputs, k)
        with builder.if_then(c.compare(c.at(given, i), "==", 0)):
            array = c.new_array(entry_of(i), shape, axes, c.number(0), 0)
            c.put(arrays, i, array)
            c.put(pointers, i, c.read(array, ARRAY_DATA))

    good_place = cgutils.alloca_once_value(builder, c.number(0))
    with builder.if_else(c.compare(records, "<", LONG), likely=True) as (short, long):
        with short:
            builder.store(c.call(c.setting(KERNEL), pointers, records), good_place)
        with long:
            thread = c.call("PyEval_SaveThread")
            builder.store(c.call(c.setting(KERNEL), pointers, records), good_place)
            c.call("PyEval_RestoreThread", thread)
    with builder.if_then(c.compare(builder.load(good_place), "==", 0), likely=False):
        with c.loop(outputs) as k:
            i = builder.add(inputs, k)
            with builder.if_then(c.compare(c.at(given, i), "==", 0)):
                c.call("Py_DecRef", c.at(arrays, i))
        builder.branch(refuse)

    def result(k):
        i = builder.add(inputs, k)
        return c.returned(entry_of(i), c.at(arrays, i), c.at(given, i), shape, axes)

    with builder.if_then(c.compare(outputs, "==", 1), likely=True):
        builder.ret(result(c.number(0)))
    several = c.call("PyTuple_New", outputs)
    c.give_up_if(c.compare(several, "==", 0))
    with c.loop(outputs) as k:
        c.call("PyTuple_SetItem", several, k, result(k))
    builder.ret(several)

    builder.position_at_end(refuse)
    c.call("Py_IncRef", c.setting(NONE))
    builder.ret(c.setting(NONE))


@intrinsic
def _trampoline(typing_context, settings, items, count):
    def code(context, builder, sig, args):
        function = ir.Function(builder.module, ir.FunctionType(_I64, [_I64] * 3), "horosphere_direct_call")
        function.linkage = "internal"
        _emit(ir.IRBuilder(function.append_basic_block("entry")), *function.args)
        return builder.call(function, args)

    return types.intp(settings, items, count), code


@jit(no_cpython_wrapper=True, no_cfunc_wrapper=False)
def direct_call(settings, items, count):
    """METH_FASTCALL of a direct call: inputs, then for each output an array to write into or None (also if left out)."""
    return _trampoline(settings, items, count)  # type: ignore[call-arg]
