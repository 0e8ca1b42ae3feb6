#include "walker/rest_updates.h"

#include <utility>

namespace piste {

std::optional<RestFix> RestUpdates::add(const ImuSample& sample, const RestOptions& options) {
  if (!sample.at_rest || sample.gap) {
    *this = {};
    return std::nullopt;
  }
  if (withdrawn_) return std::nullopt;
  turn_ += sample.dtheta;
  time_ += sample.interval;
  if (time_ < options.interval - 0.5 * sample.interval) return std::nullopt;
  const Vector3d turn = std::exchange(turn_, Vector3d::Zero());
  const double time = std::exchange(time_, 0);
  return RestFix{sample.time, time, turn / time};
}

void RestUpdates::judge(bool used, const RestOptions& options) {
  refused_ = used ? 0 : refused_ + 1;
  if (refused_ >= options.patience) withdrawn_ = true;
}

}  // namespace piste
