#include "piste/files/replay.h"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "files/points.h"
#include "io/log_week.h"
#include "math/geoid.h"
#include "math/task_queue.h"
#include "math/time.h"
#include "piste/core/error.h"
#include "points/body_motion.h"

namespace piste {

constexpr std::size_t kWaiting = 4;  // pieces of rows, some megabytes each

RowFiles::RowFiles(OutputFolder& output, const OutputRates& rates, SmootherKind smoother, bool in_thread,
                   std::function<RowExtras(double time)> extras)
    : output_(output),
      rates_(rates),
      extras_(std::move(extras)),
      smoothed_(smoother == SmootherKind::kRts),
      behind_(in_thread ? std::make_unique<TaskQueue>(kWaiting) : nullptr) {}

RowFiles::~RowFiles() = default;

RowStreams RowFiles::streams() {
  return {.filtered = [this](const Solution& rows, std::size_t) { add(rows, false); },
          .smoothed = [this](const Solution& rows, std::size_t) { add(rows, true); },
          .scratch = smoothed_ ? output_.folder() : std::filesystem::path(),
          .rate = rates_.navigation};
}

void RowFiles::begin(const Solution& rows, bool smoothed) {
  const RowExtras extras = extras_ ? extras_(rows.time(0)) : RowExtras{};
  Rows& to = solutions_[smoothed ? 1 : 0];
  constexpr std::size_t kMost = 3;
  to.files.reserve(kMost);  // the writers keep their addresses
  const auto open = [&](const std::string& name, RowFile kind, double rate) {
    OutputFile& file = to.files.emplace_back(output_.open(name));
    to.writers.emplace_back(
        kind, rows.layout(), rate, [&file](std::string_view piece) { file.write(piece); }, extras);
  };
  open(smoothed ? "smoothed.csv" : "filtered.csv", RowFile::kNavigation, rates_.navigation);
  open(smoothed ? "biases_smoothed.csv" : "biases.csv", RowFile::kBiases, rates_.biases);
  if (smoothed == smoothed_) open("attitude.csv", RowFile::kAttitude, rates_.attitude);
}

void RowFiles::add(const Solution& rows, bool smoothed) {
  Rows& to = solutions_[smoothed ? 1 : 0];
  if (to.files.empty()) begin(rows, smoothed);
  if (!behind_) return write(rows, smoothed);
  const auto copy = std::make_shared<Solution>(rows.layout(), rows.world());
  copy->fixed = rows.fixed;
  copy->append(rows.rows());
  behind_->add([this, copy, smoothed] { write(*copy, smoothed); });
}

void RowFiles::write(const Solution& rows, bool smoothed) {
  for (RowCsv& writer : solutions_[smoothed ? 1 : 0].writers) writer.add(rows);
  if (smoothed == smoothed_) means_.add(rows);
}

void RowFiles::finish() {
  if (behind_) behind_->finish();
  for (Rows& rows : solutions_) {
    for (RowCsv& writer : rows.writers) writer.finish();
    for (OutputFile& file : rows.files) file.close();
    rows.writers.clear();
  }
}

void write_solutions(OutputFolder& output, const Replay& run, const OutputRates& rates,
                     const std::function<void(double)>& progress, RowFiles* rows, const RowExtras& extras) {
  const Solution& filtered = run.filtered.solution;
  const int files = run.smoothed ? 6 : 4;
  int done = 0;
  const auto stream = [&](const std::string& name, const std::function<void(const TextSink&)>& pieces) {
    if (progress) progress(static_cast<double>(done++) / files);
    output.stream(name, pieces);
  };
  const bool written = rows != nullptr && rows->begun();
  if (written) rows->finish();
  if (!written)
    stream("filtered.csv", [&](const TextSink& sink) { navigation_csv(filtered, rates.navigation, sink, extras); });
  if (!written) stream("biases.csv", [&](const TextSink& sink) { biases_csv(filtered, rates.biases, sink); });
  stream("innovations.csv", [&](const TextSink& sink) { innovations_csv(filtered, sink); });
  if (filtered.adapted.names.empty()) {
    output.withdraw("adapted.csv");
  } else {
    output.write("adapted.csv", adapted_csv(filtered.adapted));
  }
  if (run.smoothed && !written) {
    stream("smoothed.csv",
           [&](const TextSink& sink) { navigation_csv(*run.smoothed, rates.navigation, sink, extras); });
    stream("biases_smoothed.csv", [&](const TextSink& sink) { biases_csv(*run.smoothed, rates.biases, sink); });
  }
  if (!run.smoothed) {
    output.withdraw("smoothed.csv");
    output.withdraw("biases_smoothed.csv");
  }
  if (!written)
    stream("attitude.csv", [&](const TextSink& sink) { sink(attitude_csv(run.solution(), rates.attitude)); });
}

void write_asked(OutputFolder& output, const Replay& run, const ReplayConfig& config, const RowExtras& extras) {
  write_points(output, run, config, extras);
  write_events(output, run, config, extras.week);
}

std::optional<int> gps_week(const ReplayConfig& config, double time) {
  std::vector<const LogFile*> logs{&config.imu.log};
  for (const LogFile& log : config.gnss) logs.push_back(&log);
  for (const LogFile& log : config.attitude) logs.push_back(&log);
  for (const LogFile* log : logs) {
    // The run's times count from the week in which the IMU's log begins.
    if (const auto first = first_gps_time(*log)) {
      return first->week + static_cast<int>(std::lround((first->seconds - time) / kWeek));
    }
  }
  return config.output.week;
}

RowExtras row_extras(const ReplayConfig& config, std::optional<int> week, const Log* log) {
  RowExtras extras = config.output.columns;
  extras.week = week;
  if (extras.time != RowTime::kSeconds && !week) {
    throw DataError(config.file.string(),
                    "`output: {time: …}` needs the GPS week, which the logs do not state; state it: `week: 2374`");
  }
  if (extras.sea_height && !has_geoid()) {
    throw DataError(config.file.string(),
                    "`output: {geoid: egm96}` needs a geoid, with which this build was not made: "
                    "install Debian's proj-data and build anew, or run geographiclib-get-geoids "
                    "egm96-5");
  }
  if (log != nullptr) extras.motion = SampleMotion(*log);
  return extras;
}

std::string attitude_entry(const std::filesystem::path& file, const Solution& smoothed) {
  const double tau = smoothed.attitude_correlation_time, all = smoothed.time(smoothed.size() - 1) - smoothed.time(0);
  return fmt::format("as a reference for another replay: `attitude: {{file: {}, correlation_time: {:.1f} s}}`{}",
                     std::filesystem::absolute(file).lexically_normal().string(), tau,
                     tau < 0.999 * all ? "" : ", the length of the log: the error does not fade within it");
}

}  // namespace piste
