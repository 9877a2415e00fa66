"""Right and wrong values of special functions and of conjugates of complex parameters."""

import pytest
from flint import acb

from longwave.verify.proof.statement_text import read_statement
from longwave.verify.proof.statement_verdict import StatementVerdict, decide_statement
from longwave.verify.proof.taylor import Elliptic
from longwave.verify.verdict import Outcome

SN = "u_xx + (1+m)*u - 2*m*u**3"

STEWARTSON = (
    "I*u_t + u_xx - u_yy + abs(u)**2*u + u*v ;; v_xx + v_yy - diff(abs(u)**2, x, x)",
    "u = A*sech(k*x+l*y-2*(k*p-l*q)*t)*exp(I*(p*x+q*y+w*t)) ;;"
    " v = A**2*k**2/(k**2+l**2)*sech(k*x+l*y-2*(k*p-l*q)*t)**2",
)
PARAMETERS = (
    "k: k>l; l: l>0; p: real; q: real; "
    "A = sqrt(2*(k**2-l**2)/(1+k**2/(k**2+l**2))); w = k**2-l**2-p**2+q**2"
)
WAVE = "u = sqrt(k**2-l**2)*sech(k*x+l*y)*exp(I*(k**2-l**2)*t)"
NLS = "I*u_t + u_xx - u_yy + 2*abs(u)**2*u"

TRUE = [
    (NLS, WAVE, "l: l>0; k: k>l", ""),
    (NLS, WAVE, "k: k>l; l: l>0", ""),
    (NLS, WAVE, "l: l>0; k: k<-l", ""),
    (NLS, WAVE, "l: l<0; k: k>-l", ""),
    ("u - sqrt(1-x**2)", "u = sqrt(1+x)*sqrt(1-x)", "", ""),
    ("u - sqrt(1+x)*sqrt(1-x)", "u = sqrt(1-x**2)", "", ""),
    ("u_x + x/sqrt(1-x**2)", "u = sqrt(1+x)*sqrt(1-x)", "", ""),
    ("u - sqrt(a+x)*sqrt(a-x)", "u = sqrt(a**2-x**2)", "a: a>0", ""),
    ("u_t - diff(u**3,x,x)", "u = t**(-1/4)*sqrt(C - x**2/(12*sqrt(t)))", "C: C>0", "t>0"),
    ("u_t - diff(u**4,x,x)", "u = t**(-1/5)*(C - 3*x**2/(40*t**(2/5)))**(1/3)", "C: C>0", "t>0"),
    ("u - tanh(x)", "u = jacobi_sn(x,1)", "", ""),
    ("u_xx + 2*u*(1-u**2)", "u = jacobi_sn(x,1)", "", ""),
    ("u - sech(x)", "u = jacobi_dn(x,1)", "", ""),
    ("u - cos(x)", "u = jacobi_cn(x,0)", "", ""),
    ("u - x", "u = jacobi_epsilon(x,0)", "", ""),
    ("u - tanh(x)", "u = jacobi_epsilon(x,1)", "", ""),
    ("u - sin(2*x+t)", "u = jacobi_sn(2*x+t,m)", "m = 0", ""),
    ("u_xx + (1+k**2)*u-2*k**2*u**3", "u = jacobi_sn(x,k**2)", "k = 1", ""),
    ("u - pi/2", "u = elliptic_k(0) + 0*x", "", ""),
    ("u - pi/2", "u = elliptic_e(0) + 0*x", "", ""),
    ("u - 1", "u = elliptic_e(1) + 0*x", "", ""),
    (SN, "u = jacobi_sn(x,m)", "m: m>1", ""),
    (SN, "u = jacobi_sn(x,m)", "m = 2", ""),
    ("u_x - jacobi_dn(x,m)**2", "u = jacobi_epsilon(x,m)", "m: m>1", ""),
    ("u - bessel_k(v,x)", "u = bessel_k(-v,x)", "v: v>0", "x>0"),
    ("u_x + v/x*u + bessel_k(v-1,x)", "u = bessel_k(-v,x)", "", "x>0"),
    ("u - sqrt(2/(pi*x))*sin(x)", "u = bessel_j(1/2,x)", "", "x>0"),
    ("u - sqrt(2/pi)*sin(x)/sqrt(x)", "u = bessel_j(1/2,x)", "", ""),
    ("u - sqrt(1/(pi*x))*sin(2*x)", "u = bessel_j(1/2,2*x)", "", "x>0"),
    ("u - sqrt(2/(pi*x))*(sin(x)/x-cos(x))", "u = bessel_j(3/2,x)", "", "x>0"),
    ("u + sqrt(2/(pi*x))*cos(x)", "u = bessel_y(1/2,x)", "", "x>0"),
    ("u - sqrt(2/(pi*x))*sin(x)", "u = bessel_y(-1/2,x)", "", "x>0"),
    ("u - sqrt(2/(pi*x))*cosh(x)", "u = bessel_i(-1/2,x)", "", "x>0"),
    ("u - sqrt(pi/(2*x))*exp(-x)*(1+1/x)", "u = bessel_k(3/2,x)", "", "x>0"),
    ("u - sqrt(pi/(2*x))*exp(-x)*(1+1/x)", "u = bessel_k(-3/2,x)", "", "x>0"),
    ("x**2*u_xx+x*u_x+(x**2-9/4)*u", "u = bessel_y(-3/2,x)", "", "x>0"),
    ("u - x", "u = lambert_w(x*exp(x))", "", "x>=-1"),
    ("u_x - 2*x", "u = lambert_w(x**2*exp(x**2))", "", ""),
    ("u - 1", "u = lambert_w(exp(1)) + 0*x", "", ""),
    ("u + log(2)", "u = lambert_w(-log(2)/2) + 0*x", "", ""),
    ("u - a*conjugate(a)", "u = abs(a)**2 + 0*x", "a: complex", ""),
    ("u - x/a", "u = x*conjugate(a)/abs(a)**2", "a: complex", ""),
    ("u - abs(a)**4", "u = (re(a)**2+im(a)**2)**2 + 0*x", "a: complex", ""),
    ("u - x*(a-b)*conjugate(a-b)", "u = abs(a-b)**2*x", "a: complex; b: complex", ""),
    ("I*u_t + u_xx + 2*abs(u)**2*u", "u = a*exp(I*2*abs(a)**2*t)", "a: complex", ""),
    ("I*u_t + u_xx + 2*abs(u)**2*u", "u = a*exp(I*2*a*conjugate(a)*t)", "a: complex", ""),
]

FALSE = [
    (NLS.replace("+ 2", "- 2"), WAVE, "l: l>0; k: k>l", ""),
    (*STEWARTSON, PARAMETERS.replace("w = k", "w = 1+k"), ""),
    ("u - sqrt(x**2-1)", "u = sqrt(x+1)*sqrt(x-1)", "", ""),
    ("u - sqrt(1+x)*sqrt(1-x)", "u = -sqrt(1-x**2)", "", ""),
    ("u_x - x/sqrt(1-x**2)", "u = sqrt(1+x)*sqrt(1-x)", "", ""),
    ("u_t + diff(u**3,x,x)", "u = t**(-1/4)*sqrt(C - x**2/(12*sqrt(t)))", "C: C>0", "t>0"),
    ("u + tanh(x)", "u = jacobi_sn(x,1)", "", ""),
    ("u_xx - 2*u*(1-u**2)", "u = jacobi_sn(x,1)", "", ""),
    ("u - cos(x)", "u = jacobi_cn(x,1)", "", ""),
    ("u + cos(x)", "u = jacobi_cn(x,0)", "", ""),
    ("u - sech(x)", "u = jacobi_epsilon(x,1)", "", ""),
    ("u + pi/2", "u = elliptic_k(0) + 0*x", "", ""),
    ("u + 1", "u = elliptic_e(1) + 0*x", "", ""),
    ("u_xx + (1-m)*u - 2*m*u**3", "u = jacobi_sn(x,m)", "m: m>1", ""),
    ("u - jacobi_cn(sqrt(m)*x,1/m)", "u = jacobi_cn(x,m)", "m: m>1", ""),
    ("u + bessel_k(v,x)", "u = bessel_k(-v,x)", "v: v>0", "x>0"),
    ("u - bessel_i(v,x)", "u = bessel_i(-v,x)", "v: v>0", "x>0"),
    ("u + sqrt(2/(pi*x))*sin(x)", "u = bessel_j(1/2,x)", "", "x>0"),
    ("u - sqrt(2/(pi*x))*cos(x)", "u = bessel_y(1/2,x)", "", "x>0"),
    ("u - sqrt(pi/(2*x))*exp(-x)*(1-1/x)", "u = bessel_k(3/2,x)", "", "x>0"),
    ("u - x", "u = lambert_w(x*exp(x))", "", "x<-1"),
    ("u - x", "u = lambert_w(x*exp(x))", "", ""),
    ("u + x", "u = lambert_w(x*exp(x))", "", "x>0"),
    ("u + a*conjugate(a)", "u = abs(a)**2 + 0*x", "a: complex", ""),
    ("u - a**2", "u = abs(a)**2 + 0*x", "a: complex", ""),
    ("u - conjugate(a)", "u = a + 0*x", "a: complex", ""),
    ("I*u_t + u_xx - 2*abs(u)**2*u", "u = a*exp(I*2*a*conjugate(a)*t)", "a: complex", ""),
    ("I*u_t + u_xx + 2*abs(u)**2*u", "u = a*exp(I*2*a**2*t)", "a: complex", ""),
]


def decided(equation: str, solution: str, parameters: str, domain: str) -> StatementVerdict:
    return decide_statement(read_statement(equation, solution, parameters, domain))


@pytest.mark.parametrize(("equation", "solution", "parameters", "domain"), TRUE)
def test_a_value_is_proved(equation: str, solution: str, parameters: str, domain: str) -> None:
    found = decided(equation, solution, parameters, domain)
    assert found.outcome is Outcome.PROVED, found.detail


@pytest.mark.parametrize(("equation", "solution", "parameters", "domain"), FALSE)
def test_a_wrong_value_is_refuted(
    equation: str, solution: str, parameters: str, domain: str
) -> None:
    found = decided(equation, solution, parameters, domain)
    assert found.outcome is Outcome.REFUTED, found.detail


@pytest.mark.slow
def test_the_soliton_of_davey_and_stewartson_is_proved() -> None:
    """Catches: the sign of k not derived from k > l and l > 0."""
    assert decided(*STEWARTSON, PARAMETERS, "").outcome is Outcome.PROVED


def test_a_reason_is_not_that_another_way_was_taken() -> None:
    """Catches: the reason "multiply it out" for an equation that was taken as typed."""
    found = decided(NLS, WAVE, "l: l>0; k: k>0", "")
    assert found.outcome is not Outcome.PROVED
    found = decided("I*u_t + u_xx + 2*abs(u)**2*u", "u = abs(x*a)*exp(I*t)*0", "a: complex", "")
    assert "multiply it out" not in found.detail
    found = decided("sqrt(u_x**2) - u_x", "u = x**3 + x*sin(abs(sin(x)))/10", "", "")
    assert found.outcome is not Outcome.PROVED
    assert "multiply it out" not in found.detail


def test_a_value_on_another_branch_is_not_proved() -> None:
    """Catches: a root of 2/(pi z) taken for sqrt(2/pi)/sqrt(z), which differs for z < 0."""
    found = decided("u - sqrt(2/(pi*x))*sin(x)", "u = bessel_j(1/2,x)", "", "x<0")
    assert found.outcome is not Outcome.PROVED


def test_a_function_that_needs_m_below_one_says_so() -> None:
    """Catches: a reason in k, which the statement does not contain, or that calls m > 1 wrong."""
    found = decided("u_x + u**2", "u = jacobi_zeta(x,m)", "m: m>1", "")
    assert found.outcome is Outcome.UNDECIDED
    assert "need m < 1, got m = " in found.detail


def test_series_at_the_ends_of_the_parameter() -> None:
    for m in (0, 1):
        with pytest.raises(ValueError, match="needs 0 < m < 1"):
            Elliptic(acb(m)).theta(acb(1), 2)
    assert Elliptic(acb(0)).zeta(acb(1), 1) == [0, 0]
    (start, slope) = Elliptic(acb(1)).epsilon(acb(0), 1)
    assert (start, slope) == (0, 1)
