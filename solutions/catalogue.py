"""Catalogue of closed forms. To add one, add a file in ``forms`` and a line here."""

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from typing import TYPE_CHECKING, overload

if TYPE_CHECKING:
    from longwave.solutions.record import ClosedForm

_MODULES: Mapping[str, str] = {
    name: module
    for module, names in (
        ("rational", "rational_1 rational_2 rational_3"),
        ("breather_sn", "breather_sn"),
        ("soliton_dn", "soliton_dn"),
        ("rogue_cn", "rogue_cn"),
        ("bare_waves", "wave_sn wave_cn wave_dn"),
        ("solitons", "soliton_sech kink"),
        ("arctangents", "breather double_pole two_soliton"),
        ("solitons", "soliton_background kink_antikink"),
        ("kdv_waves", "kdv_soliton kdv_two_soliton kdv_cnoidal"),
        ("gardner_waves", "gardner_soliton gardner_negative_soliton gardner_table_soliton"),
        ("gardner_waves", "gardner_kink kawahara_soliton modified_kawahara_soliton"),
        ("burgers_waves", "kdv_burgers_shock mkdv_burgers_shock"),
        ("kp_waves", "kp_line_soliton kp_lump"),
        ("nls_waves", "nls_plane nls_bright nls_dark nls_dn nls_cn"),
        ("nls_breathers", "nls_peregrine nls_rogue_2 nls_akhmediev nls_kuznetsov_ma"),
    )
    for name in names.split()
}
"""Name of each form, which is also the name of the function that builds it -> its module."""

_EQUATIONS: Mapping[str, str] = {
    "kdv_burgers": "KdV-Burgers",
    "mkdv_burgers": "mKdV-Burgers",
    "kdv": "KdV",
    "gardner": "Gardner",
    "kawahara": "Kawahara",
    "modified": "modified Kawahara",
    "kp": "KP",
    "nls": "NLS",
}
"""Prefix of a form's name -> its equation in `derive.normal_form.NORMAL_EQUATIONS`, longer
prefixes first; all other forms solve mKdV."""

LARGEST_ORDER = 12
"""Highest order of a rational solution that can be requested by name."""

_RATIONAL = re.compile(r"rational_([1-9]\d?)")
_SHIFT = re.compile(r"tau_([1-9]\d?)")


@dataclass(frozen=True, repr=False)
class Catalogue(Sequence["ClosedForm"]):
    """Sequence of closed forms by name; each form is built on first access.

    >>> len(CATALOGUE), CATALOGUE.names[0], CATALOGUE[15].title
    (38, 'rational_1', 'kink and antikink')
    """

    names: tuple[str, ...]

    @property
    def modules(self) -> tuple[str, ...]:
        """Modules that build the forms, sorted."""
        return tuple(sorted({self.module(name) for name in self.names}))

    @overload
    def __getitem__(self, index: int) -> "ClosedForm": ...
    @overload
    def __getitem__(self, index: str) -> "ClosedForm": ...
    @overload
    def __getitem__(self, index: slice) -> "Sequence[ClosedForm]": ...
    def __getitem__(self, index: int | str | slice) -> "ClosedForm | Sequence[ClosedForm]":
        if isinstance(index, str):
            return closed_form(index)
        if isinstance(index, slice):
            return tuple(_build_form(name) for name in self.names[index])
        return _build_form(self.names[index])

    def __len__(self) -> int:
        return len(self.names)

    def __reduce__(self) -> str | tuple[type, tuple[tuple[str, ...]]]:
        return "CATALOGUE" if self is CATALOGUE else (Catalogue, (self.names,))

    def __repr__(self) -> str:
        counts = Counter(map(self.equation, self.names))
        summary = ", ".join(f"{count} of {equation}" for equation, count in counts.items())
        return f"<Catalogue of {len(self)} closed forms: {summary}>"

    def of(self, equation: str) -> "Catalogue":
        """Return the forms of one equation, by its name in `derive.normal_form.NORMAL_EQUATIONS`.

        >>> CATALOGUE.of("KP").names
        ('kp_line_soliton', 'kp_lump')
        """
        return Catalogue(tuple(n for n in self.names if self.equation(n) == equation))

    @staticmethod
    def module(name: str) -> str:
        """Return the full name of the module that builds the form called ``name``."""
        return f"longwave.solutions.forms.{_MODULES[name]}"

    @staticmethod
    def equation(name: str) -> str:
        """Return the name of the equation that the form called ``name`` solves."""
        equations = (_EQUATIONS[prefix] for prefix in _EQUATIONS if name.startswith(f"{prefix}_"))
        return next(equations, "mKdV")


CATALOGUE = Catalogue(tuple(_MODULES))


@cache
def _build_form(name: str) -> "ClosedForm":
    module = Catalogue.module(name)
    form: ClosedForm = getattr(import_module(module), name)()
    object.__setattr__(form, "module", module)
    return form.with_pickle_call(closed_form, name)


def closed_form(name: str, parameters: Iterable[str] = ()) -> "ClosedForm":
    """Return the closed form called ``name``. Raises ValueError, listing the names, if unknown.

    ``rational_<j>`` exists for every order j up to ``LARGEST_ORDER``; its free shifts are the names
    tau_5, tau_7, ... in ``parameters``. Other names in ``parameters`` are ignored.

    >>> closed_form("kink").title
    'kink'
    >>> [parameter.name for parameter in closed_form("rational_4", ["tau_5"]).parameters]
    ['tau_5']
    """
    match = _RATIONAL.fullmatch(name) if isinstance(name, str) else None
    shifts = [int(shift[1]) for text in parameters if (shift := _SHIFT.fullmatch(text))]
    is_printed = isinstance(name, str) and name in _MODULES
    if match and int(match[1]) <= LARGEST_ORDER and (shifts or not is_printed):
        from longwave.solutions.forms.rational import rational

        return rational(int(match[1]), shifts)
    if is_printed:
        return _build_form(name)
    from longwave.support.known_names import one_of
    from longwave.support.user_files import shown

    raise ValueError(
        f"name must be a closed form of the catalogue, got {shown(name)} "
        f"({one_of(name, CATALOGUE.names)}; rational_<j> for j up to {LARGEST_ORDER})"
    )
