#include "piste/diagnosis/run_warnings.h"

#include <utility>

#include "diagnosis/imu_motion.h"
#include "diagnosis/left_out.h"
#include "diagnosis/setting_doubts.h"
#include "piste/consistency/warnings.h"

namespace piste {

std::vector<std::string> run_warnings(const Log& log, const FilterOptions& options, const Solution& filtered,
                                      const std::vector<Interval>& outages) {
  std::vector<std::string> all = warnings_of(filtered);
  const auto add = [&all](std::vector<std::string> lines) {
    for (std::string& line : lines) all.push_back(std::move(line));
  };
  add(left_out_lines(log, filtered));
  add(imu_motion_lines(log, options.imus));
  add(setting_lines(log, options, outages));
  return all;
}

}  // namespace piste
