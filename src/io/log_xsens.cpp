#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "log_formats.h"
#include "math/numbers.h"

namespace piste::log_formats {
namespace {

constexpr int kCounts = 65536;

/// Columns of Xsens that are not used: names, or beginnings of names that end in `_`, `[` or `:`.
constexpr std::array<std::string_view, 30> kOthers{"Quat_",
                                                   "q0",
                                                   "q1",
                                                   "q2",
                                                   "q3",
                                                   "Mat[",
                                                   "Roll",
                                                   "Pitch",
                                                   "Yaw",
                                                   "Euler_",
                                                   "VelInc_",
                                                   "OriInc_",
                                                   "FreeAcc_",
                                                   "Latitude",
                                                   "Longitude",
                                                   "Altitude",
                                                   "Alt",
                                                   "Vel_",
                                                   "Pos_",
                                                   "Status",
                                                   "StatusWord",
                                                   "SampleTimeFine",
                                                   "SampleTimeCoarse",
                                                   "UTC_",
                                                   "Pressure",
                                                   "GPS_",
                                                   "GNSS_",
                                                   "ClippingFlags",
                                                   "RSSI",
                                                   "ANALOG_"};

bool is_other(std::string_view column) {
  return std::any_of(kOthers.begin(), kOthers.end(), [&](std::string_view name) {
    const bool beginning = name.ends_with('_') || name.ends_with('[');
    return beginning ? column.starts_with(name) : column == name;
  });
}

/// The rate [Hz] from a comment `// Sample rate: 50.0Hz` or `// Update Rate: 100.0Hz`, or nothing for another comment.
std::optional<double> rate_of(const TextReader& reader) {
  constexpr double kSlowest = 0.01, kFastest = 1e5;  // Hz
  std::string_view text = reader.line();
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) return std::nullopt;
  std::string name(text.substr(0, colon));
  std::transform(name.begin(), name.end(), name.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  if (!name.ends_with("sample rate") && !name.ends_with("update rate")) return std::nullopt;
  text.remove_prefix(std::min(text.find_first_not_of(" \t", colon + 1), text.size()));
  double rate = 0;
  const auto [end, error] = read_number(text.data(), text.data() + text.size(), rate);
  if (error != std::errc{} || !(rate >= kSlowest && rate <= kFastest)) {
    throw DataError(reader.where(), fmt::format("`{}` is no rate; such as `// Sample rate: 50.0Hz` is expected", text));
  }
  return rate;
}

/// The places of the columns that are read.
struct Columns {
  std::size_t count = 0, counter = 0;
  std::array<std::size_t, 3> gyro{}, accel{};
  std::optional<std::array<std::size_t, 3>> magnetic;
  std::optional<std::size_t> temperature;
};

/// The line of column names. An error in it always ends the reading.
class ColumnNames {
 public:
  ColumnNames(const TextReader& reader, const std::vector<std::string>& ignored) : where_(reader.where()) {
    for (const std::string_view name : reader.fields()) names_.emplace_back(name);
    if (!names_.empty() && names_.back().empty()) names_.pop_back();
    for (const std::string& name : ignored) {
      if (!place(name)) fail(fmt::format("there is no column `{}` to ignore", name));
    }
    for (auto name = names_.begin(); name != names_.end(); ++name) {
      if (std::find(names_.begin(), name, *name) != name) fail(fmt::format("column `{}` stands twice", *name));
    }
    known_.assign(names_.size(), false);
    for (std::size_t i = 0; i < names_.size(); ++i) {
      known_[i] = is_other(names_[i]) || std::find(ignored.begin(), ignored.end(), names_[i]) != ignored.end();
    }
  }

  Columns columns() {
    Columns c;
    c.count = names_.size();
    c.counter = any({"Counter", "PacketCounter"});
    c.accel = triad("Acc");
    c.gyro = triad("Gyr");
    if (place("Mag_X")) c.magnetic = triad("Mag");
    for (const char* name : {"Temperature", "Temp"}) {
      if (place(name)) c.temperature = any({name});
    }
    const auto unknown = std::find(known_.begin(), known_.end(), false);
    if (unknown != known_.end()) {
      fail(fmt::format("unknown column `{}`; name it in `ignore_columns`",
                       names_[static_cast<std::size_t>(unknown - known_.begin())]));
    }
    return c;
  }

 private:
  std::optional<std::size_t> place(std::string_view name) const {
    const auto found = std::find(names_.begin(), names_.end(), name);
    if (found == names_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - names_.begin());
  }
  std::size_t any(std::initializer_list<std::string_view> choices) {
    for (const std::string_view name : choices) {
      if (const auto at = place(name)) {
        known_[*at] = true;
        return *at;
      }
    }
    fail(fmt::format("column {} is missing; the columns are: {}", fmt::join(choices, " or "), fmt::join(names_, ", ")));
  }
  std::array<std::size_t, 3> triad(std::string_view sensor) {
    return {any({fmt::format("{}_X", sensor)}), any({fmt::format("{}_Y", sensor)}), any({fmt::format("{}_Z", sensor)})};
  }
  [[noreturn]] void fail(const std::string& what) const { throw DataError(where_, what); }

  std::string where_;
  std::vector<std::string> names_;
  std::vector<bool> known_;
};

Vector3d three(const TextReader& reader, const std::array<std::size_t, 3>& places) {
  return {reader.number(places[0]), reader.number(places[1]), reader.number(places[2])};
}

/// Unwraps the 16-bit packet counter.
class PacketCounter {
 public:
  explicit PacketCounter(bool repair) : repair_(repair) {}
  /// Packets since the first.
  double next(const TextReader& reader, std::size_t field) {
    const double counter = reader.number(field);
    if (!(counter >= 0 && counter < kCounts && counter == std::floor(counter))) {
      reader.fail(
          fmt::format("counter `{}`; a whole number from 0 to {} is expected", reader.fields()[field], kCounts - 1));
    }
    const int now = static_cast<int>(counter), last = last_ < 0 ? now : last_;
    int passed = (now - last + kCounts) % kCounts;
    if (last_ >= 0 && passed == 0 && !repair_) {
      reader.fail(
          fmt::format("the counter stands still at {}; keep each row once, or let piste do so: `repair: true`", now),
          RowFault::Kind::kTimeRepeated);
    }
    if (passed > kCounts / 2 && repair_) passed -= kCounts;
    if (passed > kCounts / 2) {
      reader.fail(fmt::format("the counter goes back from {} to {}; are the rows in order, and of one log? If so, "
                              "`repair: true` sorts them",
                              last, now),
                  RowFault::Kind::kTimeBack);
    }
    last_ = now;
    count_ += passed;
    return count_;
  }

 private:
  int last_ = -1;  // none yet
  double count_ = 0;
  bool repair_;
};

}  // namespace

ImuRecording read_imu_xsens(const LogFile& log, RowFaults* faults) {
  TextReader reader(log.file, TextReader::Separator::kTab, log.content);
  std::optional<double> rate;
  bool more = reader.next();
  for (; more && reader.line().starts_with("//"); more = reader.next()) {
    if (const auto found = rate_of(reader)) rate = found;
  }
  if (!more) throw DataError(log.file, "holds no line of column names, such as Counter, Acc_X …, Gyr_X …");
  if (!rate) {
    throw DataError(
        reader.where(),
        "no rate stands above the columns; add the line `// Sample rate: 50.0Hz`, with the rate at which the "
        "sensor was set to send");
  }
  const Columns columns = ColumnNames(reader, log.ignore_columns).columns();

  ImuRecording imu;
  imu.file = log.file;
  PacketCounter counter(log.repair);
  const auto row = [&] {
    const auto& fields = reader.fields();
    const bool trailing = fields.size() == columns.count + 1 && fields.back().empty();
    if (fields.size() != columns.count && !trailing) {
      reader.fail(fmt::format("{} fields, but {} columns are named; is the line cut?", fields.size(), columns.count),
                  RowFault::Kind::kFields);
    }
    const Vector3d gyro = three(reader, columns.gyro), accel = three(reader, columns.accel);
    const Vector3d magnetic = columns.magnetic ? three(reader, *columns.magnetic) : Vector3d::Zero();
    const double temperature = columns.temperature ? reader.number(*columns.temperature) : 0;
    if (is_for_use(faults)) check_rate(gyro, reader);
    imu.time.push_back(counter.next(reader, columns.counter) / *rate);
    imu.gyro.push_back(gyro);
    imu.accel.push_back(accel);
    if (columns.magnetic) imu.magnetic.push_back(magnetic);
    if (columns.temperature) imu.temperature.push_back(temperature);
  };
  for_each_row(
      faults, [&] { return reader.next(); }, row);
  return imu;
}

}  // namespace piste::log_formats
