// What must not change an answer. A short simulated run of a random motion, place and heading is replayed as it is, and
// turned, moved, mirrored, at another time, with other axes, units and order of its rows: the answer is the same one,
// transformed, to a thousandth of its sigma.
//
// The Earth has these symmetries itself: every longitude is like every other, the south is the mirror image of the
// north, and at a pole every heading is like every other. So nothing but rounding may differ, except where a fix lies
// so near its gate that rounding decides. Such runs are counted, one in a hundred at most.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "math/gps_time.h"
#include "piste/io/log_io.h"
#include "piste/replay/replay.h"
#include "support/random.h"
#include "support/simulated_case.h"
#include "support/solutions_apart.h"
#include "support/thorough.h"

namespace piste::test {
namespace {

constexpr double kWeekEnd = 604800, kPole = std::numbers::pi / 2;
constexpr double kRest = 5, kRun = 12;        // of each run [s]
constexpr double kBesidePole = kPole - 2e-4;  // 1.3 km, so that each row has a longitude

/// A run with its recording, which a property transforms.
struct Drawn {
  Case run;
  Recording recording;
  InitialHeading heading = {};
};

Drawn draw(Random& random, std::uint64_t seed, std::optional<double> latitude = {}) {
  constexpr std::array kMotions{"ski", "giant_slalom", "bicycle"};
  const double heading = 360 * random.uniform() - 180;
  Drawn drawn{.run = make_case(kMotions[seed % kMotions.size()], heading, seed,
                               [&](Scenario& s) {
                                 s.origin.latitude = latitude.value_or((160 * random.uniform() - 80) * kDegree);
                                 s.origin.longitude = (360 * random.uniform() - 180) * kDegree;
                                 s.motion.net_turn *= kRun / s.motion.run;
                                 s.motion.rest_before = kRest;
                                 s.motion.run = kRun;
                                 s.motion.rest_after = 1;
                               }),
              .recording = {}};
  drawn.recording = drawn.run.simulation.recording(0);
  return drawn;
}

Replay replayed(const Drawn& drawn) {
  return replay(drawn.recording,
                {.conditioning = drawn.run.conditioning, .filter = drawn.run.options, .heading = drawn.heading});
}

/// Whether all fixes were judged alike, in whatever order those of one instant came.
bool judged_alike(const Solution& a, const Solution& b) {
  const auto judged = [](const Solution& s) {
    std::vector<std::tuple<double, int, Outcome>> all;
    for (const Innovation& v : s.innovations) all.emplace_back(v.time - s.innovations[0].time, v.source, v.outcome);
    std::ranges::sort(all);
    return all;
  };
  constexpr double kOneInstant = 1e-4;
  return std::ranges::equal(judged(a), judged(b), [](const auto& v, const auto& w) {
    return std::abs(std::get<0>(v) - std::get<0>(w)) < kOneInstant && std::get<1>(v) == std::get<1>(w) &&
           std::get<2>(v) == std::get<2>(w);
  });
}

/// Runs a property on its cases, and prints how far the answers were apart.
class Properties : public testing::Test {
 protected:
  double same_ = 1e-3;  // of a sigma
  static constexpr int kUsual = 100;

  void each(const std::function<void(Random&, std::uint64_t)>& property) {
    const SeedRange seeds = property_seeds(kUsual);
    const int cases = seeds.size();
    for (int seed = seeds.first; seed <= seeds.last; ++seed) {
      SCOPED_TRACE(fmt::format("seed {}", seed));
      Random random(static_cast<std::uint64_t>(seed));
      property(random, static_cast<std::uint64_t>(seed));
    }
    fmt::print("{} cases, {} near a gate: values {:.1e} sigma apart, sigmas {:.1e} of themselves\n", cases, near_gate_,
               most_.value, most_.sigma);
    EXPECT_LE(near_gate_, cases / 100) << "runs in which a fix was judged otherwise";
  }

  void expect_same(
      const Replay& is, const Replay& wanted, const TurnBack& back = [](Navigation&, Estimate&) {}) {
    ASSERT_GT(wanted.smoothed->size(), 500U);
    if (!judged_alike(is.filtered.solution, wanted.filtered.solution)) {
      ++near_gate_;
      return;
    }
    expect_near("filtered", apart(is.filtered.solution, wanted.filtered.solution, back));
    expect_near("smoothed", apart(*is.smoothed, *wanted.smoothed, back));
  }

 private:
  void expect_near(const char* what, const Apart& a) {
    EXPECT_LT(a.value, same_) << what;
    EXPECT_LT(a.sigma, same_) << what;
    most_.value = std::max(most_.value, a.value);
    most_.sigma = std::max(most_.sigma, a.sigma);
  }

  int near_gate_ = 0;
  Apart most_;
};

// At a pole the world may be turned about the vertical. North turns with it, so that the answer is on another
// longitude.
TEST_F(Properties, HeadingOfTheWorld) {
  each([&](Random& random, std::uint64_t seed) {
    Drawn drawn = draw(random, seed, kBesidePole);
    const ReplayOptions options{.filter = drawn.run.options};
    const World pole({kPole, 0, drawn.run.scenario.origin.height});
    const Log log = condition(drawn.recording, drawn.run.conditioning, pole);
    const double angle = std::numbers::pi * (2 * random.uniform() - 1);
    const Matrix3d turn = so3_exp(Vector3d(0, 0, angle)).toRotationMatrix();
    Log turned = log;
    for (GnssFix& fix : turned.gnss[0]) {
      fix.position = turn * fix.position;
      fix.velocity->value = turn * fix.velocity->value;
    }
    // Along w, south at longitude 0 is −x, and longitudes grow against headings.
    expect_same(replay(turned, options), replay(log, options),
                [&](Navigation& x, Estimate&) { x.position.longitude += angle; });
  });
}

// Another longitude is another origin, 900 km and more away.
TEST_F(Properties, OriginFarAway) {
  each([&](Random& random, std::uint64_t seed) {
    Drawn drawn = draw(random, seed);
    const Replay wanted = replayed(drawn);
    const double east = 0.2 + random.uniform();
    for (GeodeticFix& fix : drawn.recording.gnss[0].fixes) {
      fix.position.longitude = std::remainder(fix.position.longitude + east, 2 * std::numbers::pi);
    }
    expect_same(replayed(drawn), wanted, [&](Navigation& x, Estimate&) { x.position.longitude -= east; });
  });
}

// The mirror image of a polar vector has its north the other way, that of an axial one its east and down. In the body,
// it is the axis to the right.
constexpr std::array kPolar{1.0, -1.0, 1.0}, kAxial{-1.0, 1.0, -1.0};

void mirror(Drawn& drawn) {
  const Vector3d polar(kPolar.data()), axial(kAxial.data());
  for (Vector3d& rate : drawn.recording.imu.gyro) rate = axial.cwiseProduct(rate);
  for (Vector3d& force : drawn.recording.imu.accel) force = polar.cwiseProduct(force);
  for (GeodeticFix& fix : drawn.recording.gnss[0].fixes) {
    fix.position.latitude *= -1;
    fix.velocity->value.x() *= -1;
  }
  Vector3d& arm = drawn.run.options.gnss[0].lever_arm;
  arm = polar.cwiseProduct(arm);
}

void mirror_back(Navigation& n, Estimate& x) {
  n.position.latitude *= -1;
  n.velocity.x() *= -1;
  n.euler = Vector3d(-n.euler.x(), n.euler.y(), std::numbers::pi - n.euler.z());
  const Vector3d polar(kPolar.data()), axial(kAxial.data());
  for (Vector3d* error : {&x.gyro_bias, &x.gyro_drift}) *error = axial.cwiseProduct(*error);
  for (Vector3d* error : {&x.accel_bias, &x.accel_drift}) *error = polar.cwiseProduct(*error);
}

TEST_F(Properties, OtherHemisphere) {
  each([&](Random& random, std::uint64_t seed) {
    Drawn drawn = draw(random, seed);
    const Replay wanted = replayed(drawn);
    mirror(drawn);
    expect_same(replayed(drawn), wanted, mirror_back);
  });
}

/// One of the 24 right-handed signed permutations of the axes.
Matrix3d any_axes(Random& random) {
  const Quaterniond quarter_x(std::sqrt(0.5), std::sqrt(0.5), 0, 0), quarter_y(std::sqrt(0.5), 0, std::sqrt(0.5), 0);
  Quaterniond q = Quaterniond::Identity();
  for (int i = 0; i < 12; ++i) q = q * (random.uniform() < 0.5 ? quarter_x : quarter_y);
  return q.toRotationMatrix().array().round();
}

TEST_F(Properties, AxesOfTheSensor) {
  each([&](Random& random, std::uint64_t seed) {
    Drawn drawn = draw(random, seed);
    const Replay wanted = replayed(drawn);
    const Matrix3d R_bs = any_axes(random);
    drawn.run.conditioning.imu.R_bs = R_bs;
    for (Vector3d& rate : drawn.recording.imu.gyro) rate = R_bs.transpose() * rate;
    for (Vector3d& force : drawn.recording.imu.accel) force = R_bs.transpose() * force;
    expect_same(replayed(drawn), wanted);
  });
}

/// The recording, read from the texts of its files.
Recording read(const std::string& imu, const std::string& gnss, bool repair = false) {
  Recording recording;
  recording.imu = read_imu({.file = "imu.csv", .content = imu, .repair = repair});
  recording.gnss = {read_gnss({.file = "gnss.csv", .content = gnss, .repair = repair})};
  return recording;
}

Recording as_text(const Recording& recording) { return read(imu_csv(recording.imu), gnss_csv(recording.gnss[0])); }

// So that the week ends within the run; the files begin it anew with 0 s.
TEST_F(Properties, ShiftOfTime) {
  each([&](Random& random, std::uint64_t seed) {
    Drawn drawn = draw(random, seed);
    const Recording as_it_is = drawn.recording;
    drawn.recording = as_text(as_it_is);
    const Replay wanted = replayed(drawn);
    const double begin = as_it_is.gnss[0].fixes.front().time;
    const double shift = std::floor(kWeekEnd - begin - (kRest + kRun) * random.uniform());
    Recording later = as_it_is;
    for (double& time : later.imu.time) time += shift - (time + shift >= kWeekEnd ? kWeekEnd : 0);
    for (GeodeticFix& fix : later.gnss[0].fixes) fix.time += shift - (fix.time + shift >= kWeekEnd ? kWeekEnd : 0);
    drawn.recording = as_text(later);
    expect_same(replayed(drawn), wanted);
  });
}

/// The rows of a text with the first column as UTC, which counts no leap seconds. Its instants are those of a GPS week.
std::string in_utc(const std::string& text, int week) {
  std::istringstream in(text);
  std::string header, out, row;
  std::getline(in, header);
  out = "utc" + header.substr(header.find(',')) + "\n";
  while (std::getline(in, row)) {
    const auto comma = row.find(',');
    out += utc_text({week, std::stod(row.substr(0, comma))}) + row.substr(comma) + "\n";
  }
  return out;
}

ColumnMap columns_in_utc(std::map<std::string, ColumnUse, std::less<>> uses) {
  return {.time = {.name = "utc", .unit = "calendar", .of = TimeScale::kUtc}, .uses = std::move(uses)};
}

// A leap second within the run, which UTC has and GPS time has not: that of the last day of 2016.
TEST_F(Properties, LeapSecond) {
  constexpr int kWeek = 1930;
  constexpr double kLeap = 17;  // of that week, which began with 2017 in GPS time
  const ColumnMap imu_columns =
      columns_in_utc({{"gyro", {.names = {"gyro_x_rad_s", "gyro_y_rad_s", "gyro_z_rad_s"}, .unit = "rad/s"}},
                      {"accel", {.names = {"accel_x_m_s2", "accel_y_m_s2", "accel_z_m_s2"}, .unit = "m/s^2"}}});
  const auto three = [](const std::string& before, const std::string& after) {
    return std::vector<std::string>{before + "north" + after, before + "east" + after, before + "down" + after};
  };
  const ColumnMap gnss_columns =
      columns_in_utc({{"latitude", {.names = {"latitude_deg"}, .unit = "deg"}},
                      {"longitude", {.names = {"longitude_deg"}, .unit = "deg"}},
                      {"height", {.names = {"height_m"}, .unit = "m"}},
                      {"sigma", {.names = three("sigma_", "_m"), .unit = "m"}},
                      {"velocity", {.names = three("velocity_", "_m_s"), .unit = "m/s"}},
                      {"sigma_velocity", {.names = three("sigma_velocity_", "_m_s"), .unit = "m/s"}}});
  each([&](Random& random, std::uint64_t seed) {
    Drawn drawn = draw(random, seed);
    // So long after the week's beginning that the leap second is within the run.
    const double shift = std::floor(kLeap - (kRest + kRun) * random.uniform()) - drawn.recording.gnss[0].fixes[0].time;
    for (double& time : drawn.recording.imu.time) time += shift;
    for (GeodeticFix& fix : drawn.recording.gnss[0].fixes) fix.time += shift;
    const std::string imu = imu_csv(drawn.recording.imu), gnss = gnss_csv(drawn.recording.gnss[0]);
    drawn.recording = read(imu, gnss);
    const Replay wanted = replayed(drawn);
    const std::string imu_utc = in_utc(imu, kWeek), gnss_utc = in_utc(gnss, kWeek);
    ASSERT_NE(gnss_utc.find("T23:59:60."), std::string::npos);
    drawn.recording.imu =
        read_imu({.file = "imu.txt", .format = LogFormat::kColumns, .content = imu_utc, .columns = imu_columns});
    drawn.recording.gnss = {
        read_gnss({.file = "gnss.txt", .format = LogFormat::kColumns, .content = gnss_utc, .columns = gnss_columns})};
    expect_same(replayed(drawn), wanted);
  });
}

/// A log of rates with 17 digits, multiplied by the factors that its units need.
std::string in_units(const ImuRecording& imu, const char* units, double rate, double force) {
  std::string text = fmt::format("time_s,gyro_x_{0},gyro_y_{0},gyro_z_{0},accel_x_{1},accel_y_{1},accel_z_{1}\n",
                                 std::string_view(units).substr(0, std::string_view(units).find(' ')),
                                 std::string_view(units).substr(std::string_view(units).find(' ') + 1));
  for (std::size_t i = 0; i < imu.time.size(); ++i) {
    const Vector3d w = rate * imu.gyro[i], f = force * imu.accel[i];
    text += fmt::format("{:.6f},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g},{:.17g}\n", imu.time[i], w.x(), w.y(), w.z(),
                        f.x(), f.y(), f.z());
  }
  return text;
}

TEST_F(Properties, UnitsOfTheLog) {
  each([&](Random& random, std::uint64_t seed) {
    Drawn drawn = draw(random, seed);
    const ImuRecording imu = drawn.recording.imu;
    const std::string gnss = gnss_csv(drawn.recording.gnss[0]);
    drawn.recording = read(in_units(imu, "rad_s m_s2", 1, 1), gnss);
    const Replay wanted = replayed(drawn);
    drawn.recording = read(in_units(imu, "deg_s g", 1 / kDegree, 1 / kStandardGravity), gnss);
    expect_same(replayed(drawn), wanted);
  });
}

// Of two receivers either may be named first. Their fixes have the same times, and each is taken about the state that
// the one before has left: a second order of the errors differs.
TEST_F(Properties, OrderOfTheFiles) {
  same_ = 1e-2;
  each([&](Random& random, std::uint64_t seed) {
    Drawn drawn = draw(random, seed);
    GnssRecording other = drawn.recording.gnss[0];
    for (GeodeticFix& fix : other.fixes) {
      fix.position.height += random.gaussian(3);
      fix.sigma_position.setConstant(3);
      fix.velocity.reset();
    }
    GnssOptions one = drawn.run.options.gnss[0], two = one;
    two.name = "other";
    drawn.recording.gnss = {drawn.recording.gnss[0], other};
    drawn.run.options.gnss = {one, two};
    const Replay wanted = replayed(drawn);
    std::swap(drawn.recording.gnss[0], drawn.recording.gnss[1]);
    drawn.run.options.gnss = {two, one};
    Replay is = replayed(drawn);
    for (Innovation& v : is.filtered.solution.innovations) {
      if (v.source < 4) v.source = (v.source + 2) % 4;  // positions and velocities of each receiver, then rest
    }
    expect_same(is, wanted);
  });
}

/// The text with every few rows exchanged with one of the next five; some rows stand there twice.
std::string disordered(const std::string& text, Random& random) {
  std::istringstream in(text);
  std::string header;
  std::getline(in, header);
  std::vector<std::string> rows;
  for (std::string row; std::getline(in, row);) rows.push_back(row);
  std::string out = header + "\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto other = std::min(i + static_cast<std::size_t>(5 * random.uniform()), rows.size() - 1);
    if (random.uniform() < 0.2) std::swap(rows[i], rows[other]);
    out += rows[i] + "\n";
    if (random.uniform() < 0.02) out += rows[i] + "\n";
  }
  return out;
}

// What was put in order is what was in order: the recordings are equal, and so their replays.
TEST_F(Properties, OrderOfTheRows) {
  const SeedRange seeds = property_seeds(kUsual);
  Random random(static_cast<std::uint64_t>(seeds.first));
  const Drawn drawn = draw(random, 1);
  const std::string imu = imu_csv(drawn.recording.imu), gnss = gnss_csv(drawn.recording.gnss[0]);
  const Recording wanted = read(imu, gnss);
  for (int i = 0; i < seeds.size(); ++i) {
    const Recording is = read(disordered(imu, random), disordered(gnss, random), true);
    EXPECT_GT(is.imu.repaired.sorted, 50U);
    EXPECT_GT(is.imu.repaired.dropped, 5U);
    ASSERT_EQ(is.imu.time, wanted.imu.time);
    ASSERT_EQ(is.imu.gyro, wanted.imu.gyro);
    ASSERT_EQ(is.imu.accel, wanted.imu.accel);
    ASSERT_EQ(is.gnss[0].fixes.size(), wanted.gnss[0].fixes.size());
    EXPECT_TRUE(std::ranges::equal(is.gnss[0].fixes, wanted.gnss[0].fixes, [](const auto& a, const auto& b) {
      return a.time == b.time && a.position.latitude == b.position.latitude &&
             a.position.longitude == b.position.longitude && a.position.height == b.position.height &&
             a.sigma_position == b.sigma_position && a.velocity->value == b.velocity->value;
    }));
  }
}

}  // namespace
}  // namespace piste::test
