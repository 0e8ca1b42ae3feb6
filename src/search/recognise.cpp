#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "io/text_reader.h"
#include "piste/core/error.h"
#include "piste/search/inspect.h"
#include "search/joined.h"

namespace piste {
namespace {

// Guesses what a file is: one log, or an IMU and a receiver in one file.
std::vector<InspectedLog> guessed(const LogSource& source, std::vector<Suspicion>& found) {
  const std::string& file = source.file;
  std::vector<InspectedLog> logs;
  const auto add = [&](std::optional<LogGuess> guess) {
    InspectedLog& l = logs.emplace_back();
    l.log.file = file;
    l.log.content = source.content;
    l.guess = std::move(guess);
    if (!l.guess) return;
    l.log.format = l.guess->format;
    l.log.columns = l.guess->columns;
  };
  try {
    const MappedFile mapped = source.content ? MappedFile(*source.content) : MappedFile(file);
    LogGuess guess = guess_log(file, mapped.text());
    if (!guess.lost.empty()) {
      found.push_back(
          {LogFault::kNotUsed, file, guess.lost, "name them so in the header, such as `height_m`, `time_s`"});
    }
    std::vector<LogGuess> others = std::move(guess.beside);
    add(std::move(guess));
    for (LogGuess& other : others) add(std::move(other));
  } catch (const DataError& e) {
    found.push_back({LogFault::kUnreadable, file, e.what(), "piste cannot use this file as it is"});
    add(std::nullopt);
  }
  return logs;
}

// Whether a log is such a part. Only files are joined: a log names the file of its accelerometers.
bool is_part(const InspectedLog& l, LogGuess::Part part) { return l.guess && l.guess->part == part && !l.log.content; }

// Makes one log of gyroscopes and the accelerometers in another file.
void join_parts(InspectedLog& gyro, InspectedLog& accel) {
  gyro.log.accel_file = accel.log.file;
  gyro.log.gravity_file = accel.log.gravity_file;
  gyro.log.columns->uses["accel"] = accel.log.columns->uses.at("accel");
  gyro.log.columns->accel_time = accel.log.columns->time;
  gyro.log.columns->accel_rows = accel.log.columns->rows;
  gyro.guess->why += "; the accelerometers stand in " + accel.log.file;
  if (!accel.log.gravity_file.empty()) gyro.guess->why += ", and gravity in " + accel.log.gravity_file;
  gyro.guess->guessed_sign = accel.guess->guessed_sign;
  append(gyro.guess->doubts, std::move(accel.guess->doubts));
  for (const InspectedLog* l : {&gyro, &accel}) {
    if (!l->guess->aside.empty()) gyro.guess->doubts.push_back(l->log.file + ": " + l->guess->aside);
  }
  gyro.guess->part = LogGuess::Part::kWhole;
  accel.log.file.clear();
  accel.guess.reset();
}

// Adds gravity to accelerations without it. Faults of the linear accelerations alone do not matter then.
void add_gravity(InspectedLog& linear, InspectedLog& gravity) {
  ColumnUse& use = linear.log.columns->uses.at("accel");
  const ColumnUse& added = gravity.log.columns->uses.at("accel");
  if (use.axes.empty()) {
    linear.guess->guessed_sign = true;
    linear.guess->doubts.emplace_back(
        "accel: the sign of the forces is to be checked: that of Android is taken, and iOS writes minus that");
  }
  use.added = added.names;
  use.unit = added.unit;
  linear.log.gravity_file = gravity.log.file;
  append(linear.guess->doubts, std::move(gravity.guess->doubts));
  linear.guess->aside.clear();
  linear.guess->part = LogGuess::Part::kAccel;
  gravity.log.file.clear();
  gravity.guess.reset();
}

// Joins forces that a fusion has split into two files, if no other file has the whole force.
void join_forces(std::vector<InspectedLog>& logs) {
  using Part = LogGuess::Part;
  const auto find = [&](Part part) {
    return std::find_if(logs.begin(), logs.end(), [part](const InspectedLog& l) { return is_part(l, part); });
  };
  const auto linear = find(Part::kLinear), gravity = find(Part::kGravity);
  const bool whole = std::any_of(logs.begin(), logs.end(), [](const InspectedLog& l) {
    return is_part(l, Part::kAccel) && l.guess->aside.empty();
  });
  if (whole || linear == logs.end() || gravity == logs.end()) return;
  const ColumnMap &one = *linear->log.columns, &other = *gravity->log.columns;
  if (one.time == other.time && one.rows == other.rows) add_gravity(*linear, *gravity);  // both are read alike
}

// Whether a file is the metadata of Sensor Logger, and says that the forces have the sign that iOS gives them.
bool says_reversed(const LogSource& source) {
  const MappedFile mapped = source.content ? MappedFile(*source.content) : MappedFile(source.file);
  constexpr std::size_t kMost = 4096;
  TextReader reader("", TextReader::Separator::kComma, mapped.text().substr(0, kMost));
  if (!reader.next()) return false;
  const std::vector<std::string_view> names = reader.fields();
  if (!reader.next() || reader.fields().size() != names.size()) return false;
  const auto value = [&](std::string_view name) {
    const auto place = std::find(names.begin(), names.end(), name);
    return place == names.end() ? std::string_view() : reader.fields()[static_cast<std::size_t>(place - names.begin())];
  };
  return value("platform") == "ios" && value("standardisation") == "false";
}

// Gives the forces of a phone the sign of specific force.
void reverse_forces(std::vector<InspectedLog>& logs) {
  for (InspectedLog& l : logs) {
    if (!l.guess || !l.log.columns || !l.log.columns->uses.contains("accel")) continue;
    l.log.columns->uses.at("accel").axes = {"-x", "-y", "-z"};
    l.guess->columns = l.log.columns;
    if (l.guess->part == LogGuess::Part::kGravity) continue;  // added to the other: one doubt is enough
    l.guess->doubts.emplace_back(
        "accel: reversed, as iOS writes it and the metadata say: platform ios, not standardised");
  }
}

bool has_forces(const InspectedLog& l) {
  return is_part(l, LogGuess::Part::kAccel) || is_part(l, LogGuess::Part::kLinear) ||
         is_part(l, LogGuess::Part::kGravity);
}

// Pairs gyroscopes and accelerometers that are in two files, with times of one kind. Phones write several of each; the
// preferred ones go first. The others are left aside, and reported.
void pair_up(std::vector<InspectedLog>& logs, std::vector<Suspicion>& found) {
  using Part = LogGuess::Part;
  join_forces(logs);
  bool paired = false;
  for (const bool preferred : {true, false}) {
    for (InspectedLog& gyro : logs) {
      const auto is_preferred = [&](const InspectedLog& l) { return !preferred || l.guess->aside.empty(); };
      if (!is_part(gyro, Part::kGyro) || !is_preferred(gyro) || (paired && !preferred)) continue;
      const auto accel = std::find_if(logs.begin(), logs.end(), [&](const InspectedLog& l) {
        return has_forces(l) && is_preferred(l) && l.log.columns->time.of == gyro.log.columns->time.of;
      });
      if (accel == logs.end()) continue;
      join_parts(gyro, *accel);
      paired = true;
    }
  }
  std::erase_if(logs, [](const InspectedLog& l) { return l.log.file.empty(); });
  for (InspectedLog& l : logs) {
    if (!l.guess || l.guess->part == Part::kWhole) continue;
    if (l.guess->part == Part::kNone || (paired && !l.guess->aside.empty())) {
      l.left_out = l.guess->aside;
      found.push_back({LogFault::kNotUsed, l.log.file, l.left_out, "it is left aside"});
    } else {
      const bool gyro = l.guess->part == Part::kGyro;
      found.push_back(
          {LogFault::kUnreadable, l.log.file,
           fmt::format("{}:1: has {} alone, and no file beside it has the {} at times of the same kind", l.log.file,
                       gyro ? "gyroscopes" : "accelerometers", gyro ? "accelerometers" : "gyroscopes"),
           "name both files"});
    }
    l.guess.reset();
  }
}
}  // namespace

std::vector<InspectedLog> recognise(const std::vector<LogSource>& sources, std::vector<Suspicion>& found) {
  std::vector<InspectedLog> logs;
  for (const LogSource& source : sources) append(logs, guessed(source, found));
  if (std::any_of(sources.begin(), sources.end(), says_reversed)) reverse_forces(logs);
  pair_up(logs, found);
  return logs;
}

std::vector<InspectedLog> recognise(const std::vector<std::string>& files, std::vector<Suspicion>& found) {
  return recognise(sources_of(files), found);
}

}  // namespace piste
