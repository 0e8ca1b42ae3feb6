#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "condition/clipping.h"
#include "condition/spikes.h"
#include "condition/spline.h"
#include "core/row_gaps.h"
#include "core/time_search.h"
#include "imu_gaps.h"
#include "piste/condition/pipeline.h"
#include "piste/core/error.h"
#include "piste/math/interruption.h"

namespace piste {
namespace {

constexpr double kBeyond = 2;  // times the range: a value that is no measurement
constexpr double kShortestInterval = 1e-5, kLongestInterval = 1;

/// The rows within the span, in GPS time and body axes.
struct Rows {
  std::vector<double> time;
  std::vector<Vector3d> gyro, accel;
  std::vector<std::uint8_t> clipped_gyro, clipped_accel;  // bit i: axis i stood at the range or beyond
  std::map<std::size_t, GapNoise> interpolated;           // by row, of those that held a spike

  std::optional<GapNoise> interpolated_at(std::size_t i) const {
    if (interpolated.empty()) return std::nullopt;
    const auto found = interpolated.find(i);
    return found == interpolated.end() ? std::nullopt : std::optional(found->second);
  }
};

double gps_time(const ImuConditioning& options, double first, double t) {
  return t - options.clock_offset - options.clock_drift * (t - first);
}

// Whether the next sample of the magnetometer is used.
bool is_due(const MagneticConditioning& options, const std::vector<MagneticSample>& samples, double time) {
  return samples.empty() || time - samples.back().time > options.interval - kSameInstant;
}

// Takes the rows out of the recording.
Rows rows_in_span(ImuRecording& recording, const ConditioningOptions& options, Log& log) {
  if (recording.time.empty()) throw DataError(recording.file, "the IMU has no rows");
  const auto& [start, end] = options.span;
  const Matrix3d& R_bs = options.imu.R_bs;
  const double first = recording.time.front(), last = recording.time.back();
  Rows rows{.time = std::move(recording.time),
            .gyro = std::move(recording.gyro),
            .accel = std::move(recording.accel),
            .clipped_gyro = {},
            .clipped_accel = {},
            .interpolated = {}};
  std::size_t count = 0;
  for (std::size_t i = 0; i < rows.time.size(); ++i) {
    const double t = gps_time(options.imu, first, rows.time[i]);
    if ((start != 0 && t < start) || (end != 0 && t > end)) continue;
    rows.time[count] = t;
    rows.gyro[count] = (R_bs * rows.gyro[i]).eval();
    rows.accel[count] = (R_bs * rows.accel[i]).eval();
    if (!recording.magnetic.empty() && is_due(options.magnetic, log.magnetic, t)) {
      log.magnetic.push_back({t, options.magnetic.unit * (R_bs * recording.magnetic[i])});
    }
    ++count;
  }
  rows.time.resize(count);
  rows.gyro.resize(count);
  rows.accel.resize(count);
  if (rows.time.size() < 3) {
    throw DataError(
        recording.file,
        fmt::format("{} IMU rows lie within the span {} to {} s; the file covers {:.3f} to {:.3f} s of GPS time",
                    rows.time.size(), start, end, gps_time(options.imu, first, first),
                    gps_time(options.imu, first, last)));
  }
  return rows;
}

RowGaps gaps_of(const Rows& rows, const std::string& file, const GapOptions& options) {
  RowGaps gaps = find_gaps(rows.time, options);
  if (gaps.period < kShortestInterval || gaps.period > kLongestInterval) {
    throw DataError(file,
                    fmt::format("the IMU's rows are {:.3g} s apart; times in seconds, and intervals of {} to {} s are "
                                "expected",
                                gaps.period, kShortestInterval, kLongestInterval));
  }
  for (const std::size_t i : gaps.after) {
    if (rows.time[i] - rows.time[i - 1] <= options.longest) continue;
    throw DataError(file, fmt::format("the IMU is silent from {:.3f} to {:.3f} s, longer than {} s; replay the parts "
                                      "one by one with `span`",
                                      rows.time[i - 1], rows.time[i], options.longest));
  }
  return gaps;
}

/// Marks components at the range as clipped. A component far beyond the range is not a measurement: it is replaced by
/// the mean of the rows around it. `unit(i)` is the factor from a rate to the value in row i.
template <class Unit>
std::vector<std::uint8_t> mark_clipped(std::vector<Vector3d>& values, double range, Unit&& unit) {
  std::vector<std::uint8_t> marks(values.size(), 0);
  for (std::size_t i = 0; range > 0 && i < values.size(); ++i) {
    const double limit = range * unit(i);
    for (unsigned axis = 0; axis < 3; ++axis) {
      double& value = values[i](axis);
      if (std::abs(value) < kAtRange * limit) continue;
      marks[i] = static_cast<std::uint8_t>(marks[i] | 1U << axis);
      if (std::abs(value) <= kBeyond * limit) continue;
      const double after = i + 1 < values.size() ? values[i + 1](axis) : 0,
                   before = i > 0 ? values[i - 1](axis) : after;
      value = std::abs(after) <= kBeyond * limit ? (before + after) / 2 : before;
    }
  }
  return marks;
}

void mark_clipped(Rows& rows, const RowGaps& gaps, const ConditioningOptions& options, bool increments) {
  const auto unit = [&](std::size_t i) {
    if (!increments) return 1.0;
    return i == 0 || gaps.before(i) ? gaps.period : rows.time[i] - rows.time[i - 1];
  };
  rows.clipped_gyro = mark_clipped(rows.gyro, options.gyro_range, unit);
  rows.clipped_accel = mark_clipped(rows.accel, options.accel_range, unit);
}

/// Interpolates the spikes of one triad. The noise of a row, `density`, is the rms error of such interpolation at the
/// rows around it. An interpolated axis is no longer marked as clipped.
void mend_spikes(Rows& rows, std::vector<Vector3d>& values, std::vector<std::uint8_t>& clipped,
                 const std::vector<Spike>& spikes, double period, float GapNoise::*density) {
  for (const Spike& s : spikes) {
    for (std::size_t i = s.row; i < s.row + s.count; ++i) {
      float& noise = rows.interpolated[i].*density;
      noise = std::max(noise, static_cast<float>(s.spread * std::sqrt(period)));
      clipped[i] = static_cast<std::uint8_t>(clipped[i] & ~(1U << static_cast<unsigned>(s.axis)));
    }
  }
  interpolate_spikes(values, spikes);
}

void mend_spikes(Rows& rows, const RowGaps& gaps, bool increments, const SpikeOptions& options, LogCounts& counts) {
  const double period = increments ? gaps.period : 1;
  if (!options.mend) return;
  mend_spikes(rows, rows.gyro, rows.clipped_gyro,
              find_spikes(rows.time, gaps, rows.gyro, period, options.gyro, options), gaps.period, &GapNoise::gyro);
  mend_spikes(rows, rows.accel, rows.clipped_accel,
              find_spikes(rows.time, gaps, rows.accel, period, options.accel, options), gaps.period, &GapNoise::accel);
  counts.imu_spikes = rows.interpolated.size();
}

// The items of a vector in pieces, each of which is freed after its use.
template <class T>
class Pieces {
 public:
  explicit Pieces(std::vector<T> all) : size_(all.size()) {
    for (std::size_t i = 0; i < size_; i += kPiece) {
      const auto begin = all.begin() + static_cast<std::ptrdiff_t>(i);
      pieces_.emplace_back(begin, begin + static_cast<std::ptrdiff_t>(std::min(kPiece, size_ - i)));
    }
  }
  std::size_t size() const { return size_; }
  const T& operator[](std::size_t i) const { return pieces_[i / kPiece][i % kPiece]; }
  void done_before(std::size_t i) {
    for (; done_ < i / kPiece; ++done_) std::vector<T>().swap(pieces_[done_]);  // "= {}" would keep its room
  }

 private:
  // Blocks beyond 32 MB go back to the system as soon as they are free.
  static constexpr std::size_t kPiece = 33'600'000 / sizeof(T);
  std::size_t size_, done_ = 0;
  std::vector<std::vector<T>> pieces_;
};

/// Turns rows into increments, and frees the rows.
class Incrementer {
 public:
  Incrementer(Rows& rows, const RowGaps& gaps, const ImuRecording& recording, const ConditioningOptions& options,
              Log& log)
      : rows_(rows), gaps_(gaps), recording_(recording), options_(options), log_(log) {}

  void run() {
    log_.imu.reserve(rows_.time.size() + 16);
    if (options_.imu.instantaneous) {
      integrate_samples();
    } else {
      pass_intervals();
    }
    fill_gaps(log_.imu, options_.behaviour.gaps);
    for (const ImuSample& sample : log_.imu) {
      if (sample.clipped_gyro != 0 || sample.clipped_accel != 0) ++log_.counts.imu_clipped;
    }
  }

 private:
  // Adds samples for a gap; they are filled later.
  void leave_open(double start, double end) {
    ++log_.counts.imu_gaps;
    const int count = std::max(1, static_cast<int>(std::lround((end - start) / gaps_.period)));
    double before = start;
    for (int k = 1; k <= count; ++k) {
      const double time = k == count ? end : start + (end - start) * k / count;
      log_.imu.push_back({.time = time, .interval = time - before, .gap = GapNoise{}});
      before = time;
    }
  }

  // For rows that are of the interval before them.
  void pass_intervals() {
    Pieces<double> time(std::move(rows_.time));
    Pieces<Vector3d> gyro(std::move(rows_.gyro)), accel(std::move(rows_.accel));
    for (std::size_t i = 0; i < time.size(); ++i) {
      if (i > 0) time.done_before(i - 1);
      gyro.done_before(i);
      accel.done_before(i);
      const bool after_gap = i > 0 && gaps_.before(i);
      const double interval = i == 0 || after_gap ? gaps_.period : time[i] - time[i - 1];
      if (after_gap) leave_open(time[i - 1], time[i] - gaps_.period);
      const double unit = recording_.increments ? 1 : interval;
      log_.imu.push_back({.time = time[i],
                          .interval = interval,
                          .dtheta = unit * gyro[i],
                          .dvel = unit * accel[i],
                          .clipped_gyro = rows_.clipped_gyro[i],
                          .clipped_accel = rows_.clipped_accel[i],
                          .interpolated = rows_.interpolated_at(i)});
    }
  }

  // For rows that are instantaneous samples: integrates a spline from gap to gap.
  void integrate_samples() {
    const std::size_t count = rows_.time.size();
    for (std::size_t begin = 0, end = 0; begin < count; begin = end) {
      end = begin + 1;
      while (end < count && !gaps_.before(end)) ++end;
      if (begin > 0) leave_open(rows_.time[begin - 1], rows_.time[begin]);
      if (end - begin >= 2) integrate_piece(begin, end - begin);
    }
  }

  void integrate_piece(std::size_t begin, std::size_t size) {
    const auto time = std::span(rows_.time).subspan(begin, size);
    const Spline gyro(time, std::span(rows_.gyro).subspan(begin, size));
    const Spline accel(time, std::span(rows_.accel).subspan(begin, size));
    const auto either = [](std::uint8_t a, std::uint8_t b) { return static_cast<std::uint8_t>(a | b); };
    std::uint8_t gyro_flags = rows_.clipped_gyro[begin];
    std::uint8_t accel_flags = rows_.clipped_accel[begin];
    for (std::size_t k = 0; k + 1 < size; ++k) {
      const std::uint8_t gyro_next = rows_.clipped_gyro[begin + k + 1];
      const std::uint8_t accel_next = rows_.clipped_accel[begin + k + 1];
      const std::optional<GapNoise> next = rows_.interpolated_at(begin + k + 1);
      log_.imu.push_back({.time = time[k + 1],
                          .interval = time[k + 1] - time[k],
                          .dtheta = gyro.integral(k),
                          .dvel = accel.integral(k),
                          .clipped_gyro = either(gyro_flags, gyro_next),
                          .clipped_accel = either(accel_flags, accel_next),
                          .interpolated = next ? next : rows_.interpolated_at(begin + k)});
      gyro_flags = gyro_next;
      accel_flags = accel_next;
    }
  }

  Rows& rows_;
  const RowGaps& gaps_;
  const ImuRecording& recording_;
  const ConditioningOptions& options_;
  Log& log_;
};

}  // namespace

Log condition_imu(ImuRecording recording, const ConditioningOptions& options) {
  if (recording.increments && options.imu.instantaneous) {
    throw DataError(recording.file, "holds increments, which are no instantaneous samples");
  }
  Log log;
  log.counts.imu_unpaired = recording.unpaired;
  log.counts.stamp_jitter = recording.stamp_jitter;
  log.counts.imu_repaired = recording.repaired;
  Rows rows = rows_in_span(recording, options, log);
  const RowGaps gaps = gaps_of(rows, recording.file, options.behaviour.gaps);
  check_interruption();
  mark_clipped(rows, gaps, options, recording.increments);
  mend_spikes(rows, gaps, recording.increments, options.behaviour.spikes, log.counts);
  check_interruption();
  Incrementer(rows, gaps, recording, options, log).run();
  return log;
}

}  // namespace piste
