#include "piste/solve/rest_updates.h"

#include <utility>

namespace piste {

std::optional<RestFix> RestUpdates::add(const ImuSample& sample, const RestOptions& options) {
  if (!sample.at_rest || sample.gap) {
    *this = {};
    return std::nullopt;
  }
  turn_ += sample.dtheta;
  time_ += sample.interval;
  if (time_ < options.interval - 0.5 * sample.interval) return std::nullopt;
  const RestUpdates full = std::exchange(*this, {});
  return RestFix{sample.time, full.time_, full.turn_ / full.time_};
}

}  // namespace piste
