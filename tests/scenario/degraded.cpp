// Simulated runs as strangers log them, each degraded in one way or in two: `inspect` and then `replay` on what it
// wrote, with no hands.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "piste/configuration/sensor_file.h"
#include "piste/math/units.h"
#include "piste/replay/replay.h"
#include "piste/search/inspect.h"
#include "piste/sim/random.h"
#include "support/simulated_case.h"
#include "support/text_file.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

/// A run, what is logged of it, and how the logger's axes sit on the IMU's.
struct Stranger {
  Scenario scenario;
  Simulation simulation;
  ImuRecording imu;
  GnssRecording gnss;
  Matrix3d R_sb = Matrix3d::Identity();
};

struct Degradation {
  std::string name;
  std::function<void(Scenario&, RandomStream&)> before;  ///< the simulation
  std::function<void(Stranger&, RandomStream&)> after;
  std::vector<LogFault> named;  ///< suspicions that are true of it
};

Vector3d drawn_axis(RandomStream& random) {
  const auto i = static_cast<Eigen::Index>(3 * random.uniform());
  return (random.uniform() < 0.5 ? -1 : 1) * Vector3d::Unit(i);
}

void keep_span(Stranger& s, const Interval& span) {
  ImuRecording cut = s.imu;
  cut.time.clear();
  cut.gyro.clear();
  cut.accel.clear();
  for (std::size_t i = 0; i < s.imu.time.size(); ++i) {
    if (!span.contains(s.imu.time[i])) continue;
    cut.time.push_back(s.imu.time[i]);
    cut.gyro.push_back(s.imu.gyro[i]);
    cut.accel.push_back(s.imu.accel[i]);
  }
  s.imu = std::move(cut);
  std::erase_if(s.gnss.fixes, [&](const GeodeticFix& fix) { return !span.contains(fix.time); });
}

// In this order, so that times are cut before their clock is another.
const std::vector<Degradation>& degradations() {
  static const std::vector<Degradation> all{
      {"OneHertz",
       {},
       [](Stranger& s, RandomStream&) {
         std::erase_if(s.gnss.fixes,
                       [](const GeodeticFix& fix) { return std::abs(fix.time - std::round(fix.time)) > 0.01; });
       },
       {}},
      {"PositionsAlone",
       {},
       [](Stranger& s, RandomStream&) {
         for (GeodeticFix& fix : s.gnss.fixes) fix.velocity.reset();
       },
       {}},
      {"NoRest",
       {},
       [](Stranger& s, RandomStream&) {
         const Interval run = s.simulation.plate.under_way();
         keep_span(s, {run.start + 5, run.end - 5});
       },
       {}},
      {"MetresOff",
       [](Scenario& s, RandomStream&) {
         s.gnss[0].position_noise = {3, 3, 5};
       },
       {},
       {}},
      {"WholeMetres",
       {},
       [](Stranger& s, RandomStream& random) {
         const double above = random.uniform();  // the ellipsoid, of the surface from which they are counted
         for (GeodeticFix& fix : s.gnss.fixes) fix.position.height = std::round(fix.position.height + above) - above;
       },
       {LogFault::kSigmaTooSmall}},
      {"JitteredStamps",
       {},
       [](Stranger& s, RandomStream& random) {
         for (double& t : s.imu.time) t = 1e-3 * std::round(1e3 * (t + 0.004 * (random.uniform() - 0.5)));
       },
       {}},
      {"RowsDropped",
       {},
       [](Stranger& s, RandomStream& random) {
         ImuRecording kept = s.imu;
         kept.time.clear();
         kept.gyro.clear();
         kept.accel.clear();
         for (std::size_t i = 0; i < s.imu.time.size(); ++i) {
           if (random.uniform() < 0.01) continue;
           kept.time.push_back(s.imu.time[i]);
           kept.gyro.push_back(s.imu.gyro[i]);
           kept.accel.push_back(s.imu.accel[i]);
         }
         s.imu = std::move(kept);
       },
       {LogFault::kGaps}},
      {"LateVelocities",
       [](Scenario& s, RandomStream& random) { s.gnss[0].velocity_delay = 0.1 + 0.5 * random.uniform(); },
       {},
       {LogFault::kVelocityDelay}},
      {"SwappedAxes",
       {},
       [](Stranger& s, RandomStream& random) {
         const Vector3d x = drawn_axis(random);
         Vector3d y = x;
         while (x.dot(y) != 0) y = drawn_axis(random);
         s.R_sb.row(0) = x;
         s.R_sb.row(1) = y;
         s.R_sb.row(2) = x.cross(y);
         for (Vector3d& w : s.imu.gyro) w = s.R_sb * w;
         for (Vector3d& f : s.imu.accel) f = s.R_sb * f;
       },
       {}},
      {"FarAntenna", [](Scenario& s, RandomStream& random) { s.gnss[0].p_ra_r += 0.7 * random.normal3(); }, {}, {}},
      {"BootClock",
       {},
       [](Stranger& s, RandomStream& random) {
         const double boot = s.imu.time.front() - 1000 * random.uniform(), drift = 2e-5 * random.normal();
         for (double& t : s.imu.time) t = (1 + drift) * (t - boot);
       },
       {LogFault::kNoOverlap, LogFault::kClockOffset, LogFault::kNotSecondsOfWeek}},
  };
  return all;
}

Stranger stranger(const std::string& motion, std::uint64_t seed, const std::vector<const Degradation*>& how) {
  RandomStream random(seed, "degraded");
  Case c = make_case(motion, 360 * random.uniform(), seed, [&](Scenario& s) {
    s.imus[0].clock_offset = s.imus[0].clock_drift = 0;
    s.motion.run = 90;
    for (const Degradation* d : how) {
      if (d->before) d->before(s, random);
    }
  });
  Stranger s{c.scenario, std::move(c.simulation), {}, {}};
  s.imu = s.simulation.imus[0].recording;
  s.gnss = s.simulation.gnss[0];
  for (const Degradation* d : how) {
    if (d->after) d->after(s, random);
  }
  return s;
}

/// The largest error of a solution in its own sigmas, and where it is.
struct Worst {
  double sigmas = 0, time = 0;
  std::string what;
};

/// By how much a row comes late against the truth: what a run says of it, and errors of that about the middle of the
/// run.
struct Lateness {
  double delay = 0, drift = 0, from = 0, middle = 0;
  double delay_error = 0, drift_error = 0;
  double at(double t) const { return delay - drift * (t - from) + delay_error - drift_error * (t - middle); }
};

Worst worst_of(const Solution& solution, const Stranger& s, const Matrix3d& R_bs, const Interval& span,
               const Lateness& late) {
  constexpr double kEvery = 0.25;  // s
  constexpr std::array<const char*, 9> kNames{"north",  "east", "down",  "v north", "v east",
                                              "v down", "roll", "pitch", "heading"};
  const Truth& body = s.simulation.bodies[0];
  const Quaterniond q_sb(Matrix3d(R_bs * s.R_sb));
  Worst worst;
  double next = 0;
  for (std::size_t i = 0; i < solution.size(); ++i) {
    const double t = solution.time(i);
    if (t < next || !span.contains(t)) continue;
    next = t + kEvery;
    const TruthState truth = body.at(t + late.at(t));
    const World& world = body.world();
    const Matrix3d R_nw = world.rotation_wn(truth.p_wb).transpose();
    const auto nav = solution.navigation(i);
    const Sigmas sigma = solution.sigmas(i);
    const Vector3d position = World(world.to_geodetic(truth.p_wb)).from_geodetic(nav.position);
    const Vector3d velocity = nav.velocity - R_nw * truth.v_wb;
    const Vector3d euler = nav.euler - to_euler(Quaterniond(R_nw) * truth.q_wb * q_sb.conjugate());
    for (int k = 0; k < 9; ++k) {
      const int axis = k % 3;
      const double error = k < 3 ? position(axis) : k < 6 ? velocity(axis) : std::remainder(euler(axis), 2 * M_PI);
      const double own = k < 3 ? sigma.position(axis) : k < 6 ? sigma.velocity(axis) : sigma.euler(axis);
      if (std::abs(error) > worst.sigmas * own) {
        worst = {std::abs(error) / own, t - body.start_time(),
                 fmt::format("{} {:.3g} +- {:.3g}", kNames[static_cast<std::size_t>(k)], error, own)};
      }
    }
  }
  return worst;
}

// Where the clock was found from the motion, rows are in the receiver's time as delay and drift have it, which are off
// as well. So their errors, which are two numbers for the run, are looked for within their own sigmas, by turns. Else
// the clock is that of the log.
Worst worst_of(const Solution& solution, const Stranger& s, const Matrix3d& R_bs, const Interval& span,
               std::optional<double> clock_from) {
  if (!clock_from) return worst_of(solution, s, R_bs, span, Lateness{});
  const std::size_t last = solution.size() - 1;
  const Estimate x = solution.estimate(last);
  const FullError sigmas = solution.sigmas(last).blocks;
  Lateness late{x.gnss_delay, x.clock_drift, *clock_from, (span.start + span.end) / 2};
  Worst best{std::numeric_limits<double>::infinity(), 0, ""};
  const auto look = [&](double Lateness::*error, double sigma, const char* name) {
    for (double step = sigma / 2; step > sigma / 500; step /= 4) {
      const double about = late.*error;
      for (int k = -5; k <= 5; ++k) {
        Lateness other = late;
        other.*error = about + k * step;
        Worst worst = worst_of(solution, s, R_bs, span, other);
        if (std::abs(other.*error) > worst.sigmas * sigma)
          worst = {std::abs(other.*error) / sigma, 0, fmt::format("{} {:.3g} +- {:.3g}", name, other.*error, sigma)};
        if (worst.sigmas >= best.sigmas) continue;
        best = worst;
        late = other;
      }
    }
  };
  constexpr int kTurns = 3;
  for (int turn = 0; turn < kTurns; ++turn) {
    look(&Lateness::delay_error, sigmas(full_offset(Block::kGnssDelay)), "delay");
    if (!solution.layout().has(Block::kClockDrift)) break;
    look(&Lateness::drift_error, sigmas(full_offset(Block::kClockDrift)), "clock drift");
  }
  return best;
}

/// Inspects and replays a run as a user would, from an empty folder.
void expect_right(const Stranger& s, const std::vector<const Degradation*>& how, const std::string& run) {
  SCOPED_TRACE(run);
  const TemporaryFolder folder;
  const Inspection found =
      inspect({folder.write("imu.csv", imu_csv(s.imu)), folder.write("gnss.csv", gnss_csv(s.gnss))});
  for (const Suspicion& suspicion : found.suspicions) {
    const bool true_of_it = std::ranges::any_of(
        how, [&](const Degradation* d) { return std::ranges::count(d->named, suspicion.fault) > 0; });
    EXPECT_TRUE(true_of_it || !is_severe(suspicion.fault))
        << static_cast<int>(suspicion.fault) << ": " << suspicion.file << ": " << suspicion.what;
  }
  const auto text = ready_config(found, folder.path().string(), "sensor.yaml");
  ASSERT_TRUE(text);
  folder.write("sensor.yaml", sensor_text(guess_sensor(found)));
  const ReplayConfig config = read_replay_config(folder.write("replay.yaml", *text));
  const Replay done = replay(config);
  ASSERT_TRUE(done.smoothed);
  Interval span = s.simulation.plate.under_way();
  span.start = std::max(span.start, done.log.imu.front().time);
  const ImuConditioning& clock = config.conditioning.imu;
  const auto found_clock =
      clock.clock_offset != 0 || clock.clock_drift != 0 ? done.options.clock_from : std::optional<double>();
  const Worst filtered = worst_of(done.filtered.solution, s, config.conditioning.imu.R_bs, span, found_clock);
  const Worst smoothed = worst_of(*done.smoothed, s, config.conditioning.imu.R_bs, span, found_clock);
  EXPECT_LT(filtered.sigmas, 5) << fmt::format("filtered at {:.1f} s: {}\n{}", filtered.time, filtered.what, *text);
  EXPECT_LT(smoothed.sigmas, 5) << fmt::format("smoothed at {:.1f} s: {}\n{}", smoothed.time, smoothed.what, *text);
  if (std::getenv("PISTE_TELL") != nullptr) {
    for (const Interval& rest : done.log.rest)
      fmt::print("  at rest from {:.1f} to {:.1f} s\n", rest.start - s.scenario.start_time,
                 rest.end - s.scenario.start_time);
    fmt::print("{}: filtered {:.2f} ({} at {:.1f} s), smoothed {:.2f} ({} at {:.1f} s)\n", run, filtered.sigmas,
               filtered.what, filtered.time, smoothed.sigmas, smoothed.what, smoothed.time);
  }
}

// Seed s goes skiing, cycling, and so on.
void run(const std::vector<const Degradation*>& how, std::uint64_t first, std::uint64_t last) {
  constexpr std::array kMotions{"ski", "bicycle", "easy_ski"};
  std::string names;
  for (const Degradation* d : how) names += d->name + ' ';
  for (std::uint64_t seed = first; seed <= last; ++seed) {
    const std::string motion = kMotions[seed % kMotions.size()];
    const std::string said = fmt::format("{}{} {}", names, motion, seed);
    try {
      expect_right(stranger(motion, seed, how), how, said);
    } catch (const std::exception& e) {
      ADD_FAILURE() << said << ": " << e.what();
    }
  }
}

const Degradation* named(const std::string& name) {
  return &*std::ranges::find(degradations(), name, &Degradation::name);
}

class Degraded : public ::testing::TestWithParam<std::size_t> {};

// On each change every third way is tried.
TEST_P(Degraded, InOneWay) {
  if (!thorough() && GetParam() % 3 != 0) GTEST_SKIP() << "with PISTE_THOROUGH=1";
  const auto usual = static_cast<std::uint64_t>(GetParam());
  run({&degradations()[GetParam()]}, thorough() ? 1 : usual, thorough() ? 18 : usual);
}

TEST_P(Degraded, InTwoWays) {
  if (!thorough()) GTEST_SKIP() << "with PISTE_THOROUGH=1";
  for (std::size_t other = GetParam() + 1; other < degradations().size(); ++other)
    run({&degradations()[GetParam()], &degradations()[other]}, 101, 118);
}

// Nothing at rest tells the biases, and the delay is not known: filters went astray by 10 to 28 degrees here.
TEST(DegradedWithoutRest, NoUnknownDelayLeadsAstray) {
  run({named("NoRest"), named("RowsDropped")}, 108, 108);
  if (thorough()) run({named("NoRest"), named("MetresOff")}, 115, 115);
}

// On a level road they stand still, and were taken for as good as exact: they were wrong by up to 29 sigmas.
TEST(DegradedByRounding, HeightsThatStandStillAreNotExact) { run({named("WholeMetres")}, 4, thorough() ? 10 : 4); }

INSTANTIATE_TEST_SUITE_P(Strangers, Degraded, ::testing::Range<std::size_t>(0, degradations().size()),
                         [](const auto& each) { return degradations()[each.param].name; });

}  // namespace
}  // namespace piste::test
