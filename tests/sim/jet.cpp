#include "piste/sim/jet.h"

#include <gtest/gtest.h>

namespace piste {
namespace {

TEST(Jet, SineOfVariableHasTheKnownDerivatives) {
  const Jet s = sin(Jet::variable(0.4));
  EXPECT_NEAR(s(0), std::sin(0.4), 1e-15);
  EXPECT_NEAR(s(1), std::cos(0.4), 1e-15);
  EXPECT_NEAR(s(2), -std::sin(0.4), 1e-15);
  EXPECT_NEAR(s(5), std::cos(0.4), 1e-14);
}

TEST(Jet, QuotientUndoesProduct) {
  const Jet x = Jet::variable(0.7), a = sin(3 * x) + x * x, b = cos(x) + 2;
  const Jet q = a * b / b;
  for (std::size_t n = 0; n <= Jet::kOrder; ++n) EXPECT_NEAR(q.c[n], a.c[n], 1e-13);
}

TEST(Jet, RootSquaredIsTheArgument) {
  const Jet a = cos(2 * Jet::variable(0.3)) + 3, r = sqrt(a), square = r * r;
  for (std::size_t n = 0; n <= Jet::kOrder; ++n) EXPECT_NEAR(square.c[n], a.c[n], 1e-13);
}

TEST(Jet, AngleOfCosineAndSineIsTheAngle) {
  const Jet x = Jet::variable(2.5), angle = x * x / 3;
  const Jet back = atan2(sin(angle), cos(angle));
  for (std::size_t n = 0; n < Jet::kOrder; ++n) EXPECT_NEAR(back.c[n], angle.c[n], 1e-13);
}

TEST(Jet, CompositionIsTheChainRule) {
  const Jet t = Jet::variable(0.2), g = t * t + t;
  const Jet direct = sin(g), composed = compose(sin(Jet::variable(g.value())), g);
  for (std::size_t n = 0; n <= Jet::kOrder; ++n) EXPECT_NEAR(composed.c[n], direct.c[n], 1e-13);
}

}  // namespace
}  // namespace piste
