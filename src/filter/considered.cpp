#include "filter/considered.h"

#include <algorithm>

namespace piste {

std::vector<Block> considered_blocks(const FilterOptions& options) {
  std::vector<Block> blocks = imu_error_blocks(options.sensor);
  std::erase_if(blocks, [&](Block b) { return options.estimates(b); });
  return blocks;
}

StateLayout filter_layout(const FilterOptions& options) {
  std::vector<Block> blocks = options.estimate;
  for (const Block b : considered_blocks(options)) blocks.push_back(b);
  return StateLayout(blocks);
}

Covariance restricted(const Covariance& P, const StateLayout& from, const StateLayout& to) {
  std::vector<Eigen::Index> states;
  for (const Block b : to.blocks()) {
    for (int k = 0; k < info(b).size; ++k) states.push_back(from.offset(b) + k);
  }
  return P(states, states);
}

Considered::Considered(const FilterOptions& options, const StateLayout& layout) {
  for (const Block b : considered_blocks(options)) {
    for (int k = 0; k < info(b).size; ++k) states_.push_back(layout.offset(b) + k);
  }
}

ErrorVector Considered::correction(const Update& u) const {
  ErrorVector out = gain(u) * u.residual;
  hold(out);
  return out;
}

void Considered::hold(ErrorVector& error) const {
  for (const Eigen::Index k : states_) error(k) = 0;
}

void Considered::update(Covariance& P, const Update& u) const {
  keep(P, [&] { piste::update(P, u); });
}

ErrorVector Considered::left_out(const Update& u, const ErrorVector& lambda) const {
  ErrorVector out = ErrorVector::Zero(lambda.size());
  // K_c z + K_c S K_cᵀ λ_c = (P Hᵀ)_c S⁻¹ (z + (H P)_c λ_c).
  Vector3d seen = u.residual;
  for (const Eigen::Index k : states_) seen += u.PHt.row(k).transpose() * lambda(k);
  const Vector3d weighted = u.S_inverse * seen;
  for (const Eigen::Index k : states_) out(k) = u.PHt.row(k).dot(weighted);
  return out;
}

}  // namespace piste
