#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <vector>

#include "core/recording.h"
#include "core/row_gaps.h"
#include "piste/math/statistics.h"

namespace piste {
namespace {

constexpr double kNear = 1;            // s on either side: no crystal's rate changes within it
constexpr std::size_t kFewest = 8;     // rows on either side, of a slow log
constexpr double kLeastJitter = 0.01;  // of a period: less is below the sensor's noise
constexpr double kOutlier = 8;         // median residuals, beyond which a sample is a knock

/// The least-squares line through the points near an origin that moves along.
class MovingLine {
 public:
  void add(double x, double y, double sign) {
    n_ += sign;
    x_ += sign * x;
    xx_ += sign * x * x;
    y_ += sign * y;
    xy_ += sign * x * y;
  }
  void move_origin(double by) {
    xx_ += by * (n_ * by - 2 * x_);
    xy_ -= by * y_;
    x_ -= by * n_;
  }
  double at_origin() const {
    const double determinant = n_ * xx_ - x_ * x_;
    return determinant > 0 ? (xx_ * y_ - x_ * xy_) / determinant : y_ / n_;
  }

 private:
  double n_ = 0, x_ = 0, xx_ = 0, y_ = 0, xy_ = 0;
};

/// Number of the sample in each row, as the clock counts them: rows that are missing count too.
std::vector<double> sample_numbers(const std::vector<double>& time, const RowGaps& gaps) {
  std::vector<double> number(time.size(), 0);
  std::size_t gap = 0;
  for (std::size_t i = 1; i < time.size(); ++i) {
    const bool missing = gap < gaps.after.size() && gaps.after[gap] == i;
    if (missing) ++gap;
    number[i] = number[i - 1] + (missing ? std::max(2.0, std::round((time[i] - time[i - 1]) / gaps.period)) : 1);
  }
  return number;
}

/// Lays the rows [begin, end), between which no long gap is, on a clock that is even near each of them.
void even_piece(const std::vector<double>& time, const std::vector<double>& number, double period, std::size_t begin,
                std::size_t end, std::vector<double>& even) {
  const double reach = std::max(static_cast<double>(kFewest), std::round(kNear / period));
  const auto late = [&](std::size_t i) { return time[i] - time[begin] - period * (number[i] - number[begin]); };
  MovingLine line;
  std::size_t first = begin, last = begin;
  for (std::size_t i = begin; i < end; ++i) {
    if (i > begin) line.move_origin(number[i] - number[i - 1]);
    for (; last < end && number[last] <= number[i] + reach; ++last) line.add(number[last] - number[i], late(last), 1);
    for (; number[first] < number[i] - reach; ++first) line.add(number[first] - number[i], late(first), -1);
    even[i] = time[begin] + period * (number[i] - number[begin]) + line.at_origin();
  }
}

/// Regression of the samples on the departures `late` of their stamps from the even clock, in periods. It is 0 if they
/// were taken by that clock, and 1 if they were taken at their stamps. A sample on the cubic through its neighbours was
/// taken evenly. A sample taken at its late stamp differs from that by its slope times the delay.
class Following {
 public:
  void add(const std::vector<Vector3d>& values, const std::vector<double>& late, const std::vector<double>& number) {
    if (values.size() != late.size()) return;
    for (int axis = 0; axis < 3; ++axis) add(values, axis, late, number);
  }
  bool by_stamps() const { return cross_ > 0.5 * power_; }

 private:
  struct Point {
    double expected, residual;
  };

  void add(const std::vector<Vector3d>& values, int axis, const std::vector<double>& late,
           const std::vector<double>& number) {
    std::vector<Point> points;
    std::vector<double> sizes;
    for (std::size_t i = 2; i + 2 < values.size(); ++i) {
      if (number[i + 2] - number[i - 2] != 4) continue;
      const auto y = [&](int k) { return values[i + 2 - static_cast<std::size_t>(2 - k)](axis); };
      const auto e = [&](int k) { return late[i + 2 - static_cast<std::size_t>(2 - k)]; };
      const double slope = (y(-2) - 8 * y(-1) + 8 * y(1) - y(2)) / 12;
      const double neighbours = (-e(-2) + 4 * e(-1) + 4 * e(1) - e(2)) / 6;
      points.push_back({slope * (e(0) - neighbours), y(0) - (-y(-2) + 4 * y(-1) + 4 * y(1) - y(2)) / 6});
      sizes.push_back(std::abs(points.back().residual));
    }
    if (sizes.empty()) return;
    const double usual = median(std::move(sizes));
    if (usual == 0) return;
    for (const Point& p : points) {
      if (std::abs(p.residual) > kOutlier * usual) continue;
      cross_ += p.expected * p.residual / (usual * usual);
      power_ += p.expected * p.expected / (usual * usual);
    }
  }

  double cross_ = 0, power_ = 0;
};

}  // namespace

void even_stamps(ImuRecording& imu) {
  if (imu.increments || imu.time.size() < 2 * kFewest) return;
  const RowGaps gaps = find_gaps(imu.time);
  const std::vector<double> number = sample_numbers(imu.time, gaps);
  std::vector<double> even = imu.time;
  std::size_t begin = 0;
  for (std::size_t k = 0; k <= gaps.after.size(); ++k) {
    const std::size_t end = k < gaps.after.size() ? gaps.after[k] : even.size();
    // Over a long gap samples cannot be counted.
    if (k < gaps.after.size() && imu.time[end] - imu.time[end - 1] < kNear) continue;
    even_piece(imu.time, number, gaps.period, begin, end, even);
    begin = end;
  }
  std::vector<double> late(even.size());
  double sum = 0;
  for (std::size_t i = 0; i < even.size(); ++i) {
    late[i] = (imu.time[i] - even[i]) / gaps.period;
    sum += late[i] * late[i];
  }
  const double jitter = std::sqrt(sum / static_cast<double>(even.size()));
  if (jitter < kLeastJitter || std::ranges::adjacent_find(even, std::greater_equal<>()) != even.end()) return;
  Following samples;
  samples.add(imu.gyro, late, number);
  samples.add(imu.accel, late, number);
  if (samples.by_stamps()) return;
  imu.time = std::move(even);
  imu.stamp_jitter = jitter * gaps.period;
}

}  // namespace piste
