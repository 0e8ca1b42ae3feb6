#include "piste/solve/start.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "piste/core/error.h"
#include "piste/math/linear_algebra.h"
#include "piste/model/alignment.h"
#include "piste/model/magnetometer.h"
#include "piste/solve/mounting.h"
#include "piste/solve/rts.h"
#include "stretch.h"

namespace piste {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kWindows[] = {3, 5, 8, 12};   // s of motion to align in, shortest first
constexpr double kHeadingKnown = 4 * kDegree;  // 1-sigma at which an alignment in motion is believed
constexpr double kTiltKnown = 8 * kDegree;
constexpr double kLeastMotion = 1;  // s that a window must hold beyond what is known to be rest
constexpr double kStretch = 40;     // s filtered and smoothed after the alignment
constexpr double kRestLevel = 10;   // s of rest that give the level
// A smoothed covariance becomes the prior of a filter that sees the same stretch again, and would count it twice. Five
// times as large, a fifth is counted again: over 100 runs sigmas are some 5 % small, and the filter keeps most of what
// the stretch foretold. Twice left those of the scales 12 % small.
constexpr double kTempering = 5;
constexpr double kReferenceSigma = 5 * kDegree;  // of a heading from the reference attitude: it is met again
constexpr double kTiltSigma = 2 * kDegree;       // of a level start: loose, the filter sees the same samples again

double log_begin(const Log& log) { return log.imu.front().time - log.imu.front().interval; }

// The receiver that starts the run: the first one that has fixes.
struct Receiver {
  const std::vector<GnssFix>* fixes;
  const GnssOptions* options;
};

Receiver first_receiver(const Log& log, const FilterOptions& options) {
  for (std::size_t i = 0; i < log.gnss.size(); ++i) {
    if (!log.gnss[i].empty()) return {&log.gnss[i], &options.gnss[i]};
  }
  throw DataError("start", "no GNSS fix within the span of the IMU; check the clocks, the span and the outages");
}

struct Rest {
  Interval interval;
  Vector3d mean_rate, mean_force;
};

Rest average(const Log& log, const Interval& interval) {
  Rest rest{interval, Vector3d::Zero(), Vector3d::Zero()};
  double time = 0;
  for (const ImuSample& s : range(log.imu, interval.start, interval.end)) {
    rest.mean_rate += s.dtheta;
    rest.mean_force += s.dvel;
    time += s.interval;
  }
  rest.mean_rate /= time;
  rest.mean_force /= time;
  return rest;
}

// What the gyro reads at rest, from the last rest that ended before t.
GyroBias bias_before(const Log& log, const FilterOptions& options, double t) {
  for (auto rest = log.rest.rbegin(); rest != log.rest.rend(); ++rest) {
    if (rest->start > t - 2) continue;
    const Interval known{rest->start, std::min(rest->end, t)};
    return {average(log, known).mean_rate, options.rest.sigma_rate / std::sqrt(known.end - known.start)};
  }
  return {Vector3d::Zero(), options.sensor.gyro.bias};
}

std::optional<Rest> rest_at(const Log& log, double t, double longest) {
  for (const Interval& r : log.rest) {
    if (r.start <= t + 0.5 && r.end > t + 1) return average(log, {r.start, std::min(r.end, r.start + longest)});
  }
  return std::nullopt;
}

// Rotation that the Earth makes w turn by between two times: R_wb(begin) = carried · R_wb(end) · turned⁻¹.
Quaterniond carry_back(const Log& log, const Quaterniond& q_end, double begin, double end, const Vector3d& bias) {
  const Quaterniond earth = so3_exp((end - begin) * log.world.earth_rate());
  return (earth * q_end * turned(log, begin, end, bias).conjugate()).normalized();
}

// Position and velocity at `t` from the nearest fix, for a known attitude; their sigmas are loose, as the filter sees
// the same fix again.
void place(Start& start, const Receiver& receiver, bool still) {
  const auto& fixes = *receiver.fixes;
  auto fix = std::partition_point(fixes.begin(), fixes.end(), [&](const GnssFix& f) { return f.time < start.time; });
  if (fix == fixes.end()) fix = std::prev(fix);
  const auto agree = [&](const GnssFix& a, const GnssFix& b) {
    const double fastest = still ? 1 : 100;
    return (b.position - a.position).norm() <
           fastest * (b.time - a.time) + 5 * (a.sigma_position + b.sigma_position).norm();
  };
  while (fixes.end() - fix > 2 && !agree(fix[0], fix[1]) && agree(fix[1], fix[2])) ++fix;  // past an outlier
  start.x.lever_arm = receiver.options->lever_arm;
  start.x.p_wb = fix->position - start.x.q_wb * receiver.options->lever_arm;
  start.x.v_wb.setZero();
  if (!still) {
    if (std::next(fix) != fixes.end()) {
      start.x.v_wb = (std::next(fix)->position - fix->position) / (std::next(fix)->time - fix->time);
    }
    if (fix->velocity) {
      start.x.v_wb.head<2>() = fix->velocity->value.head<2>();
      if (fix->velocity->has_down()) start.x.v_wb.z() = fix->velocity->value.z();
    }
    start.x.p_wb -= (fix->time - start.time) * start.x.v_wb;
  }
  const Vector3d sigma = (3 * fix->sigma_position).cwiseMax(1.0);
  start.covariance.topLeftCorner<6, 6>().setZero();
  start.covariance.diagonal().head<6>() << sigma.cwiseAbs2(), Vector3d::Constant(still ? 0.01 : 4.0);
}

// The attitude nearest to q_wb whose down axis lies along `down_b` (body axes, any length). Unlike angles it has no
// singularity where a body axis stands upright.
Quaterniond levelled(const Quaterniond& q_wb, const Vector3d& down_b) {
  return (rotation_between(q_wb * down_b, Vector3d::UnitZ()) * q_wb).normalized();
}

void set_attitude_sigma(Start& start, const Vector3d& sigma) {
  start.covariance.bottomRightCorner<3, 3>() = sigma.cwiseAbs2().asDiagonal();
}

bool estimates(const FilterOptions& options, Block block) {
  return std::find(options.estimate.begin(), options.estimate.end(), block) != options.estimate.end();
}

// Boresight from the first reference attitude near the start, R_rb = R_wrᵀ R_wb.
void set_boresight(Start& start, const Log& log, const FilterOptions& options) {
  if (!estimates(options, Block::kBoresight)) return;
  for (const auto& fixes : log.attitude) {
    const auto fix =
        std::partition_point(fixes.begin(), fixes.end(), [&](const auto& f) { return f.time < start.time; });
    if (fix == fixes.end()) continue;
    const Quaterniond q_wb =
        start.x.q_wb * turned(log, start.time, fix->time, bias_before(log, options, fix->time).value);
    start.x.q_rb = (fix->q_wr.conjugate() * q_wb).normalized();
    return;
  }
}

// Seconds of a window in which the body may move. At rest an unknown gyro bias turns gravity, dead reckoning takes
// that for motion, and a heading comes out of nothing.
double moving_time(const Log& log, const Interval& window) {
  double time = window.end - window.start;
  for (const Interval& r : log.rest)
    time -= std::max(0.0, std::min(r.end, window.end) - std::max(r.start, window.start));
  return time;
}

// The first window in which motion tells the whole attitude.
std::optional<MotionAlignment> first_alignment(const Log& log, const FilterOptions& options, const Receiver& receiver,
                                               double from) {
  const auto& fixes = *receiver.fixes;
  double last_end = -1e300;
  for (std::size_t i = 0; i < fixes.size(); ++i) {
    const double begin = fixes[i].time;
    if (begin < from || begin - last_end < 0.5) continue;
    last_end = begin;
    for (const double length : kWindows) {
      const auto window = range(fixes, begin, begin + length + 1e-6);
      if (window.empty() || window.back().time < begin + length - 1) break;
      if (moving_time(log, {begin, begin + length}) < kLeastMotion) continue;
      const auto imu = range(log.imu, begin, begin + length + 1);
      auto found = align_in_motion(imu, window, *receiver.options, bias_before(log, options, begin),
                                   log.world.gravity(fixes[i].position).value);
      if (!found) continue;
      const Vector3d sigma = found->covariance.diagonal().cwiseSqrt();
      if (sigma.z() < kHeadingKnown && sigma.head<2>().maxCoeff() < kTiltKnown) return found;
    }
  }
  return std::nullopt;
}

// What the smoother of a stretch says of its start, and of the heading at the departure: in between, a heading that no
// fix holds would wander by the gyro's drift. Twice its sigma: a quarter of the information, as the filter sees the
// motion again.
struct Refined {
  SmoothedState start;
  std::optional<HeadingFix> heading;
};

// The end of the rest that the motion ended.
std::optional<std::size_t> row_at_departure(const Log& log, const Solution& stretch, double aligned) {
  for (const Interval& rest : log.rest) {
    if (rest.end < aligned || rest.end > aligned + kWindows[3]) continue;
    std::size_t i = 0;
    while (i + 1 < stretch.size() && stretch.time(i) < rest.end) ++i;
    return i;
  }
  return std::nullopt;
}

Refined refine(const Log& log, const FilterOptions& options, const Start& start, double aligned) {
  const FilterRun run = run_filter(log, options, start, kCheckpointEvery, {}, aligned + kStretch);
  const std::optional<std::size_t> departure = row_at_departure(log, run.solution, aligned);
  Refined refined;
  const auto heading = [&](std::size_t, const Tape::Epoch& epoch, const SmoothedState& s) {
    refined.heading = {epoch.time, s.x.q_wb, 2 * sigmas_of(s.x, run.solution.layout(), s.P).euler.z()};
  };
  smooth_rows(log, run, departure ? std::vector{*departure} : std::vector<std::size_t>{}, heading, &refined.start);
  return refined;
}

// A smoothed covariance, kTempering times as large, but in no direction larger than `prior`, what was known before the
// stretch: by the eigenvalues of the one against the other. Whole, so that what a rest ties together stays tied. A
// state that was known before, such as a random walk at its start, stays known.
Covariance tempered(const Covariance& smoothed, const Covariance& prior) {
  std::vector<int> unknown;
  for (int i = 0; i < prior.rows(); ++i) {
    if (prior(i, i) > 0) unknown.push_back(i);
  }
  const Eigen::MatrixXd before = prior(unknown, unknown), after = smoothed(unknown, unknown);
  const Eigensystem found = eigensystem(after, before);
  const Eigen::MatrixXd axes = before * found.vectors;
  const Eigen::VectorXd part = (kTempering * found.values).cwiseMin(1);
  Covariance out = Covariance::Zero(prior.rows(), prior.cols());
  out(unknown, unknown) = axes * part.asDiagonal() * axes.transpose();
  return out;
}

FoundStart start_from_motion(const Log& log, const FilterOptions& options, const Receiver& receiver, Start start,
                             const std::optional<Rest>& rest) {
  const auto aligned = first_alignment(log, options, receiver, start.time);
  if (!aligned) {
    throw DataError("start",
                    "the heading cannot be found: no stretch of the log changes its horizontal velocity enough "
                    "while GNSS is there; give `initial: {heading: … deg}`, or use from_attitude or from_magnetometer");
  }
  Start moving{aligned->time, {}, Covariance::Identity(9, 9)};
  moving.x.q_wb = aligned->q_wb;
  place(moving, receiver, false);
  moving.x.v_wb = aligned->v_wb;
  set_attitude_sigma(moving, (2 * aligned->covariance.diagonal().cwiseSqrt()).cwiseMax(kTiltSigma));
  set_boresight(moving, log, options);
  const SmoothedState first = refine(log, options, moving, aligned->time).start;

  // Back to the start of the log: by the rest's own mean rate where it is long, as that holds the slow turn of a body
  // too.
  const double carried = aligned->time - start.time;
  GyroBias bias = bias_before(log, options, aligned->time);
  const Sigmas known = sigmas_of(first.x, StateLayout(options.estimate), first.P);
  if (bias.sigma > known.gyro_total_bias.norm()) {
    bias = {first.x.gyro_bias + first.x.gyro_drift, known.gyro_total_bias.norm()};
  }
  const Quaterniond q_back = carry_back(log, first.x.q_wb, start.time, aligned->time, bias.value);
  start.x.q_wb = rest ? levelled(q_back, -rest->mean_force) : q_back;
  place(start, receiver, rest.has_value());
  if (!rest) start.x.v_wb = aligned->time - start.time < 1 ? aligned->v_wb : start.x.v_wb;
  const double walk = options.sensor.gyro.noise * std::sqrt(carried);
  const double turn = std::sqrt(first.P(8, 8));  // about w's down axis
  const double heading_sigma = std::clamp(std::hypot(2 * turn, walk, bias.sigma * carried), 2 * kDegree, 15 * kDegree);
  set_attitude_sigma(start, {kTiltSigma, kTiltSigma, heading_sigma});
  set_boresight(start, log, options);

  // A second stretch, from the start itself.
  const Refined refined = refine(log, options, start, aligned->time);
  start.covariance = tempered(refined.start.P, initial_covariance(StateLayout(options.estimate), options, start));
  start.x = refined.start.x;
  start.heading = refined.heading;
  const double sigma = euler_sigma(start.x.q_wb, start.covariance.block<3, 3>(6, 6)).z();
  return {start, fmt::format("heading {:.1f} deg ± {:.2f}, found from the motion at t = {:.1f} s",
                             to_euler(start.x.q_wb).z() / kDegree, sigma / kDegree, aligned->time)};
}

// Attitude at the start, the 1-sigma of its heading, and how it was found.
struct Pointing {
  Quaterniond q_wb;
  double sigma;
  std::string how;
};

// Throws where gravity says that b does not sit as `q_wb` has it.
void check_small_boresight(const Quaterniond& q_wb, const Rest& rest, const Priors& priors) {
  const Vector3d down = q_wb * -rest.mean_force;
  const double tilt = std::atan2(down.head<2>().norm(), down.z());
  if (tilt <= 3 * std::numbers::sqrt2 * priors.boresight) return;
  throw DataError("start",
                  fmt::format("the boresight cannot be found: the body does not turn about two axes, and gravity says "
                              "that it sits some {:.0f} deg off the reference; add a stretch of motion, or bring both "
                              "nearly together by `axes`",
                              tilt / kDegree));
}

// From the first fix of the reference, and how b sits against it.
Pointing point_by_reference(const Log& log, const FilterOptions& options, const Start& start,
                            const std::optional<Rest>& rest) {
  const auto fixes = std::find_if(log.attitude.begin(), log.attitude.end(), [](const auto& a) { return !a.empty(); });
  if (fixes == log.attitude.end())
    throw DataError("start", "from_attitude needs an attitude log that overlaps the IMU");
  const auto next = std::find_if(fixes->begin(), fixes->end(), [&](const auto& f) { return f.time >= start.time; });
  const AttitudeFix& fix = next == fixes->end() ? fixes->back() : *next;
  GyroBias bias = bias_before(log, options, fix.time);
  Pointing p{Quaterniond::Identity(), kReferenceSigma, "heading from the reference attitude"};
  if (estimates(options, Block::kBoresight)) {
    if (const auto mounting = find_mounting(log)) {
      const Vector3d down_r = fix.q_wr.conjugate() * Vector3d::UnitZ();
      p.q_wb = mounting->q_rb;
      p.sigma = std::hypot(p.sigma, 2 * std::sqrt(down_r.dot(mounting->covariance * down_r)));
      p.how += ", through the boresight that the rates of both tell";
      bias.value = mounting->gyro_bias;
    } else {
      // Small, as the prior says; the heading itself knows nothing beyond.
      p.sigma = 3 * options.priors.boresight;
      p.how += ", the boresight taken for small";
    }
  }
  const double lapse = std::max(0.0, fix.time - start.time);
  p.q_wb = carry_back(log, fix.q_wr * p.q_wb, fix.time - lapse, fix.time, bias.value);
  p.sigma = std::hypot(p.sigma, lapse * bias.sigma);
  if (!rest) return p;
  if (p.sigma >= 3 * options.priors.boresight) check_small_boresight(p.q_wb, *rest, options.priors);
  p.q_wb = levelled(p.q_wb, -rest->mean_force);
  return p;
}

// From a heading that is given, or the magnetometer's, and level.
Pointing point_by_heading(const Log& log, const FilterOptions& options, const Receiver& receiver, const Start& start,
                          const InitialHeading& heading, const std::optional<Rest>& rest) {
  const Vector3d force = rest ? rest->mean_force : average(log, {start.time, start.time + 1}).mean_force;
  double value = heading.value;
  Pointing p{Quaterniond::Identity(), heading.sigma, "heading from the configuration"};
  if (heading.source == InitialHeading::Source::kMagnetometer) {
    if (log.magnetic.empty())
      throw DataError("start", "from_magnetometer needs the columns mag_x_uT, mag_y_uT, mag_z_uT in the IMU log");
    value = options.declination - magnetic_azimuth(level(force, 0), log.magnetic.front().field);
    p.sigma = std::hypot(heading.sigma, 2 * kTiltSigma);  // a tilt turns the field of a dip of 60 deg by twice as much
    p.how = "heading from the magnetometer";
  }
  p.q_wb = level(force, value);
  if (rest) return p;
  // Level on the move: gravity and the acceleration of the first seconds, heading as given.
  const auto window = range(*receiver.fixes, start.time, start.time + kWindows[0]);
  const auto moving =
      align_in_motion(range(log.imu, start.time, start.time + kWindows[0] + 1), window, *receiver.options,
                      bias_before(log, options, start.time), log.world.gravity(receiver.fixes->front().position).value);
  if (moving) {
    const Vector3d euler = to_euler(moving->q_wb);
    p.q_wb = from_euler({euler.x(), euler.y(), value});
  }
  return p;
}

}  // namespace

FoundStart find_start(const Log& log, const FilterOptions& options, const InitialHeading& heading) {
  if (log.imu.empty()) throw DataError("start", "the log holds no IMU sample");
  const Receiver receiver = first_receiver(log, options);
  Start start;
  start.time = log_begin(log);
  std::optional<Rest> rest = rest_at(log, start.time, kRestLevel);
  if (!rest && receiver.fixes->front().time > start.time) {
    start.time = receiver.fixes->front().time;  // already moving: nothing is known before the first fix
    rest = rest_at(log, start.time, kRestLevel);
  }
  using Source = InitialHeading::Source;
  if (heading.source == Source::kAuto) return start_from_motion(log, options, receiver, start, rest);

  const Pointing pointing = heading.source == Source::kAttitude
                                ? point_by_reference(log, options, start, rest)
                                : point_by_heading(log, options, receiver, start, heading, rest);
  start.x.q_wb = pointing.q_wb;
  place(start, receiver, rest.has_value());
  const double tilt = rest ? kTiltSigma : 5 * kTiltSigma;
  set_attitude_sigma(start, {tilt, tilt, pointing.sigma});
  set_boresight(start, log, options);
  return {start, pointing.how};
}

}  // namespace piste
