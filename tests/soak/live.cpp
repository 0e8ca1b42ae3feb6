// A real-time session for hours: memory that does not grow, covariances that stay positive definite, sigmas that stay
// true. PISTE_SOAK_HOURS says how many hours of time it simulates, a tenth unless stated, and PISTE_SOAK_RATE at how
// many samples a second, 100 unless stated. Neither motion nor logs are stored.

#include "piste/live/live.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <Eigen/Cholesky>
#include <fstream>

#include "soak/endless_ride.h"

namespace piste::test {
namespace {

// Resident memory of this process [MiB].
double resident() {
  std::ifstream file("/proc/self/statm");
  double size = 0, pages = 0;
  file >> size >> pages;
  return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

TEST(Soak, LiveForHours) {
  constexpr double kLeastShare = 0.97;
  const double hertz = stated("PISTE_SOAK_RATE", 100);
  EndlessRide ride(hertz, 17);
  LiveOptions options;
  options.conditioning.imu.instantaneous = true;
  options.filter.sensor = ride.sensor();
  options.filter.gnss = {{.name = "gnss", .lever_arm = ride.lever_arm(), .drift = {}}};
  options.filter.estimate = {Block::kGyroBias,   Block::kAccelBias, Block::kGyroDrift,
                             Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale};
  Live live(options);
  const double end = 3600 * stated("PISTE_SOAK_HOURS", 0.1), settled = 600;
  double next_look = 60, memory = 0, inside = 0, looks = 0, squares = 0;
  for (double t = 0; t < end;) {
    const ImuRow row = ride.row();
    t = row.time;
    live.add(row);
    if (const auto fix = ride.fix()) live.add(0, *fix);
    if (t < next_look) continue;
    next_look += 1;
    const auto state = live.state();
    ASSERT_TRUE(state && live.filter() != nullptr) << t;
    const Vector3d error = ride.world().from_geodetic(state->position) - ride.position(state->time);
    ASSERT_TRUE(error.allFinite()) << t;
    const Eigen::LLT<Eigen::MatrixXd> factor(live.filter()->covariance());
    ASSERT_EQ(factor.info(), Eigen::Success) << "the covariance is not positive definite at " << t << " s";
    const Vector3d by_sigma = error.cwiseQuotient(state->sigmas.position);
    squares += by_sigma.squaredNorm() / 3;
    inside += static_cast<double>((by_sigma.array().abs() < 3).count()) / 3;
    ++looks;
    if (memory == 0 && t > settled) memory = resident();
  }
  fmt::print(
      "figure: {:.2f} h at {:.0f} Hz, {:.2f} % inside 3 sigma, mean square {:.3f}; {:.1f} MiB, {:.1f} after ten "
      "minutes\n",
      end / 3600, hertz, 100 * inside / looks, squares / looks, resident(), memory);
  EXPECT_GE(inside / looks, kLeastShare);
  EXPECT_GT(squares / looks, 0.5);
  EXPECT_LT(squares / looks, 1.5);
  if (memory > 0) {
    EXPECT_LT(resident(), memory + 4) << "MiB";
  }
}

}  // namespace
}  // namespace piste::test
