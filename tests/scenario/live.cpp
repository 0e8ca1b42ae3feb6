// A live session beside a replay of the same data: rest, start and filter find the same.

#include "piste/live/live.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "core/time_search.h"
#include "piste/core/error.h"
#include "piste/filter/run.h"
#include "support/simulated_case.h"
#include "support/text_file.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

/// Feeds a recording as a logger would: fixes come when the receiver has them, some time after they were measured.
class Logger {
 public:
  Logger(const Case& c, double latency, double pass_interval = LiveOptions{}.pass_interval)
      : recording_(c.simulation.recording(0)),
        live_({.conditioning = c.conditioning, .filter = c.options, .pass_interval = pass_interval}),
        clock_offset_(c.conditioning.imu.clock_offset),
        clock_drift_(c.conditioning.imu.clock_drift),
        latency_(latency),
        next_(recording_.gnss.size()) {}

  /// Until the time `until`; calls `each` after each row.
  template <class Each>
  void feed(double until, Each&& each) {
    const ImuRecording& imu = recording_.imu;
    for (; row_ < imu.time.size(); ++row_) {
      const double now = imu.time[row_] - clock_offset_;
      if (now > until) break;
      for (std::size_t i = 0; i < next_.size(); ++i) {
        const auto& fixes = recording_.gnss[i].fixes;
        for (; next_[i] < fixes.size() && fixes[next_[i]].time + latency_ <= now; ++next_[i]) {
          if (fixes[next_[i]].time <= last_fix_) live_.add(static_cast<int>(i), fixes[next_[i]]);
        }
      }
      live_.add({imu.time[row_], imu.gyro[row_], imu.accel[row_]});
      newest_ = now - clock_drift_ * (imu.time[row_] - imu.time.front());
      each(live_);
    }
  }
  /// Loses the rows until then.
  void skip(double until) {
    while (row_ < recording_.imu.time.size() && recording_.imu.time[row_] - clock_offset_ <= until) ++row_;
  }
  Live& live() { return live_; }
  /// Fixes that are later do not come.
  void end_fixes(double last) { last_fix_ = last; }
  /// GPS time of the last row.
  double newest() const { return newest_; }

 private:
  Recording recording_;
  Live live_;
  double clock_offset_, clock_drift_, latency_, newest_ = 0, last_fix_ = 1e300;
  std::vector<std::size_t> next_;
  std::size_t row_ = 0;
};

struct LiveCase {
  const char* name;
  const char* motion;
  std::function<void(Case&)> change;
};

void PrintTo(const LiveCase& kind, std::ostream* out) { *out << kind.name; }

void without_velocities(Case& c) { c.options.gnss[0].use_velocity = false; }

class LiveRun : public ::testing::TestWithParam<LiveCase> {};

// A minute under way both filters have the same data but for the first seconds.
TEST_P(LiveRun, SaysWhatReplaySays) {
  for (int seed = 1; seed <= seeds(2, 20); ++seed) {
    Case c = make_case(GetParam().motion, 40 + 50 * seed, static_cast<std::uint64_t>(seed),
                       [](Scenario& s) { s.motion.run = 70; });
    GetParam().change(c);
    const double end = c.under_way() + 61;
    Logger logger(c, 0.2);
    std::size_t wrong = 0, rows = 0;
    logger.feed(end, [&](const Live& live) {
      if (++rows % 200 != 0 || !live.state()) return;
      const LiveState s = *live.state();
      const double truth = to_euler(c.simulation.bodies[0].at(s.time).q_wb).z();
      const double off = std::abs(std::remainder(s.euler.z() - truth, 360 * kDegree));
      if (off > 5 * s.sigmas.euler.z()) ++wrong;
    });
    EXPECT_EQ(wrong, 0u) << "headings beyond 5 sigma, seed " << seed;
    const Filter* live = logger.live().filter();
    ASSERT_NE(live, nullptr);
    EXPECT_EQ(logger.live().late(), 0u);

    const Log log = c.log();
    const FoundStart found = find_start(log, c.options, {});
    const FilterRun run =
        run_filter(log, c.options, found.start, Keep::kNothing, {}, {.end = live->time() + kSameInstant});
    const std::size_t last = run.solution.size() - 1;
    ASSERT_NEAR(run.solution.time(last), live->time(), 1e-6);
    const Estimate a = live->estimate(), b = run.solution.estimate(last);
    const Sigmas sigmas = run.solution.sigmas(last);
    const Vector3d place = log.world.from_geodetic(live->world().to_geodetic(a.p_wb)) - b.p_wb;
    const double position = place.cwiseQuotient(sigmas.position).cwiseAbs().maxCoeff();
    const double velocity = (a.v_wb - b.v_wb).cwiseQuotient(sigmas.velocity).cwiseAbs().maxCoeff();
    const Vector3d turn = (to_euler(a.q_wb) - to_euler(b.q_wb)).unaryExpr([](double angle) {
      return std::remainder(angle, 2 * std::numbers::pi);
    });
    const double attitude = turn.cwiseQuotient(sigmas.euler).cwiseAbs().maxCoeff();
    const double ratio =
        sigmas_of(live->world(), a, live->layout(), live->covariance()).euler.cwiseQuotient(sigmas.euler).maxCoeff();
    fmt::print("{} seed {}: position {:.3f} velocity {:.3f} attitude {:.3f} sigma apart, sigmas {:.3f} to one\n",
               GetParam().name, seed, position, velocity, attitude, ratio);
    EXPECT_LT(position, 0.2);
    EXPECT_LT(velocity, 0.2);
    EXPECT_LT(attitude, 0.2);
    EXPECT_NEAR(ratio, 1, 0.05);
  }
}

INSTANTIATE_TEST_SUITE_P(All, LiveRun,
                         ::testing::Values(LiveCase{"ski", "ski", [](Case&) {}},
                                           LiveCase{"positions", "giant_slalom", without_velocities},
                                           LiveCase{"bicycle", "bicycle", [](Case&) {}}),
                         [](const auto& each) { return std::string(each.param.name); });

// At rest nothing tells the heading, and it is claimed so.
TEST(Live, AtRestTheHeadingIsNotKnown) {
  Case c = make_case("ski", 200, 1, [](Scenario& s) { s.motion.rest_before = 60; });
  Logger logger(c, 0);
  logger.feed(c.under_way() - 3, [](const Live&) {});
  ASSERT_TRUE(logger.live().state());
  const LiveState s = *logger.live().state();
  EXPECT_FALSE(s.heading_known);
  EXPECT_GT(s.sigmas.euler.z(), 100 * kDegree);
  EXPECT_LT(s.sigmas.euler.x(), 1 * kDegree);
  EXPECT_LT(s.velocity.norm(), 0.05);
  EXPECT_EQ(logger.live().filter(), nullptr);
}

// The newest row is more than a second ahead of the filter.
TEST(Live, NowIsAtTheNewestRow) {
  const Case c = make_case("ski", 30, 1);
  Logger logger(c, 0.2);
  const double end = c.under_way() + 30, pass = LiveOptions{}.pass_interval;
  double farthest = 0;
  std::size_t rows = 0;
  logger.feed(end, [&](const Live& live) {
    if (++rows % 7 != 0) return;  // all distances from a pass
    if (const auto now = live.now()) farthest = std::max(farthest, std::abs(now->time - logger.newest()));
  });
  EXPECT_LT(farthest, 1e-6);
  const LiveState now = *logger.live().now(), behind = *logger.live().state();
  EXPECT_NEAR(now.time, logger.newest(), 1e-6);
  EXPECT_NEAR(behind.time, now.time - 1.5 - pass / 2, pass / 2 + 0.02);
  const auto truth = c.simulation.bodies[0].at(now.time);
  const World world(c.simulation.recording(0).gnss[0].fixes.front().position);
  EXPECT_LT((now.velocity - truth.v_wb).norm(), 5 * now.sigmas.velocity.norm());
  EXPECT_GT(now.sigmas.position.norm(), behind.sigmas.position.norm());
}

// Rows that are not conditioned yet tell what they tell after that: a session with more passes says the same.
TEST(Live, NowIsWhatMorePassesSay) {
  const Case c = make_case("giant_slalom", 30, 1);
  Logger seldom(c, 0.2), often(c, 0.2, 0.03);
  const double end = c.under_way() + 25.12;  // between two passes, and after the same fixes
  seldom.end_fixes(end - 1);
  often.end_fixes(end - 1);
  seldom.feed(end, [](const Live&) {});
  often.feed(end, [](const Live&) {});
  const LiveState a = *seldom.live().now(), b = *often.live().now();
  ASSERT_NEAR(a.time, b.time, 1e-6);
  const World world(b.position);
  const Vector3d apart = world.from_geodetic(a.position), turn = a.euler - b.euler;
  fmt::print("{:.4f} m, {:.4f} m/s and {:.4f} deg apart\n", apart.norm(), (a.velocity - b.velocity).norm(),
             turn.norm() / kDegree);
  EXPECT_LT(apart.cwiseQuotient(b.sigmas.position).cwiseAbs().maxCoeff(), 0.1);
  EXPECT_LT((a.velocity - b.velocity).cwiseQuotient(b.sigmas.velocity).cwiseAbs().maxCoeff(), 0.1);
  EXPECT_LT(turn.cwiseQuotient(b.sigmas.euler).cwiseAbs().maxCoeff(), 0.1);
}

// A gap after the last pass is bridged, with the noise of a motion that nobody measured.
TEST(Live, NowIsLessSureAfterAGap) {
  const Case c = make_case("ski", 30, 1);
  Logger whole(c, 0.2), broken(c, 0.2);
  const double end = c.under_way() + 25;
  const auto at_a_row = [](const Live&) {};
  whole.feed(end, at_a_row);
  broken.feed(end - 0.12, at_a_row);
  broken.skip(end - 0.02);
  broken.feed(end, at_a_row);
  const LiveState a = *whole.live().now(), b = *broken.live().now();
  EXPECT_NEAR(a.time, b.time, 1e-6);
  EXPECT_GT(b.sigmas.velocity.norm(), 1.2 * a.sigmas.velocity.norm());
  EXPECT_LT((a.velocity - b.velocity).norm(), 5 * b.sigmas.velocity.norm());
}

TEST(Live, SaysWhatIsWrong) {
  LiveOptions options;
  EXPECT_THROW(Live{options}, ConfigError);
  options.filter = make_case("ski", 30, 1).options;
  Live live(options);
  live.add({1, Vector3d::Zero(), Vector3d::UnitZ()});
  EXPECT_TRUE(contains(message_of<DataError>([&] { live.add({1, {}, {}}); }), "does not increase"));
  EXPECT_FALSE(live.state());
  EXPECT_FALSE(live.now());

  const Vector3d nothing = Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  const auto row = [&] { live.add({2, nothing, Vector3d::UnitZ()}); };
  EXPECT_TRUE(contains(message_of<DataError>(row), "must be finite"));
  const GeodeticFix good{.time = 1, .position = {0.8, 0.1, 100}, .sigma_position = {1, 1, 2}, .velocity = {}};
  const auto refused = [&](const std::function<void(GeodeticFix&)>& change, const std::string& why, int receiver = 0) {
    GeodeticFix fix = good;
    change(fix);
    const std::string said = message_of<DataError>([&] { live.add(receiver, fix); });
    EXPECT_TRUE(contains(said, why)) << said;
  };
  refused([](GeodeticFix&) {}, "there is no receiver 3", 3);
  refused([](GeodeticFix&) {}, "there is no receiver -1", -1);
  refused([&](GeodeticFix& f) { f.time = nothing.x(); }, "must be finite");
  refused([&](GeodeticFix& f) { f.position.latitude = nothing.x(); }, "must be finite");
  refused([](GeodeticFix& f) { f.position.latitude = 46; }, "beyond 90 deg");
  refused([&](GeodeticFix& f) { f.sigma_position.y() = nothing.x(); }, "sigmas of a position");
  refused([](GeodeticFix& f) { f.velocity = {Vector3d::Zero(), Vector3d::Zero()}; }, "sigmas of a velocity");
  live.add(0, good);
  live.add({2, Vector3d::Zero(), Vector3d::UnitZ()});
}

// What a receiver says before it has a fix is refused, and the session goes on as if it had not been there.
TEST(Live, GoesOnAfterWhatItRefused) {
  const Case c = make_case("ski", 30, 1);
  Logger plain(c, 0.2), disturbed(c, 0.2);
  const double end = c.under_way() + 20;
  int refused = 0;
  plain.feed(end, [](const Live&) {});
  disturbed.feed(end, [&](Live& live) {
    GeodeticFix none{.time = 0, .position = {}, .sigma_position = {1, 1, 2}, .velocity = {}};
    none.position.height = std::numeric_limits<double>::quiet_NaN();
    EXPECT_THROW(live.add(0, none), DataError);
    ++refused;
  });
  EXPECT_GT(refused, 1000);
  ASSERT_TRUE(plain.live().state() && disturbed.live().state());
  EXPECT_EQ(plain.live().state()->velocity, disturbed.live().state()->velocity);
}

// A receiver may take long to its first fix; rows that are older than the memory do not count by then.
TEST(Live, ForgetsRowsBeforeTheFirstFix) {
  const Case c = make_case("ski", 30, 1);
  const Recording recording = c.simulation.recording(0);
  Live live({.conditioning = c.conditioning, .filter = c.options});
  const double first = recording.imu.time.front();
  for (int i = 0; i < 10; ++i) live.add({first - 1000 + 0.01 * i, Vector3d::Zero(), Vector3d(0, 0, -9.81)});
  std::size_t next = 0;
  const std::vector<GeodeticFix>& fixes = recording.gnss[0].fixes;
  for (std::size_t i = 0; recording.imu.time[i] < first + 60; ++i) {
    const double now = recording.imu.time[i] - c.conditioning.imu.clock_offset;
    for (; next < fixes.size() && fixes[next].time <= now; ++next) live.add(0, fixes[next]);
    live.add({recording.imu.time[i], recording.imu.gyro[i], recording.imu.accel[i]});
  }
  EXPECT_TRUE(live.state());
}

}  // namespace
}  // namespace piste::test
