// The one chain: it is its steps in their order, from files and from memory, and what Monte Carlo certifies.

#include "piste/replay/replay.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>

#include "core/time_search.h"
#include "piste/consistency/verdict.h"
#include "piste/io/solution_io.h"
#include "piste/smoother/rts.h"
#include "piste/start/attitude_noise.h"
#include "piste/start/initial_stretch.h"
#include "piste/trial/trial.h"
#include "smoother/relinearise.h"
#include "support/places.h"
#include "support/scenario.h"
#include "support/simulated_case.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

using Source = InitialHeading::Source;

// Every number of a solution that a reader could see, to the last bit.
std::vector<double> numbers(const Solution& solution) {
  std::vector<double> all;
  const auto add = [&](const auto& values) { all.insert(all.end(), values.data(), values.data() + values.size()); };
  for (std::size_t i = 0; i < solution.size(); ++i) {
    const Estimate x = solution.estimate(i);
    const Sigmas s = solution.sigmas(i);
    all.push_back(solution.time(i));
    add(x.q_wb.coeffs());
    for (const Vector3d& v : {x.v_wb, x.p_wb, x.gyro_bias, x.accel_bias, s.position, s.velocity, s.euler}) add(v);
    add(s.blocks);
  }
  for (const Innovation& v : solution.innovations) {
    all.insert(all.end(), {v.time, v.nis, v.gate, static_cast<double>(v.source), static_cast<double>(v.outcome)});
    all.insert(all.end(), v.residual.data(), v.residual.data() + v.dof);
    all.insert(all.end(), v.sigma.data(), v.sigma.data() + v.dof);
  }
  return all;
}

void expect_same(const Replay& a, const Replay& b) {
  EXPECT_GT(a.filtered.solution.size(), 1000U);
  EXPECT_EQ(a.found.how, b.found.how);
  EXPECT_EQ(a.log.rest.size(), b.log.rest.size());
  EXPECT_TRUE(numbers(a.filtered.solution) == numbers(b.filtered.solution));
  ASSERT_TRUE(a.smoothed && b.smoothed);
  EXPECT_TRUE(numbers(*a.smoothed) == numbers(*b.smoothed));
  EXPECT_EQ(a.smoothed->attitude_correlation_time, b.smoothed->attitude_correlation_time);
}

// Of the reference attitude's error a part is white that no default is near.
void make_half_white(AttitudeSetup& reference) { reference.noise = reference.drift->sigma; }

// A short run of every kind of sensor.
Case short_case() {
  Case c = make_case("ski", 120, 3, [](Scenario& s) {
    const Scenario whole = read_scenario(s.file);
    s.attitude = whole.attitude;
    make_half_white(s.attitude[0]);
    s.gnss = whole.gnss;
    s.imus[0].magnetic_field = {22, 0, 42};
    s.imus[0].magnetometer.sigma = 0.3;
    s.motion.rest_before = 25;  // enough to measure the white part
    s.motion.run = 20;
    s.motion.rest_after = 2;
  });
  c.options.gnss.clear();
  for (const GnssSetup& receiver : c.scenario.gnss) {
    c.options.gnss.push_back(
        {.name = receiver.name, .lever_arm = lever_arm(c.scenario.imus[0], receiver), .drift = {}});
  }
  c.options.attitude[0].drift = GaussMarkov{Vector3d::Zero(), 60};
  c.options.estimate.insert(c.options.estimate.end(), {Block::kBoresight, Block::kAttitudeDrift});
  return c;
}

const Case& the_case() {
  static const Case c = short_case();
  return c;
}

ReplayOptions usual_options() { return {.conditioning = the_case().conditioning, .filter = the_case().options}; }

Replay replay_with(const ReplayOptions& options) { return replay(the_case().simulation.recording(0), options); }

const Replay& usual_replay() {
  static const Replay run = replay_with(usual_options());
  return run;
}

// The run as files, with their configuration.
std::string write_files(const TemporaryFolder& folder) {
  const Case& c = the_case();
  std::string config =
      fmt::format("imu: {{file: imu.csv, sensor: {}/config/sensors/xsens_mt9a.yaml, ", source_folder());
  config += fmt::format("clock: {{offset: {} s, drift: {} ppm}}}}\ngnss:\n", c.conditioning.imu.clock_offset,
                        1e6 * c.conditioning.imu.clock_drift);
  folder.write("imu.csv", imu_csv(c.simulation.imus[0].recording));
  for (std::size_t i = 0; i < c.simulation.gnss.size(); ++i) {
    const Vector3d& arm = c.options.gnss[i].lever_arm;
    folder.write(fmt::format("gnss_{}.csv", i), gnss_csv(c.simulation.gnss[i]));
    config += fmt::format("  - {{file: gnss_{}.csv, lever_arm: {} {} {} m}}\n", i, arm.x(), arm.y(), arm.z());
  }
  folder.write("attitude.csv", attitude_csv(c.simulation.attitude[0]));
  config += "attitude: {file: attitude.csv, correlation_time: 60 s}\n";
  config += "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale, boresight]\n";
  return folder.write("run.yaml", config);
}

TEST(Replay, IsItsStepsInTheirOrder) {
  const TemporaryFolder folder;
  const ReplayConfig config = read_replay_config(write_files(folder));
  const Replay run = replay(config);

  const Recording recording = read_recording(config);
  Replay by_hand;
  by_hand.log = condition(recording, config.conditioning);
  by_hand.options = with_white_part(with_attitude_sigmas(config.filter, recording.attitude), by_hand.log);
  by_hand.found = find_start(by_hand.log, by_hand.options, config.initial);
  by_hand.stretch = initial_stretch(by_hand.log, by_hand.options, by_hand.found);
  by_hand.filtered = filter_from(by_hand.stretch, by_hand.log, by_hand.options, by_hand.found, Keep::kHistory);
  std::vector<AttitudeLag> lags;
  by_hand.relinearised =
      relinearised(by_hand.log, by_hand.options, without_alignment(by_hand.log.world, by_hand.found), by_hand.filtered);
  by_hand.smoothed = smooth_rts(*by_hand.relinearised, {}, nullptr, &lags);
  by_hand.smoothed->attitude_correlation_time = correlation_time(lags);
  expect_same(run, by_hand);
  EXPECT_EQ(run.log.rest.size(), 2U);
  EXPECT_GT(run.smoothed->attitude_correlation_time, 0);
  EXPECT_TRUE(run.options.attitude[0].white == by_hand.options.attitude[0].white);
  EXPECT_FALSE(run.options.attitude[0].white == AttitudeOptions{}.white) << "it was measured";

  expect_same(run, replay(recording, replay_options(config)));
  expect_same(run, replay(config));
}

// Appends what is streamed, and counts that nothing is missing.
RowTaker into(Solution& rows) {
  return [&rows](Solution& next, std::size_t first) {
    EXPECT_EQ(first, rows.size());
    rows.append(next.rows());
  };
}

// Rows can be streamed, and a smoother's history can be in a file: they are those of the whole solutions, of which a
// part stays, and the log is the same where the recording is taken apart.
TEST(Replay, StreamsItsRows) {
  const TemporaryFolder folder;
  const ReplayConfig config = read_replay_config(write_files(folder));
  const Recording recording = read_recording(config);
  for (const SmootherKind smoother : {SmootherKind::kNone, SmootherKind::kRts}) {
    ReplayOptions options = replay_options(config);
    options.smoother = smoother;
    const Replay whole = replay(recording, options);
    const StateLayout& layout = whole.filtered.solution.layout();
    Solution filtered(layout, whole.log.world), smoothed(layout, whole.log.world);
    options.streams = {.filtered = into(filtered), .smoothed = into(smoothed), .scratch = folder.path()};
    const Replay run = replay(recording, options);
    filtered.innovations = run.filtered.solution.innovations;
    EXPECT_TRUE(numbers(filtered) == numbers(whole.filtered.solution));
    EXPECT_EQ(run.filtered.epochs, whole.filtered.solution.size());
    const Solution& kept = run.solution();
    ASSERT_GT(kept.size(), 2U);
    EXPECT_LE(kept.size(), kKeptRows);
    EXPECT_EQ(kept.time(0), filtered.time(0));
    EXPECT_EQ(kept.time(kept.size() - 1), filtered.time(filtered.size() - 1));
    if (whole.smoothed) {
      smoothed.innovations = run.smoothed->innovations;
      EXPECT_TRUE(numbers(smoothed) == numbers(*whole.smoothed));
      EXPECT_EQ(run.smoothed->attitude_correlation_time, whole.smoothed->attitude_correlation_time);
      const auto residual = [](const Replay& r) {
        return judge(r.log, r.options, r.filtered.solution, &*r.smoothed, r.residuals).sources[0].smoothed;
      };
      EXPECT_GT(residual(run), 0);
      EXPECT_EQ(residual(run), residual(whole));
    }
    for (const auto& entry : std::filesystem::directory_iterator(folder.path())) {
      EXPECT_FALSE(entry.path().filename().string().ends_with(".partial")) << entry.path();
    }
  }

  const Replay whole = replay(recording, replay_options(config));
  const Log apart = condition(Recording(recording), config.conditioning);
  ASSERT_EQ(apart.imu.size(), whole.log.imu.size());
  for (std::size_t i = 0; i < apart.imu.size(); ++i) ASSERT_EQ(apart.imu[i].dvel, whole.log.imu[i].dvel);
}

// Once the heading is known, and until the filter's last sample comes, a live one sees what the replay does.
TEST(Replay, IsWhatAFilterSaysThatIsFedSampleBySample) {
  const Replay& run = usual_replay();
  const Log& log = run.log;
  ASSERT_LT(run.found.start.time, log.imu.front().time) << "the whole log is filtered";
  Filter filter(run.options, log.world, run.found.start);
  std::vector<std::size_t> gnss(log.gnss.size()), attitude(log.attitude.size());
  std::size_t row = 0;
  const auto compare = [&] {
    const Estimate x = run.filtered.solution.estimate(row);
    if (run.filtered.solution.time(row) <= *run.found.aligned + kSameInstant) return void(++row);  // it looks back
    EXPECT_EQ(filter.time(), run.filtered.solution.time(row++));
    EXPECT_TRUE(filter.estimate().p_wb == x.p_wb && filter.estimate().q_wb.coeffs() == x.q_wb.coeffs());
  };
  for (const ImuSample& sample : log.imu) {
    const auto feed = [&](const auto& sources, std::vector<std::size_t>& next) {
      for (std::size_t i = 0; i < sources.size(); ++i) {
        while (next[i] < sources[i].size() && sources[i][next[i]].time <= sample.time) {
          filter.add(static_cast<int>(i), sources[i][next[i]++]);
        }
      }
    };
    feed(log.gnss, gnss);
    feed(log.attitude, attitude);
    if (filter.add(sample)) compare();
  }
  if (filter.finish()) compare();
  EXPECT_EQ(row, run.filtered.solution.size());
}

TEST(Replay, StartsFromEverySourceOfTheHeading) {
  const Case& c = the_case();
  const auto heading_at = [&](double time) { return to_euler(c.simulation.bodies[0].at(time).q_wb).z(); };
  const std::map<std::string, InitialHeading> sources = {
      {"motion", {}},
      {"attitude", {.source = Source::kAttitude}},
      {"magnet", {.source = Source::kMagnetometer, .sigma = 3 * kDegree}},
      {"configuration", {Source::kValue, heading_at(c.simulation.plate.start_time()) + 2 * kDegree, 2 * kDegree}}};
  for (const auto& [word, heading] : sources) {
    ReplayOptions options = usual_options();
    options.heading = heading;
    const Replay run = replay_with(options);
    EXPECT_TRUE(contains(run.found.how, word));
    const Solution& solution = run.solution();
    for (const std::size_t row : {solution.size() / 3, solution.size() - 1}) {
      const double found = to_euler(solution.estimate(row).q_wb).z();
      const double error = std::remainder(found - heading_at(solution.time(row)), 360 * kDegree);
      EXPECT_LT(std::abs(error), 4 * solution.sigmas(row).euler.z()) << word;
      EXPECT_LT(solution.sigmas(row).euler.z(), 2 * kDegree) << word;
    }
  }
}

TEST(Replay, TakesAStartThatIsKnown) {
  ReplayOptions options = usual_options();
  options.relinearisations = 0;  // in which a start that was found counts less than one that is known
  const Replay found = replay_with(options);
  options.start = usual_replay().found.start;
  options.heading = {.source = Source::kMagnetometer};  // not asked
  const Replay given = replay_with(options);
  EXPECT_EQ(given.found.how, "the start was given");
  EXPECT_TRUE(numbers(given.solution()) == numbers(found.solution()));
}

TEST(Replay, WithoutSmootherCanStillBeSmoothed) {
  const Replay& whole = usual_replay();
  ReplayOptions options = usual_options();
  options.smoother = SmootherKind::kNone;
  const Replay run = replay_with(options);
  EXPECT_FALSE(run.smoothed);
  EXPECT_EQ(&run.solution(), &run.filtered.solution);
  EXPECT_EQ(&whole.solution(), &*whole.smoothed);
  int seen = 0;
  const FilterRun again = relinearised(run.log, run.options, without_alignment(run.log.world, run.found), run.filtered);
  smooth_rows(again, {1500}, [&](std::size_t row, const FilterState&, const SmoothedState& smoothed) {
    ++seen;
    EXPECT_TRUE(smoothed.x.p_wb == whole.smoothed->estimate(row).p_wb);
  });
  EXPECT_EQ(seen, 1);

  options.start = whole.found.start;
  options.longest = 12;
  const Replay early = replay_with(options);
  const double last = early.solution().time(early.solution().size() - 1);
  EXPECT_NEAR(last, early.found.start.time + 12, 0.02);
}

TEST(Replay, TellsHowFarItIs) {
  std::vector<std::string> stages;
  std::size_t before = 0;
  ReplayOptions options = usual_options();
  options.start = usual_replay().found.start;
  const Replay run = replay(the_case().simulation.recording(0), options,
                            [&](std::string_view stage, std::size_t done, std::size_t all) {
                              if (done == 0) {
                                stages.emplace_back(stage);
                              } else {
                                EXPECT_GE(done, before);
                              }
                              EXPECT_LE(done, all);
                              before = done;
                            });
  EXPECT_EQ(stages, (std::vector<std::string>{"filter", "relinearising", "smoother"}));
  EXPECT_GT(before, run.log.imu.size() / 2);
}

TEST(Replay, SaysWhatIsMissing) {
  const auto message = [&](const auto& change) {
    ReplayOptions options = usual_options();
    change(options);
    return message_of<Error>([&] { replay_with(options); });
  };
  EXPECT_TRUE(contains(message([&](auto& o) { o.conditioning.imu.clock_offset += 1000; }), "no time in common"));
  EXPECT_TRUE(contains(message([&](auto& o) {
                         o.conditioning.span = {0, the_case().under_way() - 2};
                       }),
                       "heading cannot be"));
  EXPECT_TRUE(contains(message([&](auto& o) { o.filter.gnss.pop_back(); }), "gnss: options of 1 sources for 2"));
  EXPECT_TRUE(contains(message([&](auto& o) { o.filter.attitude.clear(); }), "attitude: options of 0 sources for 1"));
}

// Monte Carlo certifies the chain that a user runs, who knows of the reference attitude how long its errors last.
TEST(Replay, IsWhatATrialRuns) {
  Scenario s = suite_scenario("ski_l1l2_attitude");
  shorten(s, 25, 20, 1);
  s.replay.heading = ReplaySetup::Heading::kAuto;
  make_half_white(s.attitude.at(s.replay.attitude.at(0)));
  const std::uint64_t seed = 5;
  const ComparedRun trial = run_trial(s, seed);

  const Simulation simulation = simulate(s, seed);
  const double departure = simulation.plate.under_way().start;
  const std::size_t imu = s.replay.imu, gnss = s.replay.gnss.at(0), attitude = s.replay.attitude.at(0);
  Recording recording = simulation.recording(imu);
  recording.gnss = {recording.gnss[gnss]};
  recording.attitude = {recording.attitude[attitude]};
  ReplayOptions options;
  options.filter.sensor = s.replay.sensor;
  options.filter.estimate = s.replay.estimate;
  options.filter.gnss = {
      {.name = s.gnss[gnss].name, .lever_arm = lever_arm(s.imus[imu], s.gnss[gnss]), .drift = std::nullopt}};
  options.filter.attitude = {{.name = s.attitude[attitude].name,
                              .drift = GaussMarkov{Vector3d::Zero(), s.attitude[attitude].drift->correlation_time}}};
  options.conditioning.imu.clock_offset = s.imus[imu].clock_offset;
  options.conditioning.imu.clock_drift = s.imus[imu].clock_drift;
  options.conditioning.gyro_range = s.replay.sensor.gyro.range;
  options.conditioning.accel_range = s.replay.sensor.accel.range;
  options.conditioning.span = {departure - s.motion.rest_before, departure + s.replay.end};
  const Replay run = replay(recording, options);
  EXPECT_FALSE(run.options.attitude[0].white == AttitudeOptions{}.white) << "it was measured";

  const std::vector<Innovation>& ours = run.filtered.solution.innovations;
  EXPECT_GT(ours.size(), 500U);
  EXPECT_TRUE(std::equal(ours.begin(), ours.end(), trial.innovations.begin(), trial.innovations.end(),
                         [&](const Innovation& a, const Innovation& b) {
                           return a.time - departure == b.time && a.source == b.source && a.nis == b.nis &&
                                  a.residual.head(a.dof) == b.residual.head(b.dof) && a.outcome == b.outcome;
                         }));
}

}  // namespace
}  // namespace piste::test
