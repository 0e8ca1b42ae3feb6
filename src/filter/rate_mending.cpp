#include "filter/rate_mending.h"

#include <utility>

#include "piste/filter/update.h"

namespace piste {
namespace {

constexpr double kMendable = 1;  // s between attitude fixes over which the body's axes are taken as constant

}  // namespace

std::optional<Transition> RateMending::before(const Linearization& lin, const FilterState& state,
                                              const StateLayout& layout, double bound) {
  const bool recent = state.time - last_fix_ < kMendable;
  last_fix_ = state.time;
  const Matrix3d noise = std::exchange(noise_, Matrix3d::Zero());
  if (!recent || !layout.has(Block::kGyroScale)) return std::nullopt;
  const Update u = innovate(state.P, layout, lin);
  if (!(u.nis <= bound)) return std::nullopt;
  const Matrix3d H = u.H.middleCols<3>(layout.offset(Block::kAttitude));
  return mend_rate(state.x, noise * H.transpose() * u.S_inverse * u.residual);
}

}  // namespace piste
