// What a fit found in a run without noise, taken out of the samples, leaves what the reference said.

#include "piste/fit/known_errors_of.h"

#include <gtest/gtest.h>

#include "support/aligned_run.h"

namespace piste {
namespace {

/// Largest difference of the corrected signals from the reference's, over all axes.
double left(const AlignedImus& imus, const KnownErrors& errors) {
  double worst = 0;
  const double dt = imus.interval;
  for (std::size_t i = 0; i < imus.time.size(); ++i) {
    const ImuSample s = corrected({.interval = dt, .dtheta = dt * imus.gyro[i], .dvel = dt * imus.accel[i]}, errors);
    worst = std::max(
        {worst, (s.dtheta / dt - imus.reference_gyro[i]).norm(), (s.dvel / dt - imus.reference_accel[i]).norm()});
  }
  return worst;
}

Findings found_in(const test::AlignedRun& run, const AlignedImus& imus) {
  return findings(imus, {run.before(), run.moving(), run.after()}, {});
}

TEST(KnownErrorsOf, EachFitTakesOutWhatItFound) {
  const test::AlignedRun run{.gyro_noise = 0, .accel_noise = 0};
  AlignedImus imus = run.simulate(1);
  Findings found = found_in(run, imus);
  std::array<std::optional<BiasScale>, 6> lines;
  std::array<std::optional<PolynomialFit>, 6> polynomials;
  for (std::size_t a = 0; a < 6; ++a) lines[a] = found.axes[a].run->joint.reverse;
  EXPECT_GT(left(imus, {}), 0.1);
  EXPECT_LT(left(imus, errors_of_lines(lines)), 1e-9);
  lines[4].reset();
  EXPECT_NEAR(left(imus, errors_of_lines(lines)), 0.01, 0.005) << "an axis that nothing is known of";

  for (std::size_t i = 0; i < imus.time.size(); ++i) {
    const auto w = imus.reference_gyro[i].array(), f = imus.reference_accel[i].array();
    imus.gyro[i].array() += w * w * (0.02 + 0.03 * w);
    imus.accel[i].array() += f * f * (1e-3 + 2e-4 * f);
  }
  found = found_in(run, imus);
  for (std::size_t a = 0; a < 6; ++a) polynomials[a] = found.axes[a].run->polynomial;
  EXPECT_LT(left(imus, errors_of_polynomials(polynomials)), 1e-8);
  polynomials[0].reset();
  EXPECT_GT(left(imus, errors_of_polynomials(polynomials)), 0.05);

  imus = run.simulate(1);
  Matrix3d gain, sensitivity;
  gain << 0, 0.01, -0.02, 0.005, 0, 0.015, -0.008, 0.004, 0;
  sensitivity << 1e-3, -5e-4, 3e-4, 2e-4, -1e-3, 6e-4, 8e-4, 0, -4e-4;
  for (std::size_t i = 0; i < imus.time.size(); ++i) {
    imus.gyro[i] += gain * imus.reference_gyro[i] + sensitivity * imus.reference_accel[i];
    imus.accel[i] += gain.transpose() * imus.reference_accel[i];
  }
  found = found_in(run, imus);
  EXPECT_LT(left(imus, errors_of_matrices(found.accel_matrix, found.gyro_matrix)), 1e-9);
  EXPECT_GT(left(imus, errors_of_matrices(found.accel_matrix, std::nullopt)), 0.01);
  EXPECT_GT(left(imus, errors_of_matrices(std::nullopt, found.gyro_matrix)), 0.01);
}

}  // namespace
}  // namespace piste
