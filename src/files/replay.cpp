#include "piste/files/replay.h"

#include <fmt/format.h>

#include <array>
#include <string_view>
#include <tuple>

namespace piste {

void RowFiles::begin(const StateLayout& layout) {
  const std::array files{std::tuple("filtered.csv", RowFile::kNavigation, rates_.navigation),
                         std::tuple("biases.csv", RowFile::kBiases, rates_.biases),
                         std::tuple("attitude.csv", RowFile::kAttitude, rates_.attitude)};
  files_.reserve(files.size());  // the writers keep their addresses
  for (const auto& [name, kind, rate] : files) {
    OutputFile& file = files_.emplace_back(output_.open(name));
    writers_.emplace_back(kind, layout, rate, [&file](std::string_view piece) { file.write(piece); });
  }
}

void RowFiles::add(const Solution& rows) {
  if (files_.empty()) begin(rows.layout());
  for (RowCsv& writer : writers_) writer.add(rows);
  means_.add(rows);
}

void RowFiles::finish() {
  for (RowCsv& writer : writers_) writer.finish();
  for (OutputFile& file : files_) file.close();
  writers_.clear();
}

void write_solutions(OutputFolder& output, const Replay& run, const OutputRates& rates,
                     const std::function<void(double)>& progress, RowFiles* rows) {
  const Solution& filtered = run.filtered.solution;
  const int files = run.smoothed ? 6 : 4;
  int done = 0;
  const auto stream = [&](const std::string& name, const std::function<void(const TextSink&)>& pieces) {
    if (progress) progress(static_cast<double>(done++) / files);
    output.stream(name, pieces);
  };
  const bool written = rows != nullptr && rows->begun();
  if (written) rows->finish();
  if (!written) stream("filtered.csv", [&](const TextSink& sink) { navigation_csv(filtered, rates.navigation, sink); });
  if (!written) stream("biases.csv", [&](const TextSink& sink) { biases_csv(filtered, rates.biases, sink); });
  stream("innovations.csv", [&](const TextSink& sink) { innovations_csv(filtered, sink); });
  if (filtered.adapted.names.empty()) {
    output.withdraw("adapted.csv");
  } else {
    output.write("adapted.csv", adapted_csv(filtered.adapted));
  }
  if (run.smoothed) {
    stream("smoothed.csv", [&](const TextSink& sink) { navigation_csv(*run.smoothed, rates.navigation, sink); });
    stream("biases_smoothed.csv", [&](const TextSink& sink) { biases_csv(*run.smoothed, rates.biases, sink); });
  } else {
    output.withdraw("smoothed.csv");
    output.withdraw("biases_smoothed.csv");
  }
  if (!written)
    stream("attitude.csv", [&](const TextSink& sink) { sink(attitude_csv(run.solution(), rates.attitude)); });
}

std::string attitude_entry(const std::filesystem::path& file, const Solution& smoothed) {
  const double tau = smoothed.attitude_correlation_time, all = smoothed.time(smoothed.size() - 1) - smoothed.time(0);
  return fmt::format("as a reference for another replay: `attitude: {{file: {}, correlation_time: {:.1f} s}}`{}",
                     std::filesystem::absolute(file).lexically_normal().string(), tau,
                     tau < 0.999 * all ? "" : ", the length of the log: the error does not fade within it");
}

}  // namespace piste
