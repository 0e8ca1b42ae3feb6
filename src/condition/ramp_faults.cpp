#include "condition/ramp_faults.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>

#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr std::array kWindows{1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0, 128.0};  // s
constexpr double kFalse = 1e-6;   // probability of a fault by chance in a log
constexpr double kFarLonger = 4;  // times its length that a window needs of the log: a fault is not half of it

// A fix, with its position less the track by the velocities, along the local level at the first fix.
struct Point {
  std::size_t fix = 0;
  double time = 0;
  Vector3d off = Vector3d::Zero();        // S
  Vector3d position = Vector3d::Zero();   // variance of it
  Vector3d travelled = Vector3d::Zero();  // variance of the sum of velocities since the piece began
};

Vector3d variance_between(const Point& a, const Point& b) {
  return a.position + b.position + (b.travelled - a.travelled).cwiseAbs();
}

// A stretch of points without a gap.
using Piece = std::vector<Point>;

std::vector<Piece> pieces_of(const std::vector<GnssFix>& fixes, const FaultDetectionOptions& options,
                             const Matrix3d& R_nw) {
  std::vector<Piece> pieces;
  const GnssFix* last = nullptr;
  Vector3d track = Vector3d::Zero(), change = Vector3d::Zero();
  for (std::size_t k = 0; k < fixes.size(); ++k) {
    const GnssFix& fix = fixes[k];
    if (!fix.velocity) {
      last = nullptr;
      continue;
    }
    if (last != nullptr && fix.position == last->position) continue;  // repeated
    const Vector3d position = R_nw * fix.position, variance = fix.sigma_position.cwiseAbs2();
    if (last == nullptr || fix.time - last->time > options.recent) {
      pieces.emplace_back();
      track = position;
      pieces.back().push_back({k, fix.time, Vector3d::Zero(), variance, Vector3d::Zero()});
      change.setZero();
    } else {
      const double dt = fix.time - last->time;
      const Vector3d steeper = R_nw * (fix.velocity->value - last->velocity->value);
      track += dt * (R_nw * last->velocity->value + 0.5 * steeper);
      // The trapezoid's error is dt/12 times the second difference of the velocity.
      const Vector3d truncated = dt / 12 * (steeper - change);
      const Vector3d travelled =
          pieces.back().back().travelled + dt * dt * fix.velocity->sigma.cwiseAbs2() + truncated.cwiseAbs2();
      pieces.back().push_back({k, fix.time, position - track, variance, travelled});
      change = steeper;
    }
    last = &fix;
  }
  return pieces;
}

// Velocity and acceleration by the velocities, of which S contains parts if they are late or the trapezoids are wide.
using Motion = Eigen::Matrix<double, 3, 2>;

std::vector<Motion> motions_of(const Piece& piece, const std::vector<GnssFix>& fixes, const Matrix3d& R_nw) {
  std::vector<Motion> motions(piece.size());
  const auto velocity = [&](std::size_t k) -> Vector3d { return R_nw * fixes[piece[k].fix].velocity->value; };
  for (std::size_t k = 0; k < piece.size(); ++k) {
    const std::size_t before = k - std::min<std::size_t>(k, 1), after = std::min(k + 1, piece.size() - 1);
    const double time = std::max(piece[after].time - piece[before].time, std::numeric_limits<double>::min());
    motions[k] << velocity(k), (velocity(after) - velocity(before)) / time;
  }
  return motions;
}

// Takes these parts out, by the regression of the steps of S on theirs. Least absolute deviations, by least squares
// with weights, as outliers and jumps are among the steps.
void take_motion_out(std::vector<Piece>& pieces, const std::vector<GnssFix>& fixes, const Matrix3d& R_nw, int axes) {
  std::vector<std::vector<Motion>> motions;
  motions.reserve(pieces.size());
  for (const Piece& piece : pieces) motions.push_back(motions_of(piece, fixes, R_nw));
  Eigen::Vector2d parts = Eigen::Vector2d::Zero();
  constexpr int kRounds = 20;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (std::size_t n = 0; n < pieces.size(); ++n) {
      for (std::size_t k = 1; k < pieces[n].size(); ++k) {
        const Point &last = pieces[n][k - 1], &point = pieces[n][k];
        const Motion by = motions[n][k] - motions[n][k - 1];
        for (int axis = 0; axis < axes; ++axis) {
          const double sigma = std::sqrt(point.position(axis) + last.position(axis));
          const double step = point.off(axis) - last.off(axis), left = std::abs(step - by.row(axis) * parts);
          const double weight = 1 / (sigma * std::max(left, sigma));
          A += weight * by.row(axis).transpose() * by.row(axis);
          b += weight * step * by.row(axis).transpose();
        }
      }
    }
    const Eigen::LLT<Eigen::Matrix2d> root(A);
    if (root.info() != Eigen::Success) return;
    parts = root.solve(b);
  }
  for (std::size_t n = 0; n < pieces.size(); ++n) {
    for (std::size_t k = 0; k < pieces[n].size(); ++k) pieces[n][k].off -= motions[n][k] * parts;
  }
}

// The tests over windows of one length. `begins[k]`: the point at which the window that ends at point k begins, or k.
struct Window {
  double length = 0;
  std::vector<std::vector<std::size_t>> begins = {};  // by piece
  double scale = 1;                                   // of the variance, by the log itself: at least 1
};

class RampSearch {
 public:
  RampSearch(const std::vector<GnssFix>& fixes, const FaultDetectionOptions& options, const World& world)
      : options_(options), R_nw_(world.rotation_wn(fixes.front().position).transpose()) {
    const bool down =
        std::ranges::all_of(fixes, [](const GnssFix& f) { return !f.velocity || f.velocity->has_down(); });
    axes_ = down ? 3 : 2;
    pieces_ = pieces_of(fixes, options, R_nw_);
    take_motion_out(pieces_, fixes, R_nw_, axes_);
    double lasted = 0;
    std::size_t tests = 0;
    for (const Piece& piece : pieces_) lasted += piece.back().time - piece.front().time;
    add_window(0, tests);
    for (const double length : kWindows) {
      if (kFarLonger * length <= lasted) add_window(length, tests);
    }
    bound_ = tests > 0 ? chi_squared_quantile(1 - kFalse / static_cast<double>(tests), axes_) : 0;
  }

  std::vector<RampFault> faults(std::vector<GnssFix>& fixes) const {
    std::vector<RampFault> found;
    for (std::size_t n = 0; n < pieces_.size(); ++n) {
      const Piece& piece = pieces_[n];
      double quiet_until = piece.front().time;  // what did not return is not looked at again at every point
      for (std::size_t k = 1; k < piece.size(); ++k) {
        if (piece[k].time < quiet_until) continue;
        const Window* const window = detected(n, k);
        if (window == nullptr) continue;
        const std::size_t begin = onset(piece, *window, window->begins[n][k], k);
        const Point before = level(piece, begin);
        const std::optional<std::size_t> end = returned(piece, before, k);
        if (!end) {
          quiet_until = piece[k].time + window->length;
          continue;
        }
        RampFault fault{.span = {piece[begin].time, piece[*end - 1].time}};
        for (std::size_t i = begin; i < *end; ++i) {
          fixes[piece[i].fix].runs_away = true;
          ++fault.count;
          fault.off = std::max(fault.off, (piece[i].off - before.off).head(axes_).norm());
        }
        found.push_back(fault);
        k = *end;
      }
    }
    return found;
  }

 private:
  // A window of length 0 is one step.
  void add_window(double length, std::size_t& tests) {
    Window window{.length = length};
    std::vector<double> sizes;
    for (const Piece& piece : pieces_) {
      std::vector<std::size_t>& begins = window.begins.emplace_back(piece.size());
      std::size_t i = 0;
      for (std::size_t k = 0; k < piece.size(); ++k) {
        while (i < k && piece[k].time - piece[i].time > length) ++i;
        begins[k] = length == 0 ? k - std::min<std::size_t>(k, 1) : std::min(i > 0 ? i - 1 : k, k);
        if (begins[k] == k) continue;
        sizes.push_back(change(piece[begins[k]], piece[k]));
      }
    }
    if (sizes.empty()) return;
    tests += sizes.size();
    window.scale = std::max(1.0, median(std::move(sizes)) / chi_squared_quantile(0.5, axes_));
    windows_.push_back(std::move(window));
  }

  // The change of S, squared, over its variance: chi-squared with as many degrees of freedom as axes.
  double change(const Point& a, const Point& b) const {
    const Vector3d off = b.off - a.off, variance = variance_between(a, b);
    double sum = 0;
    for (int axis = 0; axis < axes_; ++axis) sum += off(axis) * off(axis) / variance(axis);
    return sum;
  }

  // The window that ends at point k and shows a ramp; null if none does.
  const Window* detected(std::size_t n, std::size_t k) const {
    const Piece& piece = pieces_[n];
    for (const Window& window : windows_) {
      const std::size_t i = window.begins[n][k];
      if (i == k || change(piece[i], piece[k]) <= window.scale * bound_) continue;
      for (std::size_t j = i + 1; j <= k; ++j) {
        if (change(piece[j - 1], piece[j]) > windows_.front().scale * bound_) return nullptr;  // a jump
      }
      return &window;
    }
    return nullptr;
  }

  // S = level + slope · max(0, t − t_onset) from one window before i to k: the earliest onset within 95 %.
  std::size_t onset(const Piece& piece, const Window& window, std::size_t i, std::size_t k) const {
    std::size_t from = i;
    while (from > 0 && piece[i].time - piece[from].time < window.length) --from;
    const auto misfit = [&](std::size_t begin) {
      double all = 0;
      for (int axis = 0; axis < axes_; ++axis) {
        Eigen::Matrix2d A = Eigen::Matrix2d::Zero();
        Eigen::Vector2d b = Eigen::Vector2d::Zero();
        for (std::size_t j = from; j <= k; ++j) {
          const Eigen::Vector2d row(1, std::max(0.0, piece[j].time - piece[begin].time));
          const double y = piece[j].off(axis) - piece[from].off(axis), weight = 1 / piece[j].position(axis);
          A += weight * row * row.transpose();
          b += weight * y * row;
          all += weight * y * y;
        }
        all -= b.dot(A.ldlt().solve(b));
      }
      return all;
    };
    std::vector<double> misfits;
    for (std::size_t begin = from; begin < k; ++begin) misfits.push_back(misfit(begin));
    const double least = *std::ranges::min_element(misfits);
    const double allowed = least + window.scale * chi_squared_quantile(0.95, 1);
    auto first = std::ranges::min_element(misfits);
    while (first != misfits.begin() && *(first - 1) <= allowed) --first;
    return std::max<std::size_t>(1, from + static_cast<std::size_t>(first - misfits.begin()));
  }

  // The mean of S before an onset, over as many points as end a fault.
  Point level(const Piece& piece, std::size_t onset) const {
    const std::size_t count = std::min(onset, static_cast<std::size_t>(options_.readmit_after));
    Point mean{.time = piece[onset - 1].time, .travelled = piece[onset - 1].travelled};
    for (std::size_t i = onset - count; i < onset; ++i) {
      mean.off += piece[i].off / static_cast<double>(count);
      mean.position += piece[i].position / static_cast<double>(count * count);
    }
    return mean;
  }

  // The first point of those that have returned to the level before the onset; none if they do not.
  std::optional<std::size_t> returned(const Piece& piece, const Point& before, std::size_t detected) const {
    const double gate = chi_squared_quantile(options_.gate, axes_);
    int row = 0;
    for (std::size_t k = detected + 1; k < piece.size(); ++k) {
      if (piece[k].time - piece[detected].time > options_.distrust) break;
      const double scale = scale_over(piece[k].time - before.time);
      row = change(before, piece[k]) <= gate * scale ? row + 1 : 0;
      if (row == options_.readmit_after) return k + 1 - static_cast<std::size_t>(row);
    }
    return std::nullopt;
  }

  double scale_over(double time) const {
    double scale = 1;
    for (const Window& window : windows_) {
      if (window.length <= time) scale = window.scale;
    }
    return scale;
  }

  FaultDetectionOptions options_;
  Matrix3d R_nw_;
  int axes_ = 3;
  std::vector<Piece> pieces_;
  std::vector<Window> windows_;
  double bound_ = 0;
};

}  // namespace

std::vector<RampFault> exclude_ramp_faults(std::vector<GnssFix>& fixes, const FaultDetectionOptions& options,
                                           const World& world) {
  if (fixes.empty()) return {};
  return RampSearch(fixes, options, world).faults(fixes);
}

}  // namespace piste
