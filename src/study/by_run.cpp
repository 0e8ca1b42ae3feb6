#include "study/by_run.h"

#include <cstddef>
#include <map>

#include "piste/math/statistics.h"

namespace piste {

std::vector<double> mean_by_run(const std::vector<const SensorRun*>& at, const std::vector<double>& values) {
  std::map<std::size_t, std::vector<double>> runs;
  for (std::size_t i = 0; i < at.size(); ++i) runs[at[i]->run].push_back(values[i]);
  std::vector<double> out;
  out.reserve(runs.size());
  for (const auto& [run, of_sensors] : runs) out.push_back(mean(of_sensors));
  return out;
}

}  // namespace piste
