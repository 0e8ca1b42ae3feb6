#include "points/mark_delay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "piste/core/error.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr std::size_t kLeastMarks = 5;  // of three components each, for four unknowns and a spread
constexpr int kMostSteps = 30;
constexpr double kEnd = 1e-7;     // s: a step below moves nothing by a micrometre
constexpr double kFarthest = 10;  // s: what is longer is an offset of the marks' clock

// The path of a point, straight between epochs.
class PointPath {
 public:
  PointPath(const Replay& run, const OutputPoint& point, const std::string& file)
      : solution_(run.solution()), arm_(point.lever_arm), file_(file) {
    for (std::size_t i = 0; i < solution_.size(); ++i) times_.push_back(solution_.time(i));
  }
  // Place and velocity, in w.
  std::pair<Vector3d, Vector3d> at(double time) const {
    if (times_.size() < 2 || time < times_.front() || time > times_.back()) {
      throw DataError(file_, fmt::format("a mark at {:.6f} s lies outside the run while its delay is sought; state "
                                         "`delay`, or leave out marks near the ends",
                                         time));
    }
    const auto after = std::upper_bound(times_.begin() + 1, times_.end() - 1, time);
    const auto i = static_cast<std::size_t>(after - times_.begin());
    const Vector3d a = place(i - 1), b = place(i);
    const double length = times_[i] - times_[i - 1];
    return {a + (time - times_[i - 1]) / length * (b - a), (b - a) / length};
  }

 private:
  Vector3d place(std::size_t row) const {
    const Estimate x = solution_.estimate(row);
    return x.p_wb + x.R_wb() * arm_;
  }
  const Solution& solution_;
  Vector3d arm_;
  const std::string& file_;
  std::vector<double> times_;
};

// Residuals and velocities of the marks at a delay, along the local level.
struct Fit {
  std::vector<Vector3d> residual, velocity;
};

Vector3d mean_of(const std::vector<Vector3d>& values, const std::vector<bool>& used) {
  Vector3d sum = Vector3d::Zero();
  double count = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (used[i]) sum += values[i], ++count;
  }
  return sum / count;
}

// Which residuals lie with the others, about their median.
std::vector<bool> near_others(const std::vector<Vector3d>& residual) {
  constexpr double kSpreads = 3;
  const Vector3d middle = median_by_axis(residual);
  std::vector<double> size;
  size.reserve(residual.size());
  for (const Vector3d& r : residual) size.push_back((r - middle).norm());
  // The median length of three equal components is 1.54 of their sigmas.
  const double spread = median(size) / std::sqrt(chi_squared_quantile(0.5, 3));
  std::vector<bool> near;
  near.reserve(size.size());
  for (const double s : size) near.push_back(s <= kSpreads * std::sqrt(3.0) * spread);
  return near;
}

}  // namespace

MarkDelay find_mark_delay(const Replay& run, const std::vector<Mark>& marks, const OutputPoint& point,
                          const std::string& file) {
  const auto placed = static_cast<std::size_t>(std::ranges::count_if(marks, [](const Mark& m) { return !!m.place; }));
  if (placed < kLeastMarks) {
    throw DataError(file, fmt::format("`delay: auto` needs the places of at least {} marks, in the columns "
                                      "latitude_deg, longitude_deg, height_m; {} have one",
                                      kLeastMarks, placed));
  }
  const World& world = run.log.world;
  const PointPath path(run, point, file);
  MarkDelay found;
  std::vector<bool> used(placed, true);
  for (int step = 0; step < kMostSteps; ++step) {
    Fit fit;
    for (const Mark& mark : marks) {
      if (!mark.place) continue;
      const auto [place, velocity] = path.at(mark.time + found.delay);
      const Matrix3d R_nw = world.rotation_wn(place).transpose();
      fit.residual.emplace_back(R_nw * (world.from_geodetic(*mark.place) - place));
      fit.velocity.emplace_back(R_nw * velocity);
    }
    if (step > 0) used = near_others(fit.residual);
    const Vector3d about = mean_of(fit.velocity, used), middle = mean_of(fit.residual, used);
    double square = 0, product = 0;
    for (std::size_t i = 0; i < placed; ++i) {
      if (!used[i]) continue;
      square += (fit.velocity[i] - about).squaredNorm();
      product += (fit.velocity[i] - about).dot(fit.residual[i] - middle);
    }
    // A constant velocity moves all places alike, as their offset does.
    if (!(square > 0)) throw DataError(file, "`delay: auto` needs a body whose velocity changes");
    const double change = product / square;
    found.delay += change;
    if (!(std::abs(found.delay) < kFarthest)) {
      throw DataError(file, fmt::format("no delay within {} s brings the marks to the track; state the `offset` of "
                                        "their clock first",
                                        kFarthest));
    }
    if (step < 2 || std::abs(change) > kEnd) continue;

    std::vector<double> score, left;
    for (std::size_t i = 0; i < placed; ++i) {
      if (!used[i]) continue;
      const Vector3d rest = fit.residual[i] - middle - change * (fit.velocity[i] - about);
      score.push_back((fit.velocity[i] - about).dot(rest));
      left.insert(left.end(), rest.begin(), rest.end());
    }
    found.used = score.size();
    found.offset = middle - change * about;
    found.residual = root_mean_square(left);
    found.sigma = static_cast<double>(score.size()) * standard_error_of_series(score) / square;
    return found;
  }
  throw DataError(file,
                  fmt::format("the delay of the marks is not found in {} steps; are their places right?", kMostSteps));
}

}  // namespace piste
