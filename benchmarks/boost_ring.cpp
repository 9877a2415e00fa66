#include <boost/numeric/odeint.hpp>
#include <vector>
#include <cstdio>
#include <cstdlib>
#include <ctime>
typedef std::vector<double> state;
static const double K2 = 4.0, K4 = 1.0;
struct system_force {
  mutable state f;
  void operator()(const state &y, state &g) const {
    const size_t n = y.size(); f.resize(n);
    for (size_t i = 0; i < n; ++i) f[i] = y[i] * (K2 + K4 * y[i] * y[i]);
    g[0] = f[n-1] - 2*f[0] + f[1];
    for (size_t i = 1; i + 1 < n; ++i) g[i] = f[i-1] - 2*f[i] + f[i+1];
    g[n-1] = f[n-2] - 2*f[n-1] + f[0];
  }
};
int main(int argc, char **argv) {
  const size_t n = atoi(argv[1]); const double h = atof(argv[2]); const int steps = atoi(argv[3]);
  state y(n), s(n);
  FILE *in = fopen(argv[4], "rb");
  if (fread(y.data(), 8, n, in) != n || fread(s.data(), 8, n, in) != n) return 1;
  fclose(in);
  boost::numeric::odeint::symplectic_rkn_sb3a_mclachlan<state> stepper;
  system_force force;
  auto pair = std::make_pair(boost::ref(y), boost::ref(s));
  std::clock_t begin = std::clock();
  for (int k = 0; k < steps; ++k) stepper.do_step(force, pair, k * h, h);
  double seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
  FILE *out = fopen(argv[5], "wb"); fwrite(y.data(), 8, n, out); fclose(out);
  printf("%.9f\n", seconds);
}
