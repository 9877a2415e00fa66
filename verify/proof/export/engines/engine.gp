\\ A value [N, e] is the polynomial N over F[1]^e[1] * F[2]^e[2] * ...; F are denominators.
\\ A rule [g, p, n, v] says that p = g^n - v is 0; S are slopes, W logarithmic slopes of F,
\\ V values of names, N slopes of names.
lowered(p, k) = p = simplify(p); if(k > #R || type(p) != "t_POL", return(p)); if(variable(p) == R[k][1], p = simplify(p % R[k][2])); if(type(p) != "t_POL" || variable(p) != R[k][1], return(lowered(p, k + 1))); my(c = Vec(p)); simplify(sum(i = 1, #c, lowered(c[i], k + 1)*R[k][1]^(#c - i)));
nf(p) = lowered(p, 1);
below(e) = prod(i = 1, #F, F[i]^e[i]);
num(q) = [q, vector(#F)];
gen(i) = num(G[i + 1]);
put(k, a) = mapput(V, k, a);
get(k) = mapget(V, k);
neg(a) = [-a[1], a[2]];
total(v) = my(e = vector(#F, i, vecmax(apply(a -> a[2][i], v)))); [nf(sum(i = 1, #v, v[i][1]*below(e - v[i][2]))), e];
add(v[..]) = total(v);
times(a, b) = [nf(a[1]*b[1]), a[2] + b[2]];
mul(v[..]) = my(s = v[1]); for(i = 2, #v, s = times(s, v[i])); s;
pow(a, n) = my(s = a); for(i = 2, n, s = times(s, a)); s;
ispolynomial(p) = my(t = type(p)); if(t == "t_INT" || t == "t_FRAC", return(1)); if(t != "t_POL", return(0)); my(c = Vec(p)); for(i = 1, #c, if(!ispolynomial(c[i]), return(0))); 1;
mayDivide(p, f) = my(v = variable(f)); for(i = 1, #G, if(G[i] != v, p = subst(p, G[i], i + 1); f = subst(f, G[i], i + 1))); f == 0 || p % f == 0;
quotient(p, f) = my(q); if(!mayDivide(p, f), return([])); q = simplify(p/f); if(ispolynomial(q), q, []);
cut(a, e) = my(q); for(i = 1, #F, while(a[2][i] > if(i > #e, 0, e[i]), q = quotient(a[1], F[i]); if(q == [], break); a[1] = q; a[2][i]--)); a;
factored(p) = my(k = vector(#F), q); p = simplify(p); for(i = 1, #F, while(type(p) == "t_POL" && (q = quotient(p, F[i])) != [], p = simplify(q); k[i]++)); if(type(p) == "t_POL" || p == 0, error("a denominator that is not stated")); [p, k];
ruleOf(i) = for(k = 1, #R, if(F[i] == R[k][1], return(k))); 0;
inv(a) = my(s = factored(a[1]), k = s[2], r); s = [nf(below(a[2]))/s[1], k]; for(i = 1, #F, if(k[i] && r = ruleOf(i), s[2][i] = 0; s = times(s, pow(times(num(F[i]^(R[r][3] - 1)), inv(num(R[r][4]))), k[i])))); s;
slopeOf(v, i) = if(type(S[v, i]) == "t_INT", error("a slope that is not stated"), S[v, i]);
logSlope(v, i) = if(type(W[v, i]) == "t_INT", my(u = vector(#F)); u[i] = 1; W[v, i] = cut(times(der(v, num(F[i])), [1, u]), [])); W[v, i];
der(v, a) = my(s = [num(0)], p); for(i = 1, #G, p = deriv(a[1], G[i]); if(p != 0, s = concat(s, [times([p, a[2]], slopeOf(v, i))]))); for(i = 1, #F, if(a[2][i], s = concat(s, [times([-a[2][i]*a[1], a[2]], logSlope(v, i))]))); total(s);
derOf(v, k) = if(mapisdefined(N, [v, k]), mapget(N, [v, k]), der(v, get(k)));
vanish(a) = if(a[1] != 0, error("a term that is not 0"));
rule(i, n, a) = my(g = G[i + 1]); if(a[2] != 0, error("a rule with a denominator")); R = concat([[g, g^n - a[1], n, a[1]]], R);
slope(v, i, a) = S[v, i + 1] = a;
rate(v, k, a) = vanish(total([der(v, get(k)), neg(a)])); mapput(N, [v, k], a);
