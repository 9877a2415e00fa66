// The lattices of problem.py with Boost odeint, as its users write them.
#include <algorithm>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>
typedef std::vector<double> state;
static inline double spring(double x, double k2, double k4) { return x * (k2 + k4 * x * x); }
struct fput_strain {
  mutable state f;
  void operator()(const state &y, state &g) const {
    const size_t n = y.size(); f.resize(n);
    for (size_t i = 0; i < n; ++i) f[i] = spring(y[i], 4.0, 1.0);
    g[0] = f[n-1] - 2*f[0] + f[1];
    for (size_t i = 1; i + 1 < n; ++i) g[i] = f[i-1] - 2*f[i] + f[i+1];
    g[n-1] = f[n-2] - 2*f[n-1] + f[0];
  }
};
struct next_nearest {
  mutable state f, h;
  void operator()(const state &y, state &g) const {
    const size_t n = y.size(); f.resize(n); h.resize(n);
    for (size_t i = 0; i < n; ++i) f[i] = spring(y[i], 4.0, 1.0);
    for (size_t i = 0; i + 1 < n; ++i) h[i] = spring(y[i] + y[i+1], 1.0, 0.5);
    h[n-1] = spring(y[n-1] + y[0], 1.0, 0.5);
    for (size_t i = 2; i + 1 < n; ++i)
      g[i] = f[i-1] - 2*f[i] + f[i+1] + h[i+1] - h[i] - h[i-1] + h[i-2];
    for (size_t i : {size_t(0), size_t(1), n - 1})
      g[i] = f[(i+n-1)%n] - 2*f[i] + f[(i+1)%n] + h[(i+1)%n] - h[i] - h[(i+n-1)%n] + h[(i+n-2)%n];
  }
};
struct dimer {
  mutable state near, far;
  void operator()(const state &q, state &g) const {
    const size_t n = q.size() / 2; near.resize(n); far.resize(n);
    const double *u = q.data(), *v = q.data() + n;
    for (size_t i = 0; i < n; ++i) near[i] = spring(v[i] - u[i], 4.0, 1.0);
    for (size_t i = 0; i + 1 < n; ++i) far[i] = spring(u[i+1] - v[i], 6.0, 0.5);
    far[n-1] = spring(u[0] - v[n-1], 6.0, 0.5);
    g[0] = near[0] - far[n-1];
    for (size_t i = 1; i < n; ++i) g[i] = near[i] - far[i-1];
    for (size_t i = 0; i < n; ++i) g[n+i] = 0.5 * (far[i] - near[i]);
  }
};
struct square {
  mutable state along, across;
  void operator()(const state &u, state &g) const {
    const size_t n = std::lround(std::sqrt(double(u.size()))); along.resize(n*n); across.resize(n*n);
    for (size_t i = 0; i < n; ++i) {
      const double *here = &u[i*n], *next = &u[(i + 1 < n ? i + 1 : 0) * n];
      for (size_t j = 0; j < n; ++j) along[i*n+j] = spring(next[j] - here[j], 4.0, 1.0);
      for (size_t j = 0; j + 1 < n; ++j) across[i*n+j] = spring(here[j+1] - here[j], 3.0, 0.5);
      across[i*n+n-1] = spring(here[0] - here[n-1], 3.0, 0.5);
    }
    for (size_t i = 0; i < n; ++i) {
      const double *here = &along[i*n], *last = &along[(i ? i - 1 : n - 1) * n], *side = &across[i*n];
      g[i*n] = here[0] - last[0] + side[0] - side[n-1];
      for (size_t j = 1; j < n; ++j) g[i*n+j] = here[j] - last[j] + side[j] - side[j-1];
    }
  }
};
struct toda {
  mutable state f;
  void operator()(const state &u, state &g) const {
    const size_t n = u.size(); f.resize(n);
    for (size_t i = 0; i + 1 < n; ++i) f[i] = std::exp(u[i+1] - u[i]);
    f[n-1] = std::exp(u[0] - u[n-1]);
    g[0] = f[0] - f[n-1];
    for (size_t i = 1; i < n; ++i) g[i] = f[i] - f[i-1];
  }
};
struct hertz {
  mutable state f;
  void operator()(const state &u, state &g) const {
    const size_t n = u.size(); f.resize(n + 1); f[0] = 0.0;
    for (size_t i = 0; i < n; ++i) {
      const double x = std::max(u[i] - (i + 1 < n ? u[i+1] : 0.0), 0.0);
      f[i+1] = x * std::sqrt(x);
    }
    for (size_t i = 0; i < n; ++i) g[i] = f[i] - f[i+1];
  }
};
struct driven {
  mutable state f;
  void operator()(const state &z, state &g, double t) const {
    const size_t n = z.size() / 2; f.resize(n + 1);
    const double *u = z.data(), *v = z.data() + n;
    f[0] = spring(u[0], 4.0, 1.0);
    for (size_t i = 1; i < n; ++i) f[i] = spring(u[i] - u[i-1], 4.0, 1.0);
    f[n] = spring(-u[n-1], 4.0, 1.0);
    for (size_t i = 0; i < n; ++i) g[i] = v[i];
    for (size_t i = 0; i < n; ++i) g[n+i] = f[i+1] - f[i] - 0.01 * v[i];
    g[n+n/2] += 0.3 * std::cos(0.9 * t);
  }
};
void march_driven(state &q, const state &p, double h, int steps) {
  const size_t n = q.size();
  boost::numeric::odeint::runge_kutta_fehlberg78<state> stepper;
  state z(q); z.insert(z.end(), p.begin(), p.end());
  for (int k = 0; k < steps; ++k) stepper.do_step(driven(), z, k * h, h);
  q.assign(z.begin(), z.begin() + n);
}
template <class force> void march(state &q, state &p, double h, int steps) {
  boost::numeric::odeint::symplectic_rkn_sb3a_mclachlan<state> stepper;
  force pull;
  auto pair = std::make_pair(boost::ref(q), boost::ref(p));
  for (int k = 0; k < steps; ++k) stepper.do_step(pull, pair, k * h, h);
}
int main(int argc, char **argv) {
  if (argc != 7) return 2;
  const std::string name = argv[1];
  const size_t n = atoi(argv[2]); const double h = atof(argv[3]); const int steps = atoi(argv[4]);
  state q(n), p(n);
  FILE *in = fopen(argv[5], "rb");
  if (fread(q.data(), 8, n, in) != n || fread(p.data(), 8, n, in) != n) return 1;
  fclose(in);
  std::clock_t begin = std::clock();
  if (name == "fput_strain") march<fput_strain>(q, p, h, steps);
  else if (name == "next_nearest") march<next_nearest>(q, p, h, steps);
  else if (name == "dimer") march<dimer>(q, p, h, steps);
  else if (name == "square") march<square>(q, p, h, steps);
  else if (name == "toda") march<toda>(q, p, h, steps);
  else if (name == "hertz") march<hertz>(q, p, h, steps);
  else if (name == "driven") march_driven(q, p, h, steps);
  else return 3;
  double seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
  FILE *out = fopen(argv[6], "wb"); fwrite(q.data(), 8, n, out); fclose(out);
  printf("%.9f\n", seconds);
}
