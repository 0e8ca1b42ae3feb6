#include "lags.h"

#include <algorithm>

namespace piste {

std::vector<AttitudeLag> attitude_lags(const World& world, const BatchLayout& layout, const Chain& chain,
                                       const BatchStates& states, const ArrowElimination& solved,
                                       const ArrowMatrix& P) {
  const Eigen::Index attitude = layout.node.offset(Block::kAttitude);
  const std::size_t count = states.size(), late_every = std::max<std::size_t>(1, count / kLateEpochs),
                    early_every = std::max<std::size_t>(1, count / kEarlyEpochs);
  const auto level = [&](std::size_t i) -> Matrix3d { return world.rotation_wn(states[i].p_wb).transpose(); };
  const auto of = [&](std::size_t i, const Matrix3d& R_nw) -> Matrix3d {
    return R_nw * P.nodes[i].block<3, 3>(attitude, attitude) * R_nw.transpose();
  };
  std::vector<AttitudeLag> out;
  out.reserve(kLateEpochs * kEarlyEpochs);
  for (std::size_t j = count - 1; j > 0; j -= std::min(j, late_every)) {
    const Matrix3d R_late = level(j), of_late = of(j, R_late);
    solved.visit_earlier<3>(P, j, attitude, [&](std::size_t i, const auto& C) {
      if ((count - 1 - i) % early_every != 0) return;
      const Matrix3d R_early = level(i);
      out.push_back({i, j, chain.nodes[j].time - chain.nodes[i].time,
                     R_early * C.template middleRows<3>(attitude) * R_late.transpose(), of(i, R_early), of_late});
    });
  }
  return out;
}

}  // namespace piste
