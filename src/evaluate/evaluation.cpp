#include "piste/evaluate/evaluation.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "evaluate/path.h"
#include "evaluate/time_offset.h"
#include "io/text_reader.h"
#include "math/linear_algebra.h"
#include "math/time.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr std::array<std::string_view, kNavigationErrors> kErrorNames{
    "north_m",           "east_m",   "down_m",    "velocity_north_m_s", "velocity_east_m_s",
    "velocity_down_m_s", "roll_deg", "pitch_deg", "heading_deg"};

// The value at a part of the way from the least to the largest, linear between neighbours. @pre ascending, not empty
double quantile_of(const std::vector<double>& sorted, double part) {
  const double place = part * static_cast<double>(sorted.size() - 1);
  const auto below = static_cast<std::size_t>(place);
  const double next = sorted[std::min(below + 1, sorted.size() - 1)];
  return sorted[below] + (place - static_cast<double>(below)) * (next - sorted[below]);
}

double angle_of(const Quaterniond& q) { return 2 * std::atan2(q.vec().norm(), std::abs(q.w())); }

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

// ---- The epochs that are compared. ----

std::size_t rows_within(const FramedPath& path, double first, double last) {
  const auto& times = path.track().time;
  const double shift = path.first() - times.front();
  const auto from = std::lower_bound(times.begin(), times.end(), first - shift - kSameTime);
  const auto to = std::upper_bound(times.begin(), times.end(), last - shift + kSameTime);
  return from < to ? static_cast<std::size_t>(to - from) : 0;
}

[[noreturn]] void no_overlap(const FramedPath& a, const FramedPath& b) {
  throw DataError(
      a.track().file,
      fmt::format("its times, {:.3f} to {:.3f} s, have none in common with those of {}, {:.3f} to {:.3f} s; "
                  "are both of one run, and in GPS seconds of week? --time-offset shifts the first",
                  a.first(), a.last(), b.track().file, b.first(), b.last()));
}

Epochs epochs_of(const FramedPath& a, const FramedPath& b) {
  const double first = std::max(a.first(), b.first()), last = std::min(a.last(), b.last());
  const std::size_t of_a = rows_within(a, first, last), of_b = rows_within(b, first, last);
  if (of_a == 0 && of_b == 0) no_overlap(a, b);
  const bool by_a = of_b == 0 || (of_a > 0 && of_a <= of_b);  // the sparser file
  const FramedPath &sparse = by_a ? a : b, &dense = by_a ? b : a;
  Epochs epochs;
  for (std::size_t i = 0; i < sparse.size(); ++i) {
    const double time = sparse.time(i);
    if (time < first - kSameTime || time > last + kSameTime) {
      ++epochs.outside;
      continue;
    }
    const auto other = dense.at(time);
    if (!other) {
      ++epochs.in_gaps;
      continue;
    }
    epochs.a.push_back(by_a ? sparse.row(i) : *other);
    epochs.b.push_back(by_a ? *other : sparse.row(i));
    epochs.a.back().time = epochs.b.back().time = time;
  }
  if (epochs.a.empty()) {
    throw DataError(dense.track().file,
                    fmt::format("its rows are more than {:g} s apart wherever {} has one; nothing is interpolated over "
                                "such a gap",
                                kLongestInterpolation, sparse.track().file));
  }
  return epochs;
}

void move(std::vector<FramedRow>& rows, const Similarity& motion) {
  const Quaterniond q(motion.rotation);
  for (FramedRow& row : rows) {
    row.position = motion.scale * (motion.rotation * row.position) + motion.translation;
    row.velocity = motion.scale * (motion.rotation * row.velocity);
    row.attitude = q * row.attitude;
  }
}

// ---- Errors. ----

// The course of the reference at each row, in radians from north: of its velocity, or else of its way. Where it stands,
// that of the row before; at a start, that of the first row under way.
std::vector<double> courses(const std::vector<FramedRow>& rows, bool has_velocity) {
  constexpr double kStands = 0.1;  // m/s: below it the noise of a velocity decides its direction
  std::vector<double> course(rows.size(), kNaN);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const FramedRow &before = rows[i > 0 ? i - 1 : 0], &after = rows[std::min(i + 1, rows.size() - 1)];
    const double dt = after.time - before.time;
    Vector3d v = rows[i].velocity;
    if (!has_velocity) v = dt > 0 ? ((after.position - before.position) / dt).eval() : Vector3d::Zero();
    if (std::hypot(v.x(), v.y()) > kStands) course[i] = std::atan2(v.x(), v.y());
    if (std::isnan(course[i]) && i > 0) course[i] = course[i - 1];
  }
  const auto known = std::find_if(course.begin(), course.end(), [](double c) { return !std::isnan(c); });
  std::fill(course.begin(), known, known == course.end() ? 0 : *known);
  return course;
}

struct Has {
  bool velocity = false, attitude = false, covariance = false;
};

ErrorRow errors_of(const FramedRow& a, const FramedRow& b, double course, const Has& has) {
  ErrorRow row;
  row.time = a.time;
  row.error.fill(kNaN);
  row.sigma.fill(kNaN);
  const Matrix3d R_nf = b.local.transpose();
  const Vector3d position = R_nf * (a.position - b.position);
  std::copy_n(position.data(), 3, row.error.begin());
  if (has.velocity) {
    const Vector3d velocity = R_nf * (a.velocity - b.velocity);
    std::copy_n(velocity.data(), 3, row.error.begin() + 3);
  }
  row.angle = kNaN;
  if (has.attitude) {
    const Vector3d euler_a = to_euler((Quaterniond(R_nf) * a.attitude).normalized()),
                   euler_b = to_euler((Quaterniond(R_nf) * b.attitude).normalized());
    for (std::size_t i = 0; i < 3; ++i) {
      const auto axis = static_cast<Eigen::Index>(i);
      row.error[6 + i] = wrapped(euler_a[axis] - euler_b[axis]);
    }
    row.angle = angle_of(b.attitude.conjugate() * a.attitude);
  }
  for (int i = 0; i < 3; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (a.sigma_position[i] > 0) row.sigma[k] = a.sigma_position[i];
    if (a.sigma_velocity[i] > 0) row.sigma[3 + k] = a.sigma_velocity[i];
    if (a.sigma_euler[i] > 0) row.sigma[6 + k] = a.sigma_euler[i];
  }
  const double c = std::cos(course), s = std::sin(course);
  row.along = c * position.x() + s * position.y();
  row.across = c * position.y() - s * position.x();
  row.up = -position.z();
  row.distance = (a.position - b.position).norm();
  row.nees = kNaN;
  if (has.covariance && has.velocity && has.attitude) {
    const Eigen::Map<const Eigen::Matrix<double, 9, 1>> e(row.error.data());
    const Eigen::VectorXd weighted = solve_symmetric(Eigen::MatrixXd(a.covariance), Eigen::VectorXd(e));
    row.nees = e.dot(weighted) / static_cast<double>(kNavigationErrors);
  }
  return row;
}

RelativeErrors relative_errors(const Epochs& epochs, const RelativeStep& step, bool has_attitude) {
  RelativeErrors found{.step = step};
  std::vector<double> distances, angles;
  double path = 0;
  for (std::size_t i = 0, j = 1; j < epochs.b.size(); ++j) {
    path += (epochs.b[j].position - epochs.b[j - 1].position).norm();
    const bool reached =
        step.is_distance ? path >= step.length : epochs.b[j].time - epochs.b[i].time >= step.length - kSameTime;
    if (!reached) continue;
    const Vector3d way_a = epochs.a[j].position - epochs.a[i].position,
                   way_b = epochs.b[j].position - epochs.b[i].position;
    if (has_attitude) {
      const Quaterniond &ai = epochs.a[i].attitude, &bi = epochs.b[i].attitude;
      // Lengths are those before the rotation (B_i⁻¹ B_j)⁻¹.
      distances.push_back((ai.conjugate() * way_a - bi.conjugate() * way_b).norm());
      angles.push_back(
          angle_of((bi.conjugate() * epochs.b[j].attitude).conjugate() * (ai.conjugate() * epochs.a[j].attitude)));
    } else {
      distances.push_back((way_a - way_b).norm());
    }
    i = j;
    path = 0;
  }
  found.pairs = distances.size();
  if (!distances.empty()) found.distance = error_statistics(distances);
  if (!angles.empty()) found.rotation = error_statistics(angles);
  return found;
}

std::array<double, 3> shares(const std::vector<ErrorRow>& rows, std::size_t error) {
  std::array<double, 3> within{};
  std::size_t count = 0;
  for (const ErrorRow& row : rows) {
    if (std::isnan(row.error[error]) || std::isnan(row.sigma[error])) continue;
    ++count;
    for (std::size_t k = 0; k < 3; ++k) {
      within[k] += std::abs(row.error[error]) <= static_cast<double>(k + 1) * row.sigma[error] ? 1 : 0;
    }
  }
  for (double& share : within) share = count > 0 ? share / static_cast<double>(count) : kNaN;
  return within;
}

void add_statistics(Evaluation& found, const Epochs& epochs) {
  std::vector<double> distances, angles, radii, nees;
  for (const ErrorRow& row : found.rows) {
    distances.push_back(row.distance);
    radii.push_back(std::hypot(row.error[0], row.error[1]));
    if (!std::isnan(row.angle)) angles.push_back(row.angle);
    if (!std::isnan(row.nees)) nees.push_back(row.nees);
  }
  found.ape = error_statistics(distances);
  if (!angles.empty()) found.ape_rotation = error_statistics(angles);
  if (!nees.empty()) found.nees = mean(nees);
  std::sort(radii.begin(), radii.end());
  constexpr double kHalf = 0.5, kMost = 0.95;
  found.cep50 = quantile_of(radii, kHalf);
  found.cep95 = quantile_of(radii, kMost);
  for (const RelativeStep& step : found.options.steps) {
    found.rpe.push_back(relative_errors(epochs, step, !angles.empty()));
  }
  for (std::size_t i = 0; i < kNavigationErrors; ++i) found.within_sigma[i] = shares(found.rows, i);
}

// East, north, up at the reference's first row, or at the track's own if the reference is in other axes.
std::optional<EnuFrame> frame_of(const Trajectory& track, const Trajectory& reference) {
  if (!track.geodetic) return std::nullopt;
  return EnuFrame(reference.geodetic ? reference.place.front() : track.place.front());
}

}  // namespace

std::string_view navigation_error_name(std::size_t error) { return kErrorNames[error]; }

std::string RelativeStep::name() const { return fmt::format("{:g} {}", length, is_distance ? "m" : "s"); }

RelativeStep relative_step(const std::string& text) {
  const std::size_t unit = text.find_first_not_of("0123456789.+-eE ");
  const auto quantity = [&](const Dimension& dimension) -> std::optional<double> {
    if (unit == std::string::npos) return std::nullopt;
    try {
      return std::stod(text.substr(0, unit)) * unit_factor(text.substr(unit), dimension);
    } catch (const std::logic_error&) {  // no number, or a unit of another dimension
      return std::nullopt;
    }
  };
  const auto distance = quantity(dimension::kLength), time = quantity(dimension::kTime);
  const double length = distance ? *distance : time.value_or(0);
  if (!(length > 0)) {
    throw ConfigError("--rpe", fmt::format("`{}` is no step; right would be a distance such as 100m or a time such as "
                                           "1s",
                                           text));
  }
  return {length, distance.has_value()};
}

void set_time_offset(EvaluationOptions& options, const std::string& text) {
  options.find_offset = text == "auto";
  if (options.find_offset) return;
  const auto seconds = number_in(text, TextReader::Separator::kComma);
  if (!seconds || !std::isfinite(*seconds)) {
    throw ConfigError("--time-offset", fmt::format("`{}` is neither a number of seconds nor `auto`", text));
  }
  options.time_offset = *seconds;
}

ErrorStatistics error_statistics(const std::vector<double>& magnitudes) {
  std::vector<double> sorted = magnitudes;
  std::sort(sorted.begin(), sorted.end());
  ErrorStatistics s;
  s.rmse = root_mean_square(magnitudes);
  s.mean = mean(magnitudes);
  constexpr double kHalf = 0.5;
  s.median = quantile_of(sorted, kHalf);
  double variance = 0;
  for (const double value : magnitudes) variance += square(value - s.mean);
  s.std = std::sqrt(variance / static_cast<double>(magnitudes.size()));
  s.min = sorted.front();
  s.max = sorted.back();
  return s;
}

bool Evaluation::has_sigmas() const {
  return std::any_of(within_sigma.begin(), within_sigma.end(), [](const auto& s) { return !std::isnan(s[0]); });
}

Evaluation evaluate(const Trajectory& estimate, const Trajectory& reference, const EvaluationOptions& options) {
  if (estimate.has_time != reference.has_time) {
    const Trajectory& without = estimate.has_time ? reference : estimate;
    throw DataError(without.file, "has no times; put them into STEM_times.txt next to it, one a row");
  }
  Evaluation found;
  found.estimate = estimate.file;
  found.reference = reference.file;
  found.options = options;
  found.own_axes = !estimate.geodetic || !reference.geodetic;
  const FramedPath b(reference, frame_of(reference, reference));
  found.time_offset = options.time_offset;
  // One log may begin before the end of a GPS week, and the other after it.
  if (estimate.has_time) found.time_offset += week_shift(estimate.time.front(), reference.time.front());
  const auto shifted = [&](double shift) { return FramedPath(estimate, frame_of(estimate, reference), shift); };
  if (options.find_offset) {
    const auto aligned = [&](double shift) {
      Epochs epochs = epochs_of(shifted(shift), b);
      move(epochs.a, align_points(positions(epochs.a), positions(epochs.b), options.align));
      return epochs;
    };
    const TimeOffset offset = find_time_offset(aligned, found.time_offset, options.search);
    found.time_offset = offset.value;
    found.sigma_time_offset = offset.sigma;
  }
  const FramedPath a = shifted(found.time_offset);
  Epochs epochs = epochs_of(a, b);
  found.alignment = align_points(positions(epochs.a), positions(epochs.b), options.align);
  move(epochs.a, found.alignment);
  found.in_gaps = epochs.in_gaps;
  found.outside = epochs.outside;
  const Has has{a.has_velocity() && b.has_velocity(), a.has_attitude() && b.has_attitude(),
                !estimate.covariance.empty()};
  const std::vector<double> course = courses(epochs.b, b.has_velocity());
  for (std::size_t i = 0; i < epochs.a.size(); ++i) {
    found.rows.push_back(errors_of(epochs.a[i], epochs.b[i], course[i], has));
  }
  found.track_estimate = positions(epochs.a);
  found.track_reference = positions(epochs.b);
  add_statistics(found, epochs);
  return found;
}

}  // namespace piste
