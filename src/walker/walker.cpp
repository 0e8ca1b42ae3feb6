#include "walker/walker.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "core/time_search.h"
#include "model/imu_errors.h"
#include "piste/core/error.h"

namespace piste {
namespace {

// Blocks that the delays depend on.
constexpr std::array kDelayBlocks{Block::kGnssDelay, Block::kVelocityDelay, Block::kAttitudeDelay, Block::kClockDrift};

// s by which an estimated delay may exceed its initial value before its fixes come after the samples.
constexpr double kRoomToGrow = 1;

}  // namespace

Walker::Walker(const FilterOptions& options, StateLayout layout, double start, const Estimate& x) {
  auto setup = std::make_shared<Setup>();
  setup->options = options;
  setup->layout = std::move(layout);
  setup->sources = MeasurementSources(options);
  setup->start = start;
  setup->clock_from = options.clock_from.value_or(start);
  setup->delays_change =
      std::any_of(kDelayBlocks.begin(), kDelayBlocks.end(), [&](Block delay) { return setup->layout.has(delay); });
  delays_.assign(setup->sources.all().size(), 0);
  setup->sources.find_delays(options, setup->layout, x, start - setup->clock_from, delays_);
  const double longest = *std::max_element(delays_.begin(), delays_.end());
  setup->look_ahead = (longest > 0 ? longest + kSameInstant : 0) + (setup->delays_change ? kRoomToGrow : 0);
  setup_ = std::move(setup);
}

void Walker::check(const ImuSample& sample) const {
  const bool later = std::isfinite(sample.time) && (!now_ || sample.time > now_->time);
  if (!later || !(sample.interval > 0) || !sample.dtheta.allFinite() || !sample.dvel.allFinite()) {
    throw DataError(fmt::format("t = {:.6f} s", sample.time),
                    "a sample must be finite, of an interval above zero, and later than the one before it");
  }
}

ImuStep Walker::step(const ImuSample* after, const ImuScales* imu_scales, const Estimate& x) const {
  return without_rest(imu_scales, make_step(before_ ? &*before_ : nullptr, *now_, after), x);
}

}  // namespace piste
