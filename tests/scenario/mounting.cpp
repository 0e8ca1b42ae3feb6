// The MEMS at any rotation against the reference attitude: the start finds it, the filter refines it.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "piste/smoother/rts.h"
#include "support/random.h"
#include "support/simulated_case.h"
#include "support/text_file.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

using Source = InitialHeading::Source;

struct Mounting {
  std::string name;
  Quaterniond turn;
};

// Quarter and half turns about each axis, combinations of them, and some rotations of no order.
std::vector<Mounting> mountings() {
  std::vector<Mounting> out{{"as it is", Quaterniond::Identity()}};
  for (int axis = 0; axis < 3; ++axis) {
    for (const double angle : {90, -90, 180}) {
      out.push_back(
          {fmt::format("{} deg about {}", angle, "xyz"[axis]), so3_exp(angle * kDegree * Vector3d::Unit(axis))});
    }
  }
  out.push_back({"120 deg about the diagonal", so3_exp(120 * kDegree * Vector3d(1, 1, 1).normalized())});
  out.push_back({"x up", so3_exp(-48 * kDegree * Vector3d::UnitY())});  // the plate itself is pitched by -42 deg
  out.push_back({"x down", so3_exp(132 * kDegree * Vector3d::UnitY())});
  Random random(7);
  for (int i = 0; i < 3; ++i) out.push_back({fmt::format("random {}", i), random.rotation()});
  return out;
}

Case mounted(const std::string& motion, const Mounting& mounting, std::uint64_t seed,
             const std::function<void(Scenario&)>& change = {}) {
  Case c = make_case(motion, 75, seed, [&](Scenario& s) {
    if (change) change(s);
    s.attitude = read_scenario(s.file).attitude;
    s.imus[0].q_rb = mounting.turn * s.imus[0].q_rb;
  });
  c.options.attitude[0].drift = c.scenario.attitude[0].drift;
  c.options.estimate.push_back(Block::kBoresight);
  c.options.estimate.push_back(Block::kAttitudeDrift);
  return c;
}

// Smoothed, at the start of the log, whole: rotation vectors of boresight and attitude, and their sigmas.
struct FoundMounting {
  Vector3d boresight, boresight_sigma, attitude, attitude_sigma;
  std::string how;
};

FoundMounting replay(const Case& c, const Log& log, const InitialHeading& heading) {
  const FoundStart start = find_start(log, c.options, heading);
  const FilterRun run = run_filter(log, c.options, start.start, Keep::kHistory);
  SmoothedState first;
  const Solution smoothed = smooth_rts(run, {}, &first);
  const auto sigma = [&](Block b) {
    return Vector3d(first.P.diagonal().segment<3>(smoothed.layout().offset(b)).cwiseSqrt());
  };
  for (std::size_t i = 0; i < smoothed.size(); i += 1000) {
    EXPECT_TRUE(smoothed.sigmas(i).blocks.allFinite());
    EXPECT_TRUE(smoothed.sigmas(i).euler.allFinite());
  }
  const Quaterniond q_wb = c.simulation.bodies[0].at(start.start.time).q_wb;
  return {so3_log(c.scenario.imus[0].q_rb * first.x.q_rb.conjugate()), sigma(Block::kBoresight),
          so3_log(q_wb * first.x.q_wb.conjugate()), sigma(Block::kAttitude), start.how};
}

/// Errors within 4 of their sigmas, and these below bounds [rad].
void expect_found(const FoundMounting& f, double boresight_sigma, double attitude_sigma, const std::string& name) {
  EXPECT_LT(f.boresight.cwiseQuotient(f.boresight_sigma).cwiseAbs().maxCoeff(), 4) << name << ": " << f.how;
  EXPECT_LT(f.attitude.cwiseQuotient(f.attitude_sigma).cwiseAbs().maxCoeff(), 4) << name << ": " << f.how;
  EXPECT_LT(f.boresight_sigma.maxCoeff(), boresight_sigma) << name;
  EXPECT_LT(f.attitude_sigma.maxCoeff(), attitude_sigma) << name;
  fmt::print("{:28} boresight error {:.3f} deg, sigma {:.3f} deg, attitude error {:.3f} deg, sigma {:.3f} deg\n", name,
             f.boresight.norm() / kDegree, f.boresight_sigma.maxCoeff() / kDegree, f.attitude.norm() / kDegree,
             f.attitude_sigma.maxCoeff() / kDegree);
}

class Mounted : public testing::TestWithParam<std::tuple<const char*, Source, bool>> {};

// Each of the eight ways to start sees every third mounting, and all of them see all.
TEST_P(Mounted, IsFoundWhateverItIs) {
  const auto& [motion, source, rest] = GetParam();
  const std::vector<Mounting> all = mountings();
  double boresight = 0, attitude = 0, count = 0;
  for (std::size_t i = (source == Source::kAuto ? 0 : 1) + (rest ? 1 : 0); i < all.size(); i += thorough() ? 1 : 3) {
    Case c = mounted(motion, all[i], i + 1);
    if (!rest) c.conditioning.span = {c.under_way() + 8.3, c.under_way() + 60};
    const FoundMounting f = replay(c, c.log(), {.source = source});
    expect_found(f, 0.06 * kDegree, 0.08 * kDegree, all[i].name);
    boresight += f.boresight.cwiseQuotient(f.boresight_sigma).squaredNorm() / 3;
    attitude += f.attitude.cwiseQuotient(f.attitude_sigma).squaredNorm() / 3;
    ++count;
  }
  ASSERT_GE(count, 4);
  const Band band = chi_squared_band(0.999, 3, count);
  fmt::print("NEES of boresight {:.2f}, of attitude {:.2f}, band {:.2f} to {:.2f}\n", boresight / count,
             attitude / count, band.low, band.high);
  EXPECT_TRUE(band.contains(boresight / count)) << boresight / count;
  EXPECT_TRUE(band.contains(attitude / count)) << attitude / count;
}

INSTANTIATE_TEST_SUITE_P(Runs, Mounted,
                         testing::Combine(testing::Values("ski", "giant_slalom"),
                                          testing::Values(Source::kAuto, Source::kAttitude), testing::Bool()),
                         [](const auto& each) {
                           return fmt::format("{}_{}_{}", std::get<0>(each.param),
                                              std::get<1>(each.param) == Source::kAuto ? "auto" : "from_attitude",
                                              std::get<2>(each.param) ? "from_rest" : "on_the_move");
                         });

const Mounting kQuarterTurn{"90 deg about z", so3_exp(90 * kDegree * Vector3d::UnitZ())};
const Mounting kOnItsSide{"90 deg about x", so3_exp(90 * kDegree * Vector3d::UnitX())};

TEST(Mounting, IsFoundWhereTheReferenceBeginsLater) {
  Case c = mounted("ski", kQuarterTurn, 1);
  Log log = c.log();
  std::erase_if(log.attitude[0], [&](const AttitudeFix& fix) { return fix.time < c.under_way() + 5; });
  expect_found(replay(c, log, {.source = Source::kAttitude}), 0.06 * kDegree, 0.4 * kDegree, "reference begins later");
}

// A body that does not move at all: nothing tells how the IMU sits. A small boresight is taken with its prior, the
// heading with three times that, and a boresight that gravity shows not to be small is refused.
TEST(Mounting, IsNotMadeUpWhereNothingTurns) {
  const auto start = [](const Mounting& mounting, std::uint64_t seed) {
    Case c = mounted("ski", mounting, seed, [](Scenario& s) {
      s.motion.sway_velocity.setZero();
      s.motion.sway_rate.setZero();
      s.motion.turning_rate = 0;
    });
    c.conditioning.span = {0, c.under_way() - 2};
    return c.find({.source = Source::kAttitude});
  };
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    const FoundStart found = start({"as it is", Quaterniond::Identity()}, seed);
    EXPECT_TRUE(contains(found.how, "taken for small")) << found.how;
    EXPECT_GT(std::sqrt(found.start.covariance(8, 8)), 25 * kDegree);
  }
  const std::string message = message_of<DataError>([&] { start(kOnItsSide, 1); });
  EXPECT_TRUE(contains(message, "boresight cannot be found"));
  EXPECT_TRUE(contains(message, "a stretch of motion"));
}

}  // namespace
}  // namespace piste::test
