"""Numba's ``njit`` with a cache on disk that follows the sources, read without numba.

A kernel is compiled by numba when it is first called with arguments of some types. What is kept of
it (`support.compiled.kernel_folder` says where, `support.compiled.entry_point` what) is loaded by
the next process without numba, which takes half a second to import. Numba is asked for what has no
such entry point, for what its own runtime is needed for, and where anything is not as expected.
"""

from __future__ import annotations

import functools
import hashlib
import json
import os
import sys
import threading
from collections.abc import Callable
from functools import cached_property, lru_cache
from importlib import import_module
from pathlib import Path
from types import MethodType
from typing import Any

import numpy as np

from longwave.support.compiled import entry_point
from longwave.support.compiled.entry_point import Machine, Unsupported
from longwave.support.compiled.kernel_folder import cache_folder, read_whole, write_whole
from longwave.support.compiled.source_digest import source_digest

__all__ = ["Intrinsic", "Kernel", "njit"]

SUFFIX = ".kernel"
"""Of the files of compiled kernels."""

STRICT: dict[str, Any] = {"fastmath": False}
"""What a kernel does not say: an inner function that is silent takes it from the first kernel that
calls it, and the last digits of all others would depend on what a process compiled before."""


def njit(
    *, cache: bool = False, inner: bool = False, **options: Any
) -> Callable[[Callable[..., Any]], Any]:
    """``numba.njit(**options)``; with ``cache``, machine code is kept from one process to the next.

    An ``inner`` function is called from other compiled ones alone: without an entry for Python it
    compiles in half the time.

    >>> @njit(error_model="numpy")
    ... def half(x):
    ...     return 0.5 * x
    >>> half(3.0)
    1.5
    """

    def compiled(function: Callable[..., Any]) -> Any:
        if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
            return function
        return Kernel(function, cache, inner, options)

    return compiled


class Kernel:
    """A function to be compiled: for Python, and for the kernels that call it.

    ``found`` counts the signatures whose machine code was there already.
    """

    def __init__(
        self, function: Callable[..., Any], cache: bool, inner: bool, options: dict[str, Any]
    ) -> None:
        functools.update_wrapper(self, function)
        self.py_func = function
        self.found = 0
        self._kept, self._inner, self._options = cache, inner, STRICT | options
        self._entries: list[Callable[..., Any]] = []
        self._compiled: set[Any] = set()
        self._loaded = False
        self._lock = threading.Lock()

    def __call__(self, *arguments: Any) -> Any:
        """The function's value."""
        for entry in self._entries:
            value = entry(*arguments)
            if value is not NotImplemented:
                return value
        return self._other(arguments)

    def __get__(self, instance: object, owner: type | None = None) -> Any:
        """The kernel, bound to an instance as functions are: for Python's inspection it is one."""
        return self if instance is None else MethodType(self, instance)

    def _other(self, arguments: tuple[Any, ...]) -> Any:
        """The value for arguments of types that were not met before."""
        if self._inner:
            raise TypeError(
                f"{self.py_func.__name__} must be called from compiled code (it has no other entry)"
            )
        arguments = tuple(a.item() if isinstance(a, np.generic) else a for a in arguments)
        if self._kept and entry_point.fields_are_known():
            for prepare in (self._load, self._compile):
                with self._lock:
                    prepare(arguments)
                for entry in self._entries:
                    value = entry(*arguments)
                    if value is not NotImplemented:
                        return value
        return self._by_numba(*arguments)

    def _load(self, _: tuple[Any, ...]) -> None:
        """Load what is on disk, once."""
        if self._folder is None or self._loaded:
            return
        self._loaded = True
        for path in sorted(self._folder.glob(f"{self._stem}.*{SUFFIX}")):
            machine = _read(path)
            entry = None if machine is None else _loaded(machine)
            if entry is not None:
                self._entries.append(entry)
                self.found += 1

    def _compile(self, arguments: tuple[Any, ...]) -> None:
        """Compile for arguments of these types, and keep what comes of it."""
        numba = _numba()
        try:
            types = tuple(map(numba.typeof, arguments))
        except ValueError:  # numba says so when it is called
            return
        if types in self._compiled:
            return
        self._compiled.add(types)
        _compile_complex_product()
        dispatcher = self.dispatcher
        _, folded = dispatcher._compiler.fold_argument_types(types, {})
        dispatcher.compile(folded)
        known = f"{types} {entry_point.processor()}"
        key = hashlib.sha256(known.encode()).hexdigest()[:16]
        name = f"{self.__module__}.{self._stem}.{key}"
        nogil = self._options.get("nogil", False)
        try:
            compiled = dispatcher.overloads[folded]
            machine = entry_point.write(dispatcher.targetctx, compiled, name, nogil)
        except Unsupported:
            return
        entry = _loaded(machine)
        if entry is not None:
            self._entries.append(entry)
            if self._folder is not None:
                _write(machine, self._folder / f"{self._stem}.{key}{SUFFIX}")

    @cached_property
    def dispatcher(self) -> Any:
        """Numba's own object, as other kernels call it."""
        bare = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
        options = self._options | (bare if self._kept or self._inner else {})
        return _numba().njit(**options)(self.py_func)

    @cached_property
    def _by_numba(self) -> Any:
        """Numba's own object, as Python calls it."""
        return _numba().njit(**self._options)(self.py_func)

    @cached_property
    def _folder(self) -> Path | None:
        return cache_folder(self.__module__, source_digest(self.__module__))

    @property
    def _stem(self) -> str:
        return f"{self.py_func.__qualname__}-{self.py_func.__code__.co_firstlineno}"


class Intrinsic:
    """``numba.extending.intrinsic``, which numba is told of when it is there.

    ``function`` is as numba takes it: the signature and the code for arguments of some types.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self.__wrapped__ = self._function = function

    @cached_property
    def kind(self) -> Any:
        """Numba's type of it."""
        from numba.core.registry import cpu_target
        from numba.extending import intrinsic

        typing = cpu_target.typing_context
        made = intrinsic(self._function)
        typing.refresh()
        return typing.resolve_value_type(made)


@lru_cache(maxsize=1)
def _numba() -> Any:
    """Numba, which knows kernels and intrinsics then, and its runtime."""
    import numba
    from numba.core.registry import cpu_target
    from numba.core.runtime.nrt import rtsys
    from numba.core.typing.typeof import typeof_impl

    _load_arrays_without_blas()

    @typeof_impl.register(Kernel)
    def _kernel(kernel: Kernel, _: Any) -> Any:
        return numba.types.Dispatcher(kernel.dispatcher)

    @typeof_impl.register(Intrinsic)
    def _intrinsic(intrinsic: Intrinsic, _: Any) -> Any:
        return intrinsic.kind

    rtsys.initialize(cpu_target.target_context)
    return numba


@lru_cache(maxsize=1)
def _compile_complex_product() -> None:
    """Compile the product of complex numbers before any kernel that is kept.

    Numba compiles it once, with the flags of the kernel that needs it first: whether its products
    and sums may be contracted, and so last digits, would depend on what a process compiled before.
    """
    from numba.core.registry import cpu_target

    cpu_target.target_context.cached_internal_func.clear()
    kind = _numba().complex128
    bare = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True}
    product = _numba().njit(error_model="numpy", **bare)(lambda a, b: a * b)
    product.compile((kind, kind))


def _load_arrays_without_blas() -> None:
    """Spare the 0.2 s that numba takes to import SciPy's BLAS, which is there, before any kernel.

    What needs it (``np.dot`` in a kernel) imports it then.
    """
    from numba.np import linalg

    ensure = linalg.ensure_blas
    linalg.ensure_blas = lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = ensure


def _loaded(machine: Machine) -> Callable[..., Any] | None:
    """The entry point; None if numba's runtime lacks something that it needs, too."""
    entry = entry_point.load(machine) if sys.platform == "linux" else None
    if entry is None:
        _numba()
        entry = entry_point.load(machine)
    return entry


def _write(machine: Machine, path: Path) -> None:
    """Keep machine code: a line that says what it is, and the code."""
    head = {
        "processor": entry_point.processor(),
        "entry": machine.entry,
        "needed": machine.needed,
        "kernel": len(machine.kernel),
    }
    write_whole(path, json.dumps(head).encode() + b"\n" + machine.kernel + machine.caller)


def _read(path: Path) -> Machine | None:
    """What `_write` kept; None if it is damaged or for another processor."""
    data = read_whole(path)
    if data is None:
        return None
    line, _, code = data.partition(b"\n")
    head = json.loads(line)
    if head["processor"] != entry_point.processor():
        return None
    size = head["kernel"]
    return Machine(head["entry"], code[:size], code[size:], head["needed"])
