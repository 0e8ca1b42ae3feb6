#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "byte_reader.h"
#include "log_formats.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste::log_formats {
namespace {

constexpr std::string_view kMagic{"$IMURAW\0", 8};
constexpr std::size_t kHeaderSize = 512, kRecordSize = 32;

/// The header (NovAtel Waypoint, "IMR File": packed, version 8.90).
struct ImrHeader {
  std::endian order = std::endian::little;
  bool rotation_increments = false, velocity_increments = false;
  double rate = 0, gyro_scale = 0, accel_scale = 0;  ///< [Hz], to degrees and metres
};

/// Goes through the records of a file.
class RecordReader : public RowSource {
 public:
  explicit RecordReader(const LogFile& log)
      : RowSource(log.file, Counts::kBytes), mapped_(log.content ? MappedFile(*log.content) : MappedFile(log.file)) {}

  /// Reads the header. An error in it always ends the reading.
  ImrHeader header() {
    if (!text().starts_with(kMagic)) refuse(0, "the file does not begin with $IMURAW; it is no log in the format imr");
    if (text().size() < kHeaderSize) refuse(0, fmt::format("the header of {} bytes is cut", kHeaderSize));
    ImrHeader h;
    const int order = flag<std::uint8_t>(8, 1, "byte order; 0 (Intel) or 1 (Motorola)");
    h.order = order == 0 ? std::endian::little : std::endian::big;
    order_ = h.order;
    h.rotation_increments = flag<std::int32_t>(17, 1, "bDeltaTheta; 0 (rates) or 1 (increments)") == 1;
    h.velocity_increments = flag<std::int32_t>(21, 1, "bDeltaVelocity; 0 (accelerations) or 1 (increments)") == 1;
    h.rate = positive(25, "dDataRateHz, the rate in Hz");
    h.gyro_scale = positive(33, "dGyroScaleFactor");
    h.accel_scale = positive(41, "dAccelScaleFactor");
    if (flag<std::int32_t>(49, 2, "iUtcOrGpsTime; 0, 1 (UTC) or 2 (GPS)") == 1) {
      refuse(49,
             "the time tags are UTC, without a date that determines the leap seconds; write them as GPS seconds of the "
             "week "
             "(iUtcOrGpsTime 2)");
    }
    if (const auto bias = at<double>(57); bias != 0) {
      refuse(57, fmt::format("a time-tag bias of {:g} s, whose sign the format leaves open; write 0 there, and state "
                             "`clock: {{offset: … s}}` of the IMU in the configuration",
                             bias));
    }
    return h;
  }

  /// Goes to the next record; false at the end of the file.
  bool next() {
    place = next_;
    if (place == text().size()) return false;
    next_ = std::min(place + kRecordSize, text().size());
    if (next_ - place < kRecordSize) {
      fail(fmt::format("the last record is cut: {} of {} bytes; take them out", next_ - place, kRecordSize),
           RowFault::Kind::kFields);
    }
    return true;
  }

  double time() const {
    const auto t = at<double>(place);
    if (!std::isfinite(t)) fail("the time is not finite", RowFault::Kind::kNotFinite);
    return t;
  }
  Vector3d three(std::size_t offset, double scale) const {
    Vector3d v = scale * Vector3d(at<std::int32_t>(place + offset), at<std::int32_t>(place + offset + 4),
                                  at<std::int32_t>(place + offset + 8));
    if (!v.allFinite()) fail("a value is not finite", RowFault::Kind::kNotFinite);
    return v;
  }

 private:
  std::string_view text() const { return mapped_.text(); }
  template <class T>
  T at(std::size_t offset) const {
    return number_at<T>(text(), offset, order_);
  }
  template <class T>
  int flag(std::size_t offset, int largest, std::string_view what) const {
    const int value = at<T>(offset);
    if (value < 0 || value > largest) refuse(offset, fmt::format("{} stands for {} is expected", value, what));
    return value;
  }
  double positive(std::size_t offset, std::string_view what) const {
    const auto value = at<double>(offset);
    if (!(value > 0 && std::isfinite(value))) {
      refuse(offset, fmt::format("{} is {:g}; a number above zero is expected", what, value));
    }
    return value;
  }
  [[noreturn]] void refuse(std::size_t offset, const std::string& what) const {
    throw DataError(fmt::format("{}: byte {}", file(), offset), what);
  }

  MappedFile mapped_;
  std::endian order_ = std::endian::little;
  std::size_t next_ = kHeaderSize;
};

// Throws if the median interval of the records does not fit the rate in the header.
void check_interval(const ImuRecording& imu, double rate) {
  if (imu.time.size() < 3) return;
  std::vector<double> intervals(imu.time.size() - 1);
  for (std::size_t i = 0; i < intervals.size(); ++i) intervals[i] = imu.time[i + 1] - imu.time[i];
  const double interval = median(std::move(intervals));
  constexpr double kTolerance = 0.1;
  if (std::abs(interval * rate - 1) < kTolerance) return;
  throw DataError(fmt::format("{}: byte 25", imu.file),
                  fmt::format("the header says {:g} Hz, but the records are {:.6f} s apart, {:.4g} Hz; set dDataRateHz "
                              "to that",
                              rate, interval, 1 / interval));
}

}  // namespace

ImuRecording read_imu_imr(const LogFile& log, RowFaults* faults) {
  RecordReader reader(log);
  const ImrHeader header = reader.header();
  ImuRecording imu;
  imu.file = log.file;
  // If only one of the two is given as increments, it is converted to rates, by the rate in the header.
  imu.increments = header.rotation_increments && header.velocity_increments;
  const double gyro_scale =
      header.gyro_scale * kDegree * (header.rotation_increments && !imu.increments ? header.rate : 1);
  const double accel_scale = header.accel_scale * (header.velocity_increments && !imu.increments ? header.rate : 1);
  IncreasingTime increasing(log.order());
  const auto row = [&] {
    const double t = increasing.next(reader.time(), reader);
    const Vector3d gyro = reader.three(8, gyro_scale), accel = reader.three(20, accel_scale);
    if (is_for_use(faults)) check_rate(imu.increments ? header.rate * gyro : gyro, reader);
    imu.time.push_back(t);
    imu.gyro.push_back(gyro);
    imu.accel.push_back(accel);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  if (is_for_use(faults)) check_interval(imu, header.rate);
  return imu;
}

}  // namespace piste::log_formats
