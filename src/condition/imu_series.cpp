#include "condition/imu_series.h"

#include <algorithm>
#include <cmath>

#include "condition/spline.h"

namespace piste {
namespace {

constexpr double kSameTime = 1e-7;  // s
constexpr std::uint8_t kEveryAxis = 7;
// A sensor of few digits repeats a row or two at rest; three axes that all do so for that long are not measured.
constexpr std::size_t kStuckSamples = 10;
constexpr double kStuckTime = 0.1;  // s

// Whether a sample of an IMU is usable, and if not why.
struct Flags {
  std::uint8_t gyro = 0, accel = 0;
  ImuFault why_gyro = ImuFault::kClipped, why_accel = ImuFault::kClipped;
};

void mark(std::uint8_t& bits, ImuFault& why, std::uint8_t which, ImuFault fault) {
  if (which == 0) return;
  bits = static_cast<std::uint8_t>(bits | which);
  why = std::max(why, fault);
}

bool repeats(const Vector3d& a, const Vector3d& b) {
  constexpr double kSameDigits = 1e-12;
  return (a - b).cwiseAbs().maxCoeff() <= kSameDigits * a.cwiseAbs().maxCoeff();
}

// Marks the runs of samples in which `mean` repeats.
template <class Mean, class Mark>
void find_stuck(const std::vector<ImuSample>& unit, Mean&& mean, Mark&& mark_one) {
  for (std::size_t begin = 0, end = 0; begin < unit.size(); begin = end) {
    end = begin + 1;
    while (end < unit.size() && repeats(mean(unit[end]), mean(unit[begin]))) ++end;
    if (end - begin < kStuckSamples || unit[end - 1].time - unit[begin].time < kStuckTime) continue;
    for (std::size_t i = begin; i < end; ++i) mark_one(i);
  }
}

std::vector<Flags> flags_of(const std::vector<ImuSample>& unit) {
  std::vector<Flags> out(unit.size());
  for (std::size_t i = 0; i < unit.size(); ++i) {
    const ImuSample& s = unit[i];
    Flags& f = out[i];
    mark(f.gyro, f.why_gyro, s.clipped_gyro, ImuFault::kClipped);
    mark(f.accel, f.why_accel, s.clipped_accel, ImuFault::kClipped);
    if (s.interpolated && s.interpolated->gyro > 0) mark(f.gyro, f.why_gyro, kEveryAxis, ImuFault::kSpike);
    if (s.interpolated && s.interpolated->accel > 0) mark(f.accel, f.why_accel, kEveryAxis, ImuFault::kSpike);
    if (!s.gap) continue;
    mark(f.gyro, f.why_gyro, kEveryAxis, ImuFault::kSilent);
    mark(f.accel, f.why_accel, kEveryAxis, ImuFault::kSilent);
  }
  find_stuck(
      unit, [](const ImuSample& s) { return Vector3d(s.dtheta / s.interval); },
      [&](std::size_t i) {
        if (!unit[i].gap) mark(out[i].gyro, out[i].why_gyro, kEveryAxis, ImuFault::kStuck);
      });
  find_stuck(
      unit, [](const ImuSample& s) { return Vector3d(s.dvel / s.interval); },
      [&](std::size_t i) {
        if (!unit[i].gap) mark(out[i].accel, out[i].why_accel, kEveryAxis, ImuFault::kStuck);
      });
  return out;
}

bool same_epochs(const std::vector<ImuSample>& a, const std::vector<ImuSample>& b) {
  return std::ranges::equal(a, b, [](const ImuSample& x, const ImuSample& y) {
    return std::abs(x.time - y.time) < kSameTime && std::abs(x.interval - y.interval) < kSameTime;
  });
}

// Sums of increments, from which those of any interval are differences.
class Sums {
 public:
  explicit Sums(const std::vector<ImuSample>& unit) {
    time_.push_back(unit.front().time - unit.front().interval);
    turn_.emplace_back(Vector3d::Zero());
    push_.emplace_back(Vector3d::Zero());
    for (const ImuSample& s : unit) {
      time_.push_back(s.time);
      turn_.emplace_back(turn_.back() + s.dtheta);
      push_.emplace_back(push_.back() + s.dvel);
    }
    turn_spline_.emplace(time_, turn_);
    push_spline_.emplace(time_, push_);
  }
  Sums(const Sums&) = delete;
  Sums& operator=(const Sums&) = delete;

  bool covers(double from, double to) const {
    return from >= time_.front() - kSameTime && to <= time_.back() + kSameTime;
  }
  // The interval of the IMU that contains t.
  std::size_t place(double t) const {
    const auto after = std::upper_bound(time_.begin() + 1, time_.end() - 1, t);
    return static_cast<std::size_t>(after - time_.begin()) - 1;
  }
  Vector3d turn(double from, double to) const { return between(*turn_spline_, from, to); }
  Vector3d push(double from, double to) const { return between(*push_spline_, from, to); }

 private:
  Vector3d between(const Spline& spline, double from, double to) const {
    return spline.value(place(to), to) - spline.value(place(from), from);
  }
  std::vector<double> time_;
  std::vector<Vector3d> turn_, push_;
  std::optional<Spline> turn_spline_, push_spline_;
};

}  // namespace

ImuSeries at_epochs(const std::vector<ImuSample>& unit, const std::vector<ImuSample>& epochs) {
  const std::vector<Flags> flags = flags_of(unit);
  ImuSeries out;
  const auto add = [](ImuTriad& triad, const Vector3d& value, std::uint8_t bad, ImuFault why) {
    triad.value.push_back(value);
    triad.bad.push_back(bad);
    triad.why.push_back(why);
  };
  if (same_epochs(unit, epochs)) {
    for (std::size_t k = 0; k < unit.size(); ++k) {
      add(out.gyro, unit[k].dtheta / unit[k].interval, flags[k].gyro, flags[k].why_gyro);
      add(out.accel, unit[k].dvel / unit[k].interval, flags[k].accel, flags[k].why_accel);
    }
    return out;
  }
  const Sums sums(unit);
  for (const ImuSample& epoch : epochs) {
    const double from = epoch.time - epoch.interval, to = epoch.time;
    if (!sums.covers(from, to)) {
      add(out.gyro, Vector3d::Zero(), kEveryAxis, ImuFault::kSilent);
      add(out.accel, Vector3d::Zero(), kEveryAxis, ImuFault::kSilent);
      continue;
    }
    Flags all;
    for (std::size_t i = sums.place(from + kSameTime); i <= sums.place(to - kSameTime); ++i) {
      mark(all.gyro, all.why_gyro, flags[i].gyro, flags[i].why_gyro);
      mark(all.accel, all.why_accel, flags[i].accel, flags[i].why_accel);
    }
    add(out.gyro, sums.turn(from, to) / epoch.interval, all.gyro, all.why_gyro);
    add(out.accel, sums.push(from, to) / epoch.interval, all.accel, all.why_accel);
  }
  return out;
}

}  // namespace piste
