#include <cmath>

#include "piste/piste.h"

int main() {
  const piste::World world({0.8, 0.1, 1500});
  piste::FullError error = piste::FullError::Zero();
  error[piste::full_offset(piste::Block::kAttitude)] = 0.01;
  const piste::Estimate estimate = boxplus(piste::Estimate{}, error);
  const double gravity = world.gravity(estimate.p_wb).value.norm();
  return std::abs(gravity - 9.80) < 0.02 && boxminus(estimate, {}).isApprox(error) ? 0 : 1;
}
