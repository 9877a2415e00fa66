"""Search for the generators and hints of the Jacobi functions in a proof."""

from __future__ import annotations

from collections.abc import Callable

import sympy as sp

from longwave.solutions import functions

from .arguments import Arguments
from .certificate_writer import ProofWriter

TRIPLE = (functions.jacobi_sn, functions.jacobi_cn, functions.jacobi_dn)


class EllipticSearch:
    """Generators and hints for Jacobi functions, from the integer combinations of their arguments.

    ``need`` registers the generators of any other formula, ``begin_forms`` the linear forms with a
    primitive.  ``moving``: derivatives are needed too; ``epsilon``: zeta is written in epsilon.
    """

    def __init__(
        self,
        writer: ProofWriter,
        arguments: Arguments,
        need: Callable[[sp.Expr], None],
        begin_forms: Callable[[sp.Basic], bool],
        *,
        moving: bool,
        epsilon: bool,
    ) -> None:
        self._writer, self._arguments = writer, arguments
        self._place, self._add = writer.table.place, writer.table.add
        self._need, self._begin_forms = need, begin_forms
        self._moving, self._epsilon = moving, epsilon

    def below_one(self, m: sp.Expr) -> None:
        """Record the factored 1 - m as the witness that shows its sign."""
        rest, other = self._complement(m), self._place(sp.factor(1 - m))
        if other != rest:
            self._writer.signs[rest] = other

    def _complement(self, m: sp.Expr) -> int:
        """Return the node of 1 - m as the checker writes it."""
        one, minus = (self._place(sp.Integer(n)) for n in (1, -1))
        return self._add("Add", one, self._add("Mul", minus, self._place(m)))

    def provide(self, node: sp.Expr) -> None:
        """Register the generators and hints that the image of a Jacobi function needs."""
        z, m = node.args
        self._need(z)
        self._need(m)
        self.below_one(m)
        if isinstance(node, functions.jacobi_theta):
            self._theta(z, m)
        elif isinstance(node, functions.jacobi_eta):
            self._root(self._place(m), "1/4", sp.sqrt(sp.sqrt(m)))
            for function in (functions.jacobi_sn, functions.jacobi_theta):
                self._need(function(z, m))
        elif isinstance(node, functions.jacobi_zeta) and self._epsilon:
            for part in (functions.jacobi_epsilon(z, m), sp.elliptic_e(m), sp.elliptic_k(m)):
                self._need(part)
        else:
            self._register_basis(z, m, node.func if node.func not in TRIPLE else None)

    def _root(self, base: int, exponent: str, root: sp.Expr) -> None:
        """Record that the power of the nodes ``base`` and ``exponent`` equals SymPy's ``root``."""
        self._need(root)
        self._writer.name(place=self._add("Pow", base, exponent), value=self._place(root))

    def _register_basis(self, z: sp.Expr, m: sp.Expr, second: type | None) -> None:
        """Register the Jacobi functions of the basis arguments of which ``z`` is a combination.

        ``second`` is epsilon or zeta, if that is needed too, else None."""
        variable, constant = self._arguments.parts(z)
        terms = []
        parts = (self._arguments.moving(m), variable), (self._arguments.fixed(m), constant)
        for combinations, part in parts:
            if part == 0:
                continue
            for u, n in zip(combinations.basis, combinations.coordinates(part), strict=True):
                if n:
                    side = -1 if u.could_extract_minus_sign() else 1
                    self._argument(side * u, m, second)
                    terms.append((str(side * n), self._place(side * u)))
        place = self._place(z)
        if terms != [("1", place)]:
            sine = self._add("jacobi_sn", place, self._place(m))
            self._writer.words(sine, terms)

    def _argument(self, u: sp.Expr, m: sp.Expr, second: type | None) -> None:
        self._need(u)
        place, parameter = self._place(u), self._place(m)
        if u == sp.elliptic_k(m):
            self._root(self._complement(m), "1/2", sp.sqrt(1 - m))
            if second is functions.jacobi_epsilon:
                self._need(sp.elliptic_e(m))
            return
        modulus = sp.sqrt(m)
        for function in sorted(TRIPLE, key=lambda f: -self._arguments.count[f, m]):
            own = self._add(function.__name__, place, parameter)
            scaled = modulus.is_Symbol and function is not functions.jacobi_dn
            self._writer.atom(own, self._place(modulus) if scaled else None)
        if second is not None:
            self._second(second, u, m)

    def _second(self, kind: type, u: sp.Expr, m: sp.Expr) -> None:
        """Register epsilon or zeta of a basis argument ``u``, and what its derivative needs."""
        if kind is functions.jacobi_zeta and self._moves(u):
            self._need(sp.elliptic_e(m))
            self._need(sp.elliptic_k(m))
        own = self._add(kind.__name__, self._place(u), self._place(m))
        if kind is functions.jacobi_epsilon:
            self._begin_forms(sp.Tuple(u, m))
        self._writer.atom(own)

    def _moves(self, node: sp.Expr) -> bool:
        return self._moving and self._arguments.dependence.depends(node)

    def _theta(self, z: sp.Expr, m: sp.Expr) -> None:
        """Register theta at two arguments; the product theorem gives it at ``z`` step by step."""
        variable, constant = self._arguments.parts(z)
        basis = self._arguments.moving(m).basis
        if -variable in basis:
            variable, constant = -variable, -constant
        if variable != 0 and variable not in basis:
            raise ValueError(f"theta of a multiple of another argument: theta({z})")
        step, times = self._arguments.steps(constant, m)
        if variable == 0 and times < 0:
            times = -times
        here = self._place(functions.jacobi_theta(variable, m))
        if self._moves(variable):
            self._need(functions.jacobi_zeta(variable, m))
        self._writer.atom(here)
        if times and variable != 0:
            self._quotient(variable, step, m, here)
        if times not in (0, 1) or (times and variable == 0):
            for z0 in (step, sp.S.Zero):
                self._writer.atom(self._place(functions.jacobi_theta(z0, m)))
        side = 1 if times > 0 else -1
        for j in range(2 if side > 0 else -1, times + side, side):
            self._next_theta(variable + (j - side) * step, side * step, z, m)
        if times and self._moves(variable):
            self._register_basis(z, m, functions.jacobi_zeta)

    def _next_theta(self, u: sp.Expr, step: sp.Expr, z: sp.Expr, m: sp.Expr) -> None:
        """Give the product theorem's hint for theta(u + step); ``z`` may be -(u + step)."""
        back, total = -step, sp.expand(u + step)
        for argument in (u, step, back):
            self._need(argument)
            self._register_basis(argument, m, None)
        for argument, plus, minus in ((total, u, back), (sp.expand(-total), back, u)):
            if argument == total or sp.expand(z) == argument:
                node = self._add("jacobi_theta", self._place(argument), self._place(m))
                self._writer.words(node, [("1", self._place(plus)), ("-1", self._place(minus))])

    def _quotient(self, u: sp.Expr, d: sp.Expr, m: sp.Expr, here: int) -> None:
        total = self._add("Add", self._place(u), self._place(d))
        next_theta = self._add("jacobi_theta", total, self._place(m))
        if next_theta in self._writer.registered:
            return
        for part in (u, d):
            self._need(part)
        if self._moves(u):
            for part in (u, d):
                self._register_basis(part, m, functions.jacobi_zeta)
            sine = self._add("jacobi_sn", total, self._place(m))
            self._writer.words(sine, [("1", self._place(u)), ("1", self._place(d))])
        self._writer.atom(next_theta, self._add("Pow", here, "-1"))
