"""How Python calls compiled code without numba: entry points in LLVM's language, and their loading.

Numba's own entry points need numba, whose import and whose first look at a type take half a second.
The one that is written here, when a kernel is compiled, is a function of CPython's interface. It
looks whether the arguments are of the kernel's types (``NotImplemented`` is returned if not), hands
arrays, numbers, tuples and None to the machine code as numba would, and raises MemoryError if that
says that it failed: kernels raise nothing but for arrays that they make. Kernel and entry point are
kept as object code, which llvmlite alone loads.

The places of the fields of arrays and of their types are NumPy's binary interface;
`fields_are_known` looks whether they are where they are expected.
"""

from __future__ import annotations

import ctypes
import sys
import threading
from collections.abc import Callable, Iterator, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from llvmlite import binding  # type: ignore[import-untyped]

__all__ = ["Machine", "Unsupported", "fields_are_known", "load", "processor", "write"]

HEADER = object.__basicsize__
DATA, NDIM, SHAPE, STRIDES, DTYPE, FLAGS = (HEADER + 8 * n for n in (0, 1, 2, 3, 5, 6))
ORDER, KIND = HEADER + 10, HEADER + 12
TYPE, DOUBLE = HEADER - 8, float.__basicsize__ - 8
CONTIGUOUS, ALIGNED, WRITEABLE = {"C": 1, "F": 2, "A": 0}, 0x100, 0x400
FASTCALL = 0x80
DTYPES = "dDlq"
"""Types of arrays: doubles, complex doubles and the integers of 64 bits."""


DESTRUCTOR = "NRT_MemInfo_call_dtor"
"""What numba calls when an array of its own is left: never in a kernel that makes none."""


class Unsupported(TypeError):
    """What has no entry point of this kind."""


class Machine(NamedTuple):
    """A kernel for one signature: its object code, that of its entry point, and what they need.

    ``entry`` is the entry point's symbol, ``needed`` are the symbols from outside.
    """

    entry: str
    kernel: bytes
    caller: bytes
    needed: Sequence[str]


@lru_cache
def fields_are_known() -> bool:
    """Whether objects lie in memory as the entry points expect; not so in another interpreter."""
    if sys.implementation.name != "cpython" or ctypes.sizeof(ctypes.c_void_p) != 8:
        return False
    array, number = np.zeros((3, 5))[:, ::2], 0.1
    words = {
        DATA: array.__array_interface__["data"][0],
        DTYPE: id(array.dtype),
        TYPE: id(np.ndarray),
    }
    found = [ctypes.c_ssize_t.from_address(id(array) + place).value for place in words]
    ints = [ctypes.c_int.from_address(id(array) + place).value for place in (NDIM, FLAGS)]
    axes = [
        (ctypes.c_ssize_t * 2).from_address(ctypes.c_ssize_t.from_address(id(array) + place).value)
        for place in (SHAPE, STRIDES)
    ]
    kind = id(array.dtype)
    return (
        ctypes.c_char.from_address(kind + ORDER).value == b"="
        and ctypes.c_int.from_address(kind + KIND).value == array.dtype.num
        and found == [*words.values()]
        and ints == [2, array.flags.num]
        and [tuple(axis) for axis in axes] == [array.shape, array.strides]
        and ctypes.c_double.from_address(id(number) + DOUBLE).value == number
    )


@lru_cache
def processor() -> str:
    """The processor that machine code is for."""
    return f"{binding.get_host_cpu_name()} {binding.get_host_cpu_features().flatten()}"


class _Method(ctypes.Structure):
    _fields_ = (
        ("name", ctypes.c_char_p),
        ("address", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_char_p),
    )


_methods: list[_Method] = []
_lock = threading.Lock()


@lru_cache
def _engine(has_arrays: bool) -> Any:
    """What machine code is loaded into: kernels that make arrays are apart from those that do not.

    Both have numba's functions for arrays in them, and one engine would take those of the first.
    """
    binding.initialize_native_target()
    binding.initialize_native_asmprinter()
    triple = binding.get_process_triple()
    machine = binding.Target.from_triple(triple).create_target_machine(jit=True)
    module = binding.parse_assembly(f'target triple = "{triple}"')
    for name, value in {"ndarray": np.ndarray, "float64": np.float64}.items():
        binding.add_symbol(f"longwave_{name}", id(value))
    return binding.create_mcjit_compiler(module, machine)


def load(machine: Machine) -> Callable[..., Any] | None:
    """The kernel as Python calls it; None if something that it needs is not in the process."""
    has_arrays = any(name.startswith("NRT_") and name != DESTRUCTOR for name in machine.needed)
    with _lock:
        engine = _engine(has_arrays)
        if not has_arrays and binding.address_of_symbol(DESTRUCTOR) is None:
            binding.add_symbol(DESTRUCTOR, binding.address_of_symbol("Py_FatalError"))
        if any(binding.address_of_symbol(name) is None for name in machine.needed):
            return None
        for code in (machine.kernel, machine.caller):
            engine.add_object_file(binding.ObjectFileRef.from_data(code))
        engine.finalize_object()
        address = engine.get_function_address(machine.entry)
        _methods.append(_Method(b"kernel", address, FASTCALL, None))
        make = ctypes.pythonapi.PyCFunction_NewEx
        make.restype, make.argtypes = ctypes.py_object, [ctypes.c_void_p] * 3
        found: Callable[..., Any] = make(ctypes.addressof(_methods[-1]), None, None)
    return found


def write(context: Any, compiled: Any, name: str, nogil: bool) -> Machine:
    """The entry point of what numba has ``compiled`` in its ``context``, with the object code.

    Raises Unsupported for arguments and results that it cannot hand over.
    """
    codegen, library = context.codegen(), compiled.library
    module = codegen.create_library(f"entry of {name}").create_ir_module(f"entry of {name}")
    _Writer(context, module, compiled.fndesc, name, nogil).write()
    parsed = binding.parse_assembly(str(module))
    parsed.verify()
    needed = {*_declared(library._final_module), *_declared(parsed)}
    needed -= {compiled.fndesc.llvm_func_name}
    caller = codegen._tm.emit_object(parsed)
    kernel = library._get_compiled_object()
    return Machine(f"longwave.{name}", kernel, caller, sorted(needed))


def _declared(module: Any) -> Iterator[str]:
    """The symbols that a module takes from outside."""
    for values in (module.functions, module.global_variables):
        for value in values:
            if value.is_declaration and not value.name.startswith("llvm."):
                yield value.name


class _Writer:
    """Writes one entry point."""

    def __init__(self, context: Any, module: Any, fndesc: Any, name: str, nogil: bool) -> None:
        from llvmlite import ir
        from numba.core import cgutils, types

        self._ir, self._cgutils, self._types = ir, cgutils, types
        self._context, self._module, self._fndesc, self._nogil = context, module, fndesc, nogil
        self._object, self._word = cgutils.voidptr_t, ir.IntType(64)
        signature = [self._object, self._object.as_pointer(), self._word]
        kind = ir.FunctionType(self._object, signature)
        self._entry = ir.Function(module, kind, name=f"longwave.{name}")
        self._builder = ir.IRBuilder(self._entry.append_basic_block("begin"))

    def write(self) -> None:
        """Write it all."""
        builder, (_, given, count) = self._builder, self._entry.args
        flat = [*self._flat(self._fndesc.argtypes)]
        self._demand(builder.icmp_signed("==", count, self._word(len(flat))))
        items = iter([builder.load(builder.gep(given, [self._word(n)])) for n in range(len(flat))])
        values = [self._argument(kind, items) for kind in self._fndesc.argtypes]
        native = self._context.declare_function(self._module, self._fndesc)
        thread = self._call("PyEval_SaveThread", self._object) if self._nogil else None
        status, result = self._context.call_conv.call_function(
            builder, native, self._fndesc.restype, self._fndesc.argtypes, values
        )
        if thread is not None:
            self._call("PyEval_RestoreThread", self._ir.VoidType(), thread)
        with self._cgutils.if_unlikely(builder, status.is_error):
            failure = builder.load(self._external("PyExc_MemoryError", self._object))
            text = self._context.insert_const_string(self._module, "a kernel has no memory")
            self._call("PyErr_SetString", self._ir.VoidType(), failure, text)
            builder.ret(self._object(None))
        builder.ret(self._result(result))

    def _flat(self, kinds: Any) -> Iterator[Any]:
        """The types of the arguments one by one: those of ``*arguments`` are apart."""
        for kind in kinds:
            if isinstance(kind, self._types.StarArgTuple | self._types.StarArgUniTuple):
                yield from kind
            else:
                yield kind

    def _result(self, value: Any) -> Any:
        kind, types = self._fndesc.restype, self._types
        if kind == types.none:
            return self._shared("_Py_NoneStruct")
        if kind == types.float64:
            return self._call("PyFloat_FromDouble", self._object, value)
        raise Unsupported(f"no entry point gives {kind}")

    def _argument(self, kind: Any, items: Iterator[Any]) -> Any:
        """The machine code's argument of that type, made from the next object or objects."""
        types, builder = self._types, self._builder
        if isinstance(kind, types.StarArgTuple | types.StarArgUniTuple):
            values = [self._argument(inner, items) for inner in kind]
            return self._context.make_tuple(builder, kind, values)
        item = next(items)
        if isinstance(kind, types.BaseTuple):
            return self._tuple(kind, item)
        if isinstance(kind, types.Array):
            return self._array(kind, item)
        if kind == types.float64:
            found = [self._is_of(item, name) for name in ("PyFloat_Type", "longwave_float64")]
            self._demand(builder.or_(*found))
            return self._field(item, DOUBLE, self._ir.DoubleType())
        if kind == types.int64:
            self._demand(self._is_of(item, "PyLong_Type"))
            value = self._call("PyLong_AsLongLong", self._word, item)
            failed = self._call("PyErr_Occurred", self._object)
            with self._cgutils.if_unlikely(builder, self._cgutils.is_not_null(builder, failed)):
                builder.ret(self._object(None))
            return value
        if kind == types.none:
            self._demand(self._is(item, "_Py_NoneStruct"))
            return self._context.get_dummy_value()
        raise Unsupported(f"no entry point takes {kind}")

    def _tuple(self, kind: Any, item: Any) -> Any:
        self._demand(self._is_of(item, "PyTuple_Type"))
        size = self._call("PyTuple_Size", self._word, item)
        self._demand(self._builder.icmp_signed("==", size, self._word(len(kind))))
        parts = iter(
            [
                self._call("PyTuple_GetItem", self._object, item, self._word(n))
                for n in range(len(kind))
            ]
        )
        values = [self._argument(inner, parts) for inner in kind]
        return self._context.make_tuple(self._builder, kind, values)

    def _array(self, kind: Any, item: Any) -> Any:
        from numba.np.numpy_support import as_dtype

        builder, ir = self._builder, self._ir
        dtype = as_dtype(kind.dtype)
        if dtype.char not in DTYPES:
            raise Unsupported(f"no entry point takes arrays of {dtype}")
        self._demand(self._is_of(item, "longwave_ndarray"))
        number, byte = ir.IntType(32), ir.IntType(8)
        found = self._field(item, DTYPE, self._object)
        native = builder.icmp_signed("==", self._field(found, ORDER, byte), byte(ord("=")))
        alike = builder.icmp_signed("==", self._field(found, KIND, number), number(dtype.num))
        self._demand(builder.and_(native, alike))
        ndim = self._field(item, NDIM, number)
        self._demand(builder.icmp_signed("==", ndim, number(kind.ndim)))
        wanted = CONTIGUOUS[kind.layout] | ALIGNED * kind.aligned | WRITEABLE * kind.mutable
        flags = builder.and_(self._field(item, FLAGS, number), number(wanted))
        self._demand(builder.icmp_signed("==", flags, number(wanted)))
        array = self._context.make_array(kind)(self._context, builder)
        axes = ir.ArrayType(self._word, kind.ndim).as_pointer()
        shape = builder.load(self._field(item, SHAPE, axes))
        count = self._word(1)
        for axis in range(kind.ndim):
            count = builder.mul(count, builder.extract_value(shape, axis))
        array.shape, array.nitems = shape, count
        array.strides = builder.load(self._field(item, STRIDES, axes))
        array.itemsize = self._word(dtype.itemsize)
        array.data = builder.bitcast(self._field(item, DATA, self._object), array.data.type)
        array.meminfo = array.parent = self._cgutils.get_null_value(self._object)
        return array._getvalue()

    def _field(self, item: Any, place: int, kind: Any) -> Any:
        address = self._builder.gep(item, [self._word(place)])
        return self._builder.load(self._builder.bitcast(address, kind.as_pointer()))

    def _is(self, item: Any, name: str) -> Any:
        """Whether it is the object of that symbol."""
        return self._builder.icmp_unsigned("==", item, self._external(name, self._ir.IntType(8)))

    def _is_of(self, item: Any, name: str) -> Any:
        """Whether its type is that of that symbol."""
        return self._is(self._field(item, TYPE, self._object), name)

    def _demand(self, condition: Any) -> None:
        """Leave with NotImplemented unless the condition holds."""
        with self._cgutils.if_unlikely(self._builder, self._builder.not_(condition)):
            self._builder.ret(self._shared("_Py_NotImplementedStruct"))

    def _shared(self, name: str) -> Any:
        """One of Python's own objects, counted once more."""
        found = self._external(name, self._ir.IntType(8))
        self._call("Py_IncRef", self._ir.VoidType(), found)
        return found

    def _external(self, name: str, kind: Any) -> Any:
        known = self._module.globals
        return known[name] if name in known else self._ir.GlobalVariable(self._module, kind, name)

    def _call(self, name: str, result: Any, *values: Any) -> Any:
        """A call of Python's interface in C."""
        known = self._module.globals
        if name not in known:
            kind = self._ir.FunctionType(result, [value.type for value in values])
            self._ir.Function(self._module, kind, name=name)
        return self._builder.call(known[name], values)
