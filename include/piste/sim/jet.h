#pragma once
/// Truncated Taylor series: the value of a smooth function at one time together with its derivatives, exact to
/// rounding.
///
/// `c[n]` is the n-th derivative over n!. Sums, products and the functions below follow the recurrences of Taylor
/// arithmetic (Griewank and Walther, Evaluating Derivatives, table 13.2). Each call of `derivative()` loses one order:
/// the highest coefficient of its result is unknown and set to 0, so it must not be used.

#include <array>
#include <cmath>
#include <cstddef>

namespace piste {

/// A Taylor series.
struct Jet {
  static constexpr std::size_t kOrder = 6;
  std::array<double, kOrder + 1> c{};

  constexpr Jet() = default;
  constexpr Jet(double value) { c[0] = value; }  // NOLINT(google-explicit-constructor): a number is a constant function

  /// The variable itself, value + δ: its first derivative is 1.
  static constexpr Jet variable(double value) {
    Jet j(value);
    j.c[1] = 1;
    return j;
  }
  constexpr double value() const { return c[0]; }
  /// n-th derivative.
  constexpr double operator()(std::size_t n) const {
    double factorial = 1;
    for (std::size_t i = 2; i <= n; ++i) factorial *= static_cast<double>(i);
    return c[n] * factorial;
  }

  constexpr Jet& operator+=(const Jet& b) {
    for (std::size_t n = 0; n <= kOrder; ++n) c[n] += b.c[n];
    return *this;
  }
  constexpr Jet& operator-=(const Jet& b) {
    for (std::size_t n = 0; n <= kOrder; ++n) c[n] -= b.c[n];
    return *this;
  }
};

constexpr Jet operator+(Jet a, const Jet& b) { return a += b; }
constexpr Jet operator-(Jet a, const Jet& b) { return a -= b; }
constexpr Jet operator-(const Jet& a) { return Jet() -= a; }
constexpr Jet operator*(const Jet& a, const Jet& b) {
  Jet p;
  for (std::size_t n = 0; n <= Jet::kOrder; ++n) {
    for (std::size_t i = 0; i <= n; ++i) p.c[n] += a.c[i] * b.c[n - i];
  }
  return p;
}
/// @pre b.value() != 0
constexpr Jet operator/(const Jet& a, const Jet& b) {
  Jet q;
  for (std::size_t n = 0; n <= Jet::kOrder; ++n) {
    q.c[n] = a.c[n];
    for (std::size_t i = 0; i < n; ++i) q.c[n] -= q.c[i] * b.c[n - i];
    q.c[n] /= b.c[0];
  }
  return q;
}

constexpr Jet derivative(const Jet& a) {
  Jet d;
  for (std::size_t n = 0; n < Jet::kOrder; ++n) d.c[n] = static_cast<double>(n + 1) * a.c[n + 1];
  return d;
}
/// The antiderivative with the given value.
constexpr Jet antiderivative(const Jet& a, double value) {
  Jet s(value);
  for (std::size_t n = 0; n < Jet::kOrder; ++n) s.c[n + 1] = a.c[n] / static_cast<double>(n + 1);
  return s;
}

/// f(g(t)), where `f` is a series in g about g.value().
constexpr Jet compose(const Jet& f, const Jet& g) {
  Jet step = g;
  step.c[0] = 0;
  Jet sum(f.c[Jet::kOrder]);
  for (std::size_t n = Jet::kOrder; n-- > 0;) sum = sum * step + f.c[n];
  return sum;
}

/// @pre a.value() > 0
inline Jet sqrt(const Jet& a) {
  Jet r(std::sqrt(a.c[0]));
  for (std::size_t n = 1; n <= Jet::kOrder; ++n) {
    double sum = a.c[n];
    for (std::size_t i = 1; i < n; ++i) sum -= r.c[i] * r.c[n - i];
    r.c[n] = sum / (2 * r.c[0]);
  }
  return r;
}

/// Sine of an angle [rad].
inline Jet sin(const Jet& a) {
  Jet s(std::sin(a.c[0])), k(std::cos(a.c[0]));
  for (std::size_t n = 1; n <= Jet::kOrder; ++n) {
    for (std::size_t i = 1; i <= n; ++i) {
      const double da = static_cast<double>(i) * a.c[i] / static_cast<double>(n);
      s.c[n] += da * k.c[n - i];
      k.c[n] -= da * s.c[n - i];
    }
  }
  return s;
}
inline Jet cos(const Jet& a) { return sin(a + std::acos(0.0)); }

/// Angle of (x, y) in (−π, π]. @pre not both values are 0
inline Jet atan2(const Jet& y, const Jet& x) {
  const Jet rate = (x * derivative(y) - y * derivative(x)) / (x * x + y * y);
  return antiderivative(rate, std::atan2(y.value(), x.value()));
}
inline Jet atan(const Jet& a) { return atan2(a, 1); }

}  // namespace piste
