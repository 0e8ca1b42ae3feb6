#include "piste/files/replay.h"

#include <fmt/format.h>

#include "piste/io/solution_io.h"

namespace piste {

void write_solutions(OutputFolder& output, const Replay& run, double attitude_rate) {
  output.write("filtered.csv", navigation_csv(run.filtered.solution));
  output.write("biases.csv", biases_csv(run.filtered.solution));
  output.write("innovations.csv", innovations_csv(run.filtered.solution));
  const AdaptedNoise& adapted = run.filtered.solution.adapted;
  if (adapted.names.empty()) {
    output.withdraw("adapted.csv");
  } else {
    output.write("adapted.csv", adapted_csv(adapted));
  }
  if (run.smoothed) {
    output.write("smoothed.csv", navigation_csv(*run.smoothed));
    output.write("biases_smoothed.csv", biases_csv(*run.smoothed));
  } else {
    output.withdraw("smoothed.csv");
    output.withdraw("biases_smoothed.csv");
  }
  output.write("attitude.csv", attitude_csv(run.solution(), attitude_rate));
}

std::string attitude_entry(const std::filesystem::path& file, const Solution& smoothed) {
  const double tau = smoothed.attitude_correlation_time, all = smoothed.time(smoothed.size() - 1) - smoothed.time(0);
  return fmt::format("as a reference for another replay: `attitude: {{file: {}, correlation_time: {:.1f} s}}`{}",
                     std::filesystem::absolute(file).lexically_normal().string(), tau,
                     tau < 0.999 * all ? "" : ", the length of the log: the error does not fade within it");
}

}  // namespace piste
