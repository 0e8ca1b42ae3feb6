#include "piste/core/behaviour.h"

#include <fmt/format.h>

#include "piste/core/error.h"

namespace piste {

void BehaviourOptions::validate() const {
  const auto require = [](bool good, const std::string& what) {
    if (!good) throw ConfigError("", what);
  };
  require(trust.gate > 0 && trust.gate < 1,
          fmt::format("gate {}: a probability between 0 and 1, such as 0.999", trust.gate));
  require(trust.readmit_after >= 0 && trust.distrust >= 0, "trust: readmit_after and distrust must not be below zero");
  require(rest.sigma_velocity > 0 && rest.sigma_rate > 0 && rest.interval > 0 && rest.correlation_time >= 0,
          "rest: sigmas and interval must be above zero, and correlation_time not below");
  require(rest.cell > 0 && rest.window > 0, "rest: cell and window must be above zero");
  require(start.hypotheses > 0 && start.fewest > 0, "start: hypotheses and fewest must be above zero");
  require(gaps.longest > 0 && gaps.block > 0, "gaps: longest and block must be above zero");
}

}  // namespace piste
