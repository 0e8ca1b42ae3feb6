#include "condition/spline.h"

#include <gtest/gtest.h>

#include <cmath>

namespace piste {
namespace {

// Samples of a cubic and of a sine at unequal steps.
struct Samples {
  std::vector<double> time;
  std::vector<Vector3d> value;
};

Vector3d truth(double t) { return {std::sin(2 * t), 1 + t - 0.5 * t * t * t, std::cos(t)}; }
Vector3d truth_integral(double t) { return {-std::cos(2 * t) / 2, t + t * t / 2 - t * t * t * t / 8, std::sin(t)}; }

Samples sample(int count, double jitter) {
  Samples s;
  for (int i = 0; i <= count; ++i) {
    s.time.push_back(4.0 * (i + (i % 2 == 0 ? 0 : jitter)) / count);
    s.value.push_back(truth(s.time.back()));
  }
  return s;
}

double worst(int count, bool trapezoid = false) {
  const Samples s = sample(count, 0.2);
  const Spline spline(s.time, s.value);
  double largest = 0;
  for (std::size_t i = 0; i + 1 < s.time.size(); ++i) {
    const Vector3d exact = truth_integral(s.time[i + 1]) - truth_integral(s.time[i]);
    const Vector3d rule = (s.time[i + 1] - s.time[i]) / 2 * (s.value[i] + s.value[i + 1]);
    largest = std::max(largest, ((trapezoid ? rule : spline.integral(i)) - exact).norm());
  }
  return largest;
}

TEST(Spline, IsExactForACubic) {
  const Samples s = sample(7, 0.3);
  const Spline spline(s.time, s.value);
  for (std::size_t i = 0; i + 1 < s.time.size(); ++i) {
    const double exact = truth_integral(s.time[i + 1]).y() - truth_integral(s.time[i]).y();
    EXPECT_NEAR(spline.integral(i).y(), exact, 1e-13);
    const double middle = (s.time[i] + s.time[i + 1]) / 2;
    EXPECT_NEAR(spline.value(i, middle).y(), truth(middle).y(), 1e-13);
    EXPECT_NEAR(spline.value(i, s.time[i]).x(), s.value[i].x(), 1e-15);
  }
}

TEST(Spline, IntegralOfAStepHasFifthOrder) {
  EXPECT_NEAR(std::log2(worst(40) / worst(80)), 5, 0.3);
  EXPECT_NEAR(std::log2(worst(80) / worst(160)), 5, 0.3);
  EXPECT_NEAR(std::log2(worst(80, true) / worst(160, true)), 3, 0.3);
  EXPECT_LT(worst(80), 0.02 * worst(80, true));
}

TEST(Spline, FewSamples) {
  for (const int count : {1, 2, 3}) {
    const Samples s = sample(count, 0);
    const Spline spline(s.time, s.value);
    EXPECT_TRUE(spline.integral(0).allFinite());
    EXPECT_LT((spline.value(0, s.time[1]) - s.value[1]).norm(), 1e-14);
  }
}

TEST(Spline, DerivativeIsThatOfItsValue) {
  const Samples s = sample(12, 0.3);
  const Spline spline(s.time, s.value);
  constexpr double kStep = 1e-6;
  for (std::size_t i = 0; i + 1 < s.time.size(); ++i) {
    for (const double part : {0.1, 0.5, 0.9}) {
      const double t = s.time[i] + part * (s.time[i + 1] - s.time[i]);
      const Vector3d difference = (spline.value(i, t + kStep) - spline.value(i, t - kStep)) / (2 * kStep);
      EXPECT_LT((spline.derivative(i, t) - difference).norm(), 1e-8) << i;
    }
  }
}

}  // namespace
}  // namespace piste
