#include "imu_gaps.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace piste {
namespace {

/// Sums over the samples before each, so that those over any stretch are differences.
class RunningSums {
 public:
  explicit RunningSums(const std::vector<ImuSample>& imu) : imu_(imu) {
    for (const ImuSample& s : imu) {
      turn_.emplace_back(turn_.back() + s.dtheta);
      push_.emplace_back(push_.back() + s.dvel);
      gaps_.push_back(gaps_.back() + (s.gap ? 1 : 0));
    }
  }

  bool has_gap(std::size_t first, std::size_t last) const { return gaps_[last] > gaps_[first]; }
  double start(std::size_t i) const { return imu_[i].time - imu_[i].interval; }
  double time(std::size_t first, std::size_t last) const { return imu_[last - 1].time - start(first); }
  Vector3d turn(std::size_t first, std::size_t last) const { return turn_[last] - turn_[first]; }
  Vector3d push(std::size_t first, std::size_t last) const { return push_[last] - push_[first]; }

 private:
  const std::vector<ImuSample>& imu_;
  std::vector<Vector3d> turn_{Vector3d::Zero()}, push_{Vector3d::Zero()};
  std::vector<std::size_t> gaps_{0};
};

struct Rates {
  double time = 0;  // middle
  Vector3d gyro = Vector3d::Zero(), accel = Vector3d::Zero();
};

Rates mean(const RunningSums& sums, std::size_t first, std::size_t last) {
  const double time = sums.time(first, last);
  return {sums.start(first) + time / 2, sums.turn(first, last) / time, sums.push(first, last) / time};
}

Rates between(const Rates& before, const Rates& after, double time) {
  const double part = (time - before.time) / (after.time - before.time);
  return {time, before.gyro + part * (after.gyro - before.gyro), before.accel + part * (after.accel - before.accel)};
}

/// Samples [begin, end) of a gap, and the number of samples on either side from which its line is drawn.
struct Gap {
  std::size_t begin, end, edge;
};

void fill(std::vector<ImuSample>& imu, const RunningSums& sums, const Gap& gap) {
  std::size_t first = gap.begin, last = gap.end;
  while (first > 0 && gap.begin - first < gap.edge && !imu[first - 1].gap) --first;
  while (last < imu.size() && last - gap.end < gap.edge && !imu[last].gap) ++last;
  const bool begins = first == gap.begin, ends = last == gap.end;  // at the log's: the other side is held
  const Rates before = begins ? mean(sums, gap.end, last) : mean(sums, first, gap.begin);
  const Rates after = ends ? before : mean(sums, gap.end, last);
  for (std::size_t i = gap.begin; i < gap.end; ++i) {
    const Rates now = begins || ends ? before : between(before, after, imu[i].time - imu[i].interval / 2);
    imu[i].dtheta = now.gyro * imu[i].interval;
    imu[i].dvel = now.accel * imu[i].interval;
  }
}

GapNoise noise(const std::vector<ImuSample>& imu, const RunningSums& sums, const Gap& gap, const GapOptions& options) {
  const std::size_t count = gap.end - gap.begin;
  const double length = sums.time(gap.begin, gap.end),
               reach = std::max(options.reach, options.reach_in_lengths * length);
  const auto place = [&](double time) {
    const auto later = [](double t, const ImuSample& s) { return t < s.time; };
    return static_cast<std::size_t>(std::upper_bound(imu.begin(), imu.end(), time, later) - imu.begin());
  };
  const std::size_t from = place(sums.start(gap.begin) - reach), to = place(imu[gap.end - 1].time + reach);
  Vector3d turn = Vector3d::Zero(), push = Vector3d::Zero();  // squares of the line's errors
  std::size_t stretches = 0;
  for (std::size_t first = from + gap.edge; first + count + gap.edge <= to; ++first) {
    const std::size_t last = first + count;
    if (sums.has_gap(first - gap.edge, last + gap.edge)) continue;
    const double time = sums.time(first, last);
    const Rates middle =
        between(mean(sums, first - gap.edge, first), mean(sums, last, last + gap.edge), sums.start(first) + time / 2);
    turn += (sums.turn(first, last) - middle.gyro * time).cwiseAbs2();
    push += (sums.push(first, last) - middle.accel * time).cwiseAbs2();
    ++stretches;
  }
  if (stretches < options.fewest_lengths * count) return options.unknown;
  const auto density = [&](const Vector3d& squares) {
    return static_cast<float>(options.caution *
                              std::sqrt(squares.maxCoeff() / (static_cast<double>(stretches) * length)));
  };
  return {density(turn), density(push)};
}

}  // namespace

void fill_gaps(std::vector<ImuSample>& imu, const GapOptions& options) {
  const auto is_gap = [](const ImuSample& s) { return s.gap.has_value(); };
  auto end = imu.begin();
  auto begin = std::find_if(end, imu.end(), is_gap);
  if (begin == imu.end()) return;
  const RunningSums sums(imu);
  for (; begin != imu.end(); begin = std::find_if(end, imu.end(), is_gap)) {
    end = std::find_if_not(begin, imu.end(), is_gap);
    const auto edge = static_cast<std::size_t>(std::max(1L, std::lround(options.edge / begin->interval)));
    const Gap gap{static_cast<std::size_t>(begin - imu.begin()), static_cast<std::size_t>(end - imu.begin()), edge};
    fill(imu, sums, gap);
    for (const GapNoise found = noise(imu, sums, gap, options); begin != end; ++begin) begin->gap = found;
  }
}

}  // namespace piste
