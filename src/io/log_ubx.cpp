#include <fmt/format.h>

#include <cmath>
#include <cstdint>
#include <optional>

#include "byte_reader.h"
#include "log_formats.h"
#include "log_week.h"
#include "math/time.h"

namespace piste::log_formats {
namespace {

constexpr std::string_view kSync = "\xB5\x62";
constexpr std::size_t kHead = 6, kChecksum = 2;  // sync, class, id, length; and after the payload
constexpr std::size_t kLongestSentence = 1024;

/// Goes through the frames of a file, past the sentences between them.
class FrameReader : public RowSource {
 public:
  explicit FrameReader(const LogFile& log)
      : RowSource(log.file, Counts::kBytes), mapped_(log.content ? MappedFile(*log.content) : MappedFile(log.file)) {}

  /// Goes to the next frame; false at the end of the file. After a frame that cannot be read it continues at the next
  /// sync.
  bool next() {
    while (next_ < text().size()) {
      place = next_;
      const std::string_view rest = text().substr(place);
      if (rest.starts_with(kSync)) {
        take_frame(rest);
        return true;
      }
      const std::size_t length = sentence_length(rest);
      if (length == 0) {
        go_to_sync();
        fail(fmt::format("{} bytes that are neither a UBX frame nor a sentence of NMEA; take them out", next_ - place),
             RowFault::Kind::kText);
      }
      next_ += length;
    }
    return false;
  }

  bool is(std::uint8_t frame_class, std::uint8_t id) const {
    return number_at<std::uint8_t>(text(), place + 2) == frame_class &&
           number_at<std::uint8_t>(text(), place + 3) == id;
  }
  std::string_view payload() const { return payload_; }

 private:
  std::string_view text() const { return mapped_.text(); }

  void take_frame(std::string_view rest) {
    const std::size_t length = rest.size() < kHead ? 0 : number_at<std::uint16_t>(rest, 4);
    if (rest.size() < kHead + length + kChecksum) {
      go_to_sync();
      fail("the frame is cut; take it out", RowFault::Kind::kFields);
    }
    std::uint8_t a = 0, b = 0;  // Fletcher's, of RFC 1145
    for (const char c : rest.substr(2, kHead - 2 + length)) {
      a = static_cast<std::uint8_t>(a + static_cast<std::uint8_t>(c));
      b = static_cast<std::uint8_t>(b + a);
    }
    if (a != number_at<std::uint8_t>(rest, kHead + length) || b != number_at<std::uint8_t>(rest, kHead + length + 1)) {
      go_to_sync();
      fail("the checksum of the frame is wrong; take it out", RowFault::Kind::kChecksum);
    }
    payload_ = rest.substr(kHead, length);
    next_ = place + kHead + length + kChecksum;
  }

  // Length of the sentence at the beginning of `rest`, with its line end; 0 if there is none.
  static std::size_t sentence_length(std::string_view rest) {
    if (!rest.starts_with('$')) return 0;
    const std::size_t end = rest.substr(0, kLongestSentence).find('\n');
    if (end == std::string_view::npos) return 0;
    std::string_view line = rest.substr(0, end);
    if (line.ends_with('\r')) line.remove_suffix(1);
    return nmea_body(line) ? end + 1 : 0;
  }

  void go_to_sync() {
    const std::size_t frame = text().find(kSync, place + 1);
    next_ = std::min({frame, text().find("$G", place + 1), text().find("$P", place + 1), text().size()});
  }

  MappedFile mapped_;
  std::size_t next_ = 0;
  std::string_view payload_;
};

/// NAV-PVT (u-blox 8 / M8 receiver description, 32.17.15). That of generation 7 has only 84 bytes, which include all
/// that is read.
class NavPvt {
 public:
  explicit NavPvt(const FrameReader& frame) : frame_(frame), bytes_(frame.payload()) {
    if (bytes_.size() != 92 && bytes_.size() != 84) {
      frame.fail(fmt::format("NAV-PVT of {} bytes; 92 are expected", bytes_.size()), RowFault::Kind::kFields);
    }
  }

  bool has_fix() const {
    const auto type = at<std::uint8_t>(20);
    return (type == 3 || type == 4) && (flags() & 1) != 0;
  }

  std::uint32_t time() const { return at<std::uint32_t>(0); }

  // The day in UTC, if it is marked as valid.
  std::optional<std::chrono::sys_days> date() const {
    if ((at<std::uint8_t>(11) & 1) == 0) return std::nullopt;
    return day_of(at<std::uint16_t>(4), at<std::uint8_t>(6), at<std::uint8_t>(7));
  }

  // The time of week is rounded to a millisecond; the fraction of the UTC second, that of GPS time too, is not.
  double seconds_of_week() const {
    constexpr double kRounding = 0.6e-3;
    const double rounded = time() * 1e-3;
    if (rounded > kWeek) frame_.fail(fmt::format("time of week {:.3f} s is beyond the week", rounded));
    const bool valid_time = (at<std::uint8_t>(11) & 2) != 0;
    const double off = std::remainder(at<std::int32_t>(16) * 1e-9 - rounded, 1);
    return valid_time && std::abs(off) < kRounding ? rounded + off : rounded;
  }

  FixQuality quality() const {
    switch (flags() >> 6) {
      case 2:
        return FixQuality::kFixed;
      case 1:
        return FixQuality::kFloat;
      default:
        return (flags() & 2) != 0 ? FixQuality::kDifferential : FixQuality::kSingle;
    }
  }

  std::uint8_t satellites() const { return at<std::uint8_t>(23); }

  Geodetic position() const {
    return geodetic_degrees(at<std::int32_t>(28) * 1e-7, at<std::int32_t>(24) * 1e-7, at<std::int32_t>(32) * 1e-3);
  }
  Vector3d sigma_position() const {  // the receiver gives one horizontal value for both axes together
    const double horizontal = at<std::uint32_t>(40) * 1e-3 / std::sqrt(2.0);
    return {horizontal, horizontal, at<std::uint32_t>(44) * 1e-3};
  }
  FixVelocity velocity() const {  // the receiver gives one value for the speed in space
    return {Vector3d(at<std::int32_t>(48), at<std::int32_t>(52), at<std::int32_t>(56)) * 1e-3,
            Vector3d::Constant(at<std::uint32_t>(68) * 1e-3 / std::sqrt(3.0))};
  }

 private:
  template <class T>
  T at(std::size_t offset) const {
    return number_at<T>(bytes_, offset);
  }
  unsigned flags() const { return at<std::uint8_t>(21); }

  const RowSource& frame_;
  std::string_view bytes_;
};

/// NAV-COV (u-blox F9 interface description, 3.15.2): the covariance of the position along north, east, down.
class NavCov {
 public:
  explicit NavCov(const FrameReader& frame) : bytes_(frame.payload()) {
    constexpr std::size_t kSize = 64;
    if (bytes_.size() != kSize) {
      frame.fail(fmt::format("NAV-COV of {} bytes; {} are expected", bytes_.size(), kSize), RowFault::Kind::kFields);
    }
  }

  std::uint32_t time() const { return number_at<std::uint32_t>(bytes_, 0); }
  bool valid() const { return number_at<std::uint8_t>(bytes_, 5) != 0; }
  Matrix3d position() const {
    const auto at = [&](std::size_t i) { return static_cast<double>(number_at<float>(bytes_, 16 + 4 * i)); };
    Matrix3d covariance;
    covariance << at(0), at(1), at(2), at(1), at(3), at(4), at(2), at(4), at(5);
    return covariance;
  }

 private:
  std::string_view bytes_;
};

// Of the fix of the same time; NAV-COV stands after it or before.
void take_covariance(const NavCov& message, GeodeticFix& fix, const LogFile& log) {
  const Matrix3d covariance = message.position();
  if (log.sigma || !message.valid() || !(covariance.diagonal().minCoeff() > 0)) return;
  fix.sigma_position = covariance.diagonal().cwiseSqrt();
  fix.correlation = correlations(covariance);
}

}  // namespace

GnssRecording read_gnss_ubx(const LogFile& log, RowFaults* faults) {
  FrameReader reader(log);
  GnssRecording gnss{log.file, {}};
  IncreasingTime increasing(log.order());
  std::optional<std::uint32_t> last;  // the time of week of the last fix, as it was written
  std::optional<NavCov> before;
  const auto frame = [&] {
    if (reader.is(0x01, 0x36)) {
      const NavCov message(reader);
      if (message.time() == last) take_covariance(message, gnss.fixes.back(), log);
      if (message.time() != last) before = message;
      return;
    }
    if (!reader.is(0x01, 0x07)) return;
    const NavPvt pvt(reader);
    if (!pvt.has_fix()) {
      ++gnss.without_fix;
      return;
    }
    GeodeticFix fix;
    fix.time = increasing.next(pvt.seconds_of_week(), reader);
    fix.position = pvt.position();
    fix.sigma_position = pvt.sigma_position();
    fix.velocity = pvt.velocity();
    fix.quality = pvt.quality();
    fix.satellites = pvt.satellites();
    if (before && before->time() == pvt.time()) take_covariance(*before, fix, log);
    check_fix(fix, log, reader);
    gnss.fixes.push_back(fix);
    last = pvt.time();
  };
  for_each_row(
      faults, [&] { return reader.next(); }, frame);
  return gnss;
}

std::optional<GpsTime> first_time_ubx(const LogFile& log) {
  FrameReader reader(log);
  for (;;) {
    try {
      if (!reader.next()) return std::nullopt;
      if (!reader.is(0x01, 0x07)) continue;
      const NavPvt pvt(reader);
      const auto date = pvt.has_fix() ? pvt.date() : std::nullopt;
      if (!date) continue;
      // The date is that of UTC; the seconds of week are those of GPS.
      const GpsTime midnight = gps_time(*date, kDay / 2, TimeSystem::kUtc);
      const double seconds = pvt.seconds_of_week();
      return GpsTime{midnight.week + static_cast<int>(std::lround((midnight.seconds - seconds) / kWeek)), seconds};
    } catch (const RowError&) {  // a frame that its reader reports
    }
  }
}

// TIM-TM2 (u-blox 8 / M8 receiver description, 32.20.4).
std::vector<GpsTime> ubx_marks(const LogFile& log) {
  constexpr std::size_t kSize = 28;
  constexpr std::uint8_t kRisingEdge = 0x80, kTimeValid = 0x40;
  FrameReader reader(log);
  std::vector<GpsTime> marks;
  while (reader.next()) {
    if (!reader.is(0x0d, 0x03)) continue;
    const std::string_view bytes = reader.payload();
    if (bytes.size() != kSize) {
      reader.fail(fmt::format("TIM-TM2 of {} bytes; {} are expected", bytes.size(), kSize), RowFault::Kind::kFields);
    }
    const auto flags = number_at<std::uint8_t>(bytes, 1);
    if ((flags & kRisingEdge) == 0 || (flags & kTimeValid) == 0) continue;
    const GpsTime time{number_at<std::uint16_t>(bytes, 4),
                       1e-3 * number_at<std::uint32_t>(bytes, 8) + 1e-9 * number_at<std::uint32_t>(bytes, 12)};
    constexpr unsigned kTimeBase = 0x18, kUtc = 0x10;
    marks.push_back((flags & kTimeBase) == kUtc ? gps_time(time, TimeSystem::kUtc) : time);
  }
  return marks;
}

// NAV-RELPOSNED, version 1 (u-blox F9 interface description, 3.15.13): the baseline from the reference antenna to the
// rover's. Frames without a valid heading are no headings.
FixRecording<HeadingFix> read_heading_ubx(const LogFile& log, double sigma) {
  constexpr std::size_t kSize = 64;
  constexpr double kHundredThousandth = 1e-5 * kDegree, kCentimetre = 0.01, kTenthMillimetre = 1e-4;
  FrameReader reader(log);
  FixRecording<HeadingFix> recording{log.file, {}};
  IncreasingTime increasing(log.order());
  while (reader.next()) {
    if (!reader.is(0x01, 0x3c)) continue;
    const std::string_view bytes = reader.payload();
    if (bytes.size() != kSize) {
      reader.fail(fmt::format("NAV-RELPOSNED of {} bytes; {} are expected, of generation 9", bytes.size(), kSize),
                  RowFault::Kind::kFields);
    }
    constexpr std::uint32_t kFixOk = 1, kHeadingValid = 1 << 8;
    const auto flags = number_at<std::uint32_t>(bytes, 60);
    if ((flags & kFixOk) == 0 || (flags & kHeadingValid) == 0) continue;
    const auto along = [&](std::size_t axis) {  // centimetres, and their high-precision part
      return kCentimetre * number_at<std::int32_t>(bytes, 8 + 4 * axis) +
             kTenthMillimetre * number_at<std::int8_t>(bytes, 32 + axis);
    };
    const Vector3d baseline(along(0), along(1), along(2));
    HeadingFix fix;
    fix.time = increasing.next(1e-3 * number_at<std::uint32_t>(bytes, 4), reader);
    fix.heading = kHundredThousandth * number_at<std::int32_t>(bytes, 24);
    const auto stated = number_at<std::uint32_t>(bytes, 52);
    fix.sigma = stated > 0 ? kHundredThousandth * stated : sigma;
    if (baseline.norm() > 0) {
      fix.pitch = std::atan2(-baseline.z(), std::hypot(baseline.x(), baseline.y()));
      fix.sigma_pitch = kTenthMillimetre * number_at<std::uint32_t>(bytes, 44) / baseline.norm();
    }
    recording.fixes.push_back(fix);
  }
  return recording;
}

}  // namespace piste::log_formats
