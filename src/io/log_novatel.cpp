#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "gps_time.h"
#include "io/fix_quality.h"
#include "io/novatel_ascii.h"
#include "log_formats.h"
#include "piste/math/earth.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"

namespace piste::log_formats {
namespace {

constexpr double two_to(int power) { return power < 0 ? two_to(power + 1) / 2 : power > 0 ? 2 * two_to(power - 1) : 1; }

/// What one count of an IMU stands for, by the number of its type.
struct CountScale {
  int type;
  double turn, velocity;  ///< rad and m/s
};

// NovAtel, OEM7 Commands and Logs, "Raw IMU Scale Factors". Epson's count rates, of as many samples a second.
constexpr double kFoot = 0.3048, kArcsecond = kDegree / 3600;
constexpr CountScale honeywell(int type, double velocity) { return {type, two_to(-33), velocity}; }
constexpr CountScale epson(int type, double turn, double milli_g, double rate) {
  return {type, turn * kDegree * two_to(-16) / rate, milli_g * 1e-3 * kStandardGravity * two_to(-16) / rate};
}
constexpr std::array kScales{
    honeywell(1, two_to(-27) * kFoot),                                  // HG1700-AG11
    honeywell(4, two_to(-26) * kFoot),                                  // HG1700-AG17
    honeywell(5, two_to(-27) * kFoot),                                  // HG1900-CA29
    CountScale{8, two_to(-19), two_to(-14)},                            // LN200
    honeywell(11, two_to(-27) * kFoot),                                 // HG1700-AG58
    honeywell(12, two_to(-26) * kFoot),                                 // HG1700-AG62
    CountScale{13, 0.1 * two_to(-8) * kArcsecond, 0.05 * two_to(-15)},  // iMAR FSAS
    CountScale{16, 0.1 / (3600 * 256), 0.05 * two_to(-15)},             // KVH, of CPT
    honeywell(20, two_to(-27) * kFoot),                                 // HG1930-AA99
    CountScale{26, 1e-9, 2e-8},                                         // ISA-100C
    honeywell(27, two_to(-27) * kFoot),                                 // HG1900-CA50
    honeywell(28, two_to(-27) * kFoot),                                 // HG1930-CA50
    CountScale{31, 720 * kDegree* two_to(-31), 200 * two_to(-31)},      // ADIS16488
    CountScale{32, two_to(-21) * kDegree, two_to(-22)},                 // STIM300
    CountScale{33, 0.1 / (3600 * 256), 0.05 * two_to(-15)},             // KVH 1750
    epson(41, 0.008, 0.2, 125),                                         // G320N
    CountScale{52, 1e-9, 2e-8},                                         // Litef µIMU
    CountScale{56, two_to(-21) * kDegree, two_to(-22)},                 // STIM300D
    honeywell(58, two_to(-29)),                                         // HG4930-AN01
    epson(61, 0.0151515, 0.4, 200),                                     // G370N
    epson(62, 0.008, 0.2, 200),                                         // G320N
    honeywell(68, two_to(-29)),                                         // HG4930-AN04
    honeywell(69, two_to(-29)),                                         // HG4930-AN04, 400 Hz
};

const CountScale& scale_of(const TextReader& reader, double type) {
  const auto* const found =
      std::find_if(kScales.begin(), kScales.end(), [type](const CountScale& s) { return s.type == type; });
  if (found != kScales.end()) return *found;
  std::vector<int> known;
  known.reserve(kScales.size());
  for (const CountScale& s : kScales) known.push_back(s.type);
  reader.fail(fmt::format("what a count of the IMU of type {:g} stands for is not known; it is of the types {}", type,
                          fmt::join(known, " ")));
}

// Refuses rows that the IMU itself marks.
void require_valid(const TextReader& reader, std::string_view info) {
  const bool hex = info.size() == 2 && info.find_first_not_of("0123456789abcdefABCDEF") == std::string_view::npos;
  if (!hex) reader.fail(fmt::format("`{}` is no info of an IMU; two hexadecimal digits are expected", info));
  constexpr std::string_view kClear = "048cC";  // last digits without bits 0, an error, and 1, encrypted data
  if (kClear.find(info[1]) == std::string_view::npos) {
    reader.fail(fmt::format("the IMU marks the row as not valid (info {})", info), RowFault::Kind::kText);
  }
}

FixQuality quality_of(const TextReader& reader, std::string_view type) {
  if (type.starts_with("INS_")) {
    reader.fail(
        fmt::format("{} is a solution of the receiver's own filter, in which an IMU is already; log "
                    "BESTGNSSPOSA and BESTGNSSVELA",
                    type));
  }
  if (type == "SINGLE") return FixQuality::kSingle;
  if (type == "WAAS" || type == "SBAS") return FixQuality::kSbas;
  if (type == "PSRDIFF" || type == "OMNISTAR") return FixQuality::kDifferential;
  if (type.starts_with("PPP")) return FixQuality::kPrecise;
  if (type.ends_with("_FLOAT")) return FixQuality::kFloat;
  if (type.ends_with("_INT")) return FixQuality::kFixed;
  return FixQuality::kUnknown;
}

/// Joins positions and velocities of the same times, in either order.
class NovatelFixes {
 public:
  NovatelFixes(const LogFile& log, TextReader& reader)
      : log_(log), reader_(reader), solution_(novatel_solution(reader.rest())), times_(log.order()) {
    gnss_.file = log.file;
  }

  /// Takes the present line.
  void take() {
    const auto line = novatel_log(reader_);
    if (!line || solution_.empty() || !line->name.starts_with(solution_)) return;
    const std::string_view kind = line->name.substr(solution_.size());
    if (kind == "POSA") take_position(*line);
    if (kind == "VELA" && log_.sigma_velocity) take_velocity(*line);
  }

  GnssRecording finish() {
    gnss_.velocity_latency = latencies_.empty() ? 0 : median(latencies_);
    std::size_t next = 0;
    for (GeodeticFix& fix : gnss_.fixes) {  // one delay is estimated, and velocities with another are none
      constexpr double kSame = 0.02;        // s
      if (fix.velocity && std::abs(latencies_[next++] - gnss_.velocity_latency) > kSame) fix.velocity.reset();
    }
    return std::move(gnss_);
  }

 private:
  struct Velocity {
    GpsTime time;
    Vector3d value;
    double latency;
  };

  void take_position(const NovatelLog& line) {
    const GpsTime time = header_time(reader_, line);
    split_fields(reader_, line, 21);
    const auto& fields = reader_.fields();
    if (fields[0] != "SOL_COMPUTED" || fields[1] == "PROPAGATED") {
      ++gnss_.without_fix;
      return;
    }
    if (fields[6] != "WGS84") reader_.fail(fmt::format("the datum is {}; WGS84 is expected", fields[6]));
    GeodeticFix fix;
    fix.quality = quality_of(reader_, fields[1]);
    fix.satellites = satellites_of(number_in(fields[14], TextReader::Separator::kComma).value_or(0));
    fix.position =
        geodetic_degrees(reader_.number(2), reader_.number(3), reader_.number(4) + reader_.number(5));  // + geoid
    fix.sigma_position = {reader_.number(7), reader_.number(8), reader_.number(9)};
    check_fix(fix, log_, reader_);
    fix.time = times_.next(time, reader_);
    gnss_.fixes.push_back(fix);
    last_ = time;
    join();
  }

  void take_velocity(const NovatelLog& line) {
    const GpsTime time = header_time(reader_, line);
    split_fields(reader_, line, 8);
    const auto& fields = reader_.fields();
    if (fields[0] != "SOL_COMPUTED" || fields[1] == "PROPAGATED") return;
    quality_of(reader_, fields[1]);
    const double speed = reader_.number(4), course = kDegree * reader_.number(5), up = reader_.number(6);
    velocity_ = {time, {speed * std::cos(course), speed * std::sin(course), -up}, reader_.number(2)};
    join();
  }

  void join() {
    if (!velocity_ || !last_ || velocity_->time.week != last_->week || velocity_->time.seconds != last_->seconds ||
        gnss_.fixes.back().velocity)
      return;
    GeodeticFix& fix = gnss_.fixes.back();
    fix.velocity = {velocity_->value, *log_.sigma_velocity};
    latencies_.push_back(velocity_->latency);
  }

  const LogFile& log_;
  TextReader& reader_;
  std::string_view solution_;
  WeekTime times_;
  GnssRecording gnss_;
  std::optional<GpsTime> last_;
  std::optional<Velocity> velocity_;
  std::vector<double> latencies_;  // of the velocities of the fixes
};

}  // namespace

GnssRecording read_gnss_novatel(const LogFile& log, RowFaults* faults) {
  TextReader reader(log.file, TextReader::Separator::kComma, log.content);
  NovatelFixes fixes(log, reader);
  for_each_row(
      faults, [&] { return reader.next(); }, [&] { fixes.take(); });
  return fixes.finish();
}

ImuRecording read_imu_novatel(const LogFile& log, RowFaults* faults) {
  TextReader reader(log.file, TextReader::Separator::kComma, log.content);
  ImuRecording imu;
  imu.file = log.file;
  imu.increments = true;
  WeekTime times(log.order());
  std::optional<double> type;
  std::string untyped;  // the first row without the type of the IMU
  const auto row = [&] {
    const auto line = novatel_log(reader);
    if (!line) return;
    if (untyped.empty() && (line->name == "RAWIMUA" || line->name == "RAWIMUSA")) untyped = reader.where();
    if (line->name != "RAWIMUXA" && line->name != "RAWIMUSXA") return;
    split_fields(reader, *line, 11);
    require_valid(reader, reader.fields()[0]);
    const CountScale& scale = scale_of(reader, reader.number(1));
    if (type.value_or(scale.type) != scale.type) {
      reader.fail(fmt::format("the IMU is of type {}, and of {:g} above; keep the rows of one", scale.type, *type));
    }
    // The log has z, -y and x.
    const auto three = [&](std::size_t field) -> Vector3d {
      return {reader.number(field + 2), -reader.number(field + 1), reader.number(field)};
    };
    const Vector3d dvel = scale.velocity * three(5), dtheta = scale.turn * three(8);
    const double time = times.next(time_of(reader, 2), reader);
    if (is_for_use(faults)) check_turn(dtheta, time, imu, reader);
    type = scale.type;
    imu.time.push_back(time);
    imu.gyro.push_back(dtheta);
    imu.accel.push_back(dvel);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  if (imu.time.empty() && !untyped.empty()) {
    throw DataError(untyped, std::string(kUntypedImu));
  }
  return imu;
}

FixRecording<HeadingFix> read_heading_novatel(const LogFile& log, double sigma) {
  TextReader reader(log.file, TextReader::Separator::kComma, log.content);
  FixRecording<HeadingFix> recording{log.file, {}};
  WeekTime times(log.order());
  while (reader.next()) {
    const auto line = novatel_log(reader);
    if (!line || (line->name != "HEADING2A" && line->name != "HEADINGA")) continue;
    const GpsTime time = header_time(reader, *line);
    reader.split(line->body);
    constexpr std::size_t kLeast = 8;
    if (reader.fields().size() < kLeast) {
      reader.fail(fmt::format("{} fields in {}; is the line cut?", reader.fields().size(), line->name),
                  RowFault::Kind::kFields);
    }
    if (reader.fields()[0] != "SOL_COMPUTED") continue;
    HeadingFix fix;
    fix.time = times.next(time, reader);
    fix.heading = kDegree * reader.number(3);
    fix.pitch = kDegree * reader.number(4);
    const double stated = kDegree * reader.number(6);
    fix.sigma = stated > 0 ? stated : sigma;
    fix.sigma_pitch = kDegree * reader.number(7);
    recording.fixes.push_back(fix);
  }
  return recording;
}

}  // namespace piste::log_formats
