"""Numba's ``njit`` with cached kernels that are called without importing numba.

Importing numba and its first type inference take half a second, so numba is only used when a kernel
is first called with arguments of some types. The LLVM text it produces is compiled and cached by
`support.compiled.native_code`; the next process loads the machine code without numba. For the
``examples`` of a kernel the text is shipped with the package (`support.compiled.shipped_kernels`).

Arguments are passed as 64-bit words: the address of NumPy's array object, the items of a tuple, 0
for None. The entry function passes arrays on as numba's kernels do: owner, twice (here 0), size,
item size, address, shape and strides.
"""

from __future__ import annotations

import ctypes
import functools
import os
import re
import struct
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import nullcontext
from functools import cached_property, lru_cache
from types import MethodType
from typing import Any

import numpy as np
from numpy.typing import NDArray

Arguments = tuple[Any, ...]

OPTIONS: dict[str, Any] = {"error_model": "numpy", "fastmath": False}
"""Default options. A function without ``fastmath`` would take it from the first kernel that calls
it, and last digits would depend on what a process compiled before."""

NO_WRAPPERS = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
"""Options that leave out numba's own wrappers, which halves the compile time."""

LARGEST = 2**63

PROTOTYPE = ctypes.CFUNCTYPE(ctypes.c_int32, ctypes.c_char_p)

C_ORDER, OF_C, OF_OTHERS = 0x1, 0x501, 0x502
"""NumPy's array flags: C order; C order, aligned, writeable; Fortran order, aligned, writeable."""

DATA, SHAPE, STRIDES = (object.__basicsize__ // 8 + offset for offset in (0, 2, 3))
"""Word offsets of the addresses of data, shape and strides in an array object (NumPy's ABI)."""

ENTRY = "kernel"
"""Name of the exported function, which takes the address of the words."""

NEVER_CALLED = re.compile(r"^declare (void @NRT_MemInfo_call_dtor\(.*?\)).*$", re.MULTILINE)
"""Declaration of numba's destructor of arrays, never called by a kernel that creates none."""


def doubles(axes: int) -> NDArray[np.float64]:
    """Return an array of doubles in C order, an example of a kernel's argument."""
    return np.zeros((1,) * axes)


def integers(axes: int) -> NDArray[np.int64]:
    """Return an array of integers in C order, an example of a kernel's argument."""
    return np.zeros((1,) * axes, np.int64)


def complexes(axes: int) -> NDArray[np.complex128]:
    """Return an array of complex numbers in C order, an example of a kernel's argument."""
    return np.zeros((1,) * axes, np.complex128)


THREE = 0.0, 0.0, 0.0
"""Example of a number stored as three floats."""


def njit(
    *,
    cache: bool = False,
    subnormals: bool = True,
    examples: Sequence[Arguments] = (),
    **options: Any,
) -> Callable[[Callable[..., Any]], Any]:
    """Return a decorator like ``numba.njit(**options)`` that caches machine code if ``cache``.

    A kernel takes doubles, integers, arrays, tuples and None. It returns nothing, creates no arrays
    and raises nothing. Without ``subnormals`` it flushes them to 0 (`support.compiled.subnormals`).
    ``examples`` are tuples of arguments, one for each combination of types that runs use; the
    package ships LLVM text for these types.

    >>> @njit()
    ... def half(x):
    ...     return 0.5 * x
    >>> half(3.0)
    1.5
    """

    def compiled(function: Callable[..., Any]) -> Any:
        if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
            return function
        return Kernel(function, cache, subnormals, examples, options)

    return compiled


class Kernel:
    """Compiled function, callable from Python and from other kernels."""

    def __init__(
        self,
        function: Callable[..., Any],
        cached: bool,
        subnormals: bool,
        examples: Sequence[Arguments],
        options: dict[str, Any],
    ) -> None:
        if not (cached or subnormals):
            raise ValueError("cache must be True if subnormals is False, got False (set it)")
        if examples and not cached:
            raise ValueError("cache must be True if there are examples, got False (set it)")
        functools.update_wrapper(self, function)
        self.py_func, self.examples = function, examples
        self._cached, self._subnormals, self._options = cached, subnormals, OPTIONS | options
        self._entries: dict[tuple[Any, ...], tuple[Callable[..., int], Callable[..., bytes]]] = {}

    def __call__(self, *arguments: Any) -> Any:
        """Call the function, compiling it for new types of arguments."""
        if not self._cached:
            return self._by_numba(*arguments)
        kinds: list[Any] = []
        words: list[Any] = []
        _unpack(arguments, kinds, words)
        key = tuple(kinds)
        compiled = self._entries.get(key)
        if compiled is None:
            compiled = self._entries[key] = self._entry(key, words, arguments)
        entry, packed = compiled
        if entry(packed(*words)):
            raise RuntimeError(
                f"{self.py_func.__name__} must raise nothing, got an error (check before)"
            )
        return None

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        """Return the kernel, bound to an instance as functions are, for Python's inspection."""
        return self if instance is None else MethodType(self, instance)

    def _entry(
        self, kinds: tuple[Any, ...], words: list[Any], arguments: Arguments
    ) -> tuple[Callable[..., int], Callable[..., bytes]]:
        """Return machine code for these types of arguments, and the function that packs words."""
        from longwave.support.compiled.native_code import native_functions

        key = self._key(kinds)

        def text() -> str:
            from longwave.support.compiled.shipped_kernels import shipped_text

            return shipped_text(self.__module__, key) or self.text(arguments)

        [entry] = native_functions(self.__module__, key, text, {ENTRY: PROTOTYPE})
        letters = ("d" if isinstance(word, float) else "q" for word in words)
        return entry, struct.Struct("".join(letters)).pack

    def _key(self, kinds: tuple[Any, ...]) -> str:
        return f"{self.py_func.__qualname__}-{self.py_func.__code__.co_firstlineno} {kinds}"

    def key(self, arguments: Arguments) -> str:
        """Return the kernel's name within its module, with the types of the arguments."""
        kinds: list[Any] = []
        _unpack(arguments, kinds, [])
        return self._key(tuple(kinds))

    def text(self, arguments: Arguments) -> str:
        """Compile the kernel and its entry for these types of arguments to LLVM text."""
        from llvmlite import binding  # type: ignore[import-untyped]

        numba = _numba()
        types = tuple(numba.typeof(_plain(argument)) for argument in arguments)
        compile_complex_product()
        _, folded = self.dispatcher._compiler.fold_argument_types(types, {})
        self.dispatcher.compile(folded)
        compiled = self.dispatcher.overloads[folded]
        if compiled.signature.return_type != numba.types.none:
            raise TypeError(
                f"{self.py_func.__name__} must return nothing to be cached, got a function that "
                f"returns {compiled.signature.return_type} (leave out cache=True)"
            )
        text = NEVER_CALLED.sub(
            r"define internal \1 {\n  unreachable\n}", compiled.library.get_llvm_str()
        )
        module = binding.parse_assembly(text)
        entry = _entry_text(self.dispatcher.targetctx, compiled, self._subnormals)
        module.link_in(binding.parse_assembly(entry))
        return str(module)

    @cached_property
    def dispatcher(self) -> Any:
        """Numba's dispatcher, through which other kernels call the kernel."""
        return _numba().njit(**self._options, **NO_WRAPPERS)(self.py_func)

    @cached_property
    def _by_numba(self) -> Any:
        """Numba's dispatcher, through which Python calls the kernel."""
        return _numba().njit(**self._options)(self.py_func)


def _entry_text(context: Any, compiled: Any, subnormals: bool) -> str:
    """Return the LLVM text of a function that calls the kernel with the words at an address."""
    from llvmlite import ir
    from numba import types

    from longwave.support.compiled.subnormals import flushed_subnormals

    module, word = ir.Module(), ir.IntType(64)
    native = context.declare_function(module, compiled.fndesc)
    kind = ir.FunctionType(ir.IntType(32), [word.as_pointer()])
    entry = ir.Function(module, kind, name=ENTRY)
    builder = ir.IRBuilder(entry.append_basic_block())

    def loaded(begin: Any, index: int) -> Any:
        return builder.load(builder.gep(begin, [word(index)]))

    def scalars(kinds: Any) -> Iterator[Any]:
        for kind in kinds:
            yield from scalars(kind) if isinstance(kind, types.BaseTuple) else (kind,)

    words = []
    for index, kind in enumerate(scalars(compiled.fndesc.argtypes)):
        word_value = loaded(entry.args[0], index)
        if not isinstance(kind, types.Array):
            words.append(word_value)
            continue
        array = builder.inttoptr(word_value, word.as_pointer())
        tables = [builder.inttoptr(loaded(array, n), word.as_pointer()) for n in (SHAPE, STRIDES)]
        axes = [loaded(begin, n) for begin in tables for n in range(kind.ndim)]
        size = functools.reduce(builder.mul, axes[: kind.ndim], word(1))
        item = context.get_abi_sizeof(context.get_data_type(kind.dtype))
        words += [word(0), word(0), size, word(item), loaded(array, DATA), *axes]
    result, exception, *kinds = native.function_type.args
    values = [
        builder.inttoptr(value, kind)
        if isinstance(kind, ir.PointerType)
        else builder.bitcast(value, kind)
        for value, kind in zip(words, kinds, strict=True)
    ]
    space = builder.alloca(result.pointee), builder.alloca(exception.pointee)
    with nullcontext() if subnormals else flushed_subnormals(module, builder):
        status = builder.call(native, [*space, *values], attrs=("noinline",))
    builder.ret(status)
    return str(module)


def _unpack(values: Iterable[Any], kinds: list[Any], words: list[Any]) -> None:
    """Append the values' types to ``kinds``, and the words that represent them to ``words``."""
    for value in values:
        kind = type(value)
        if kind is np.ndarray:
            flags = value.flags.num
            flags &= OF_C if flags & C_ORDER else OF_OTHERS
            kinds += (value.dtype, value.ndim, flags)
            words.append(id(value))
        elif kind is float or (kind is int and -LARGEST <= value < LARGEST):
            kinds.append(kind)
            words.append(value)
        elif kind is tuple:
            kinds.append(len(value))
            _unpack(value, kinds, words)
        elif value is None:
            kinds.append(None)
            words.append(0)
        elif isinstance(value, np.float64 | np.integer):
            _unpack((value.item(),), kinds, words)
        else:
            raise TypeError(
                "arguments of a kernel must be doubles, integers of 64 bits, arrays, tuples or "
                f"None, got {value!r} (convert it)"
            )


def _plain(value: Any) -> Any:
    """Return a Python number for a NumPy number; other values unchanged."""
    if isinstance(value, tuple):
        return tuple(map(_plain, value))
    return value.item() if isinstance(value, np.generic) else value


class Intrinsic:
    """Lazy ``numba.extending.intrinsic`` of ``function``, registered when numba is imported."""

    def __init__(self, function: Callable[..., Any]) -> None:
        self.__wrapped__ = self._function = function

    @cached_property
    def kind(self) -> Any:
        """Numba's type of the intrinsic."""
        from numba.core.registry import cpu_target
        from numba.extending import intrinsic

        typing = cpu_target.typing_context
        registered = intrinsic(self._function)
        typing.refresh()
        return typing.resolve_value_type(registered)


@lru_cache(maxsize=1)
def _numba() -> Any:
    """Import numba and register kernels and intrinsics with it."""
    import numba
    from numba.core.typing.typeof import typeof_impl

    @typeof_impl.register(Kernel)
    def _kernel(kernel: Kernel, _: Any) -> Any:
        return numba.types.Dispatcher(kernel.dispatcher)

    @typeof_impl.register(Intrinsic)
    def _intrinsic(intrinsic: Intrinsic, _: Any) -> Any:
        return intrinsic.kind

    return numba


@lru_cache(maxsize=1)
def compile_complex_product() -> None:
    """Compile the product of complex numbers before any cached kernel.

    Numba compiles it once, with the flags of the kernel that first needs it. Whether its products
    and sums may be contracted, and so last digits, would depend on what a process compiled before.
    """
    from numba.core.registry import cpu_target

    cpu_target.target_context.cached_internal_func.clear()
    kind = _numba().complex128
    product = _numba().njit(error_model="numpy", **NO_WRAPPERS)(lambda a, b: a * b)
    product.compile((kind, kind))
