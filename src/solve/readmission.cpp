#include "piste/solve/readmission.h"

#include <algorithm>

namespace piste {
void admit_error(Covariance& P, const StateLayout& layout, const Linearization& lin, double lapse,
                 const TrustOptions& options) {
  const double size = lin.residual.head(lin.rows).norm();
  double position = 0, velocity = 0, attitude = 0;
  switch (lin.observes) {
    case Block::kPosition:
      position = size;
      velocity = size / lapse;
      attitude = 2 * size / (kStandardGravity * lapse * lapse);
      break;
    case Block::kVelocity:
      velocity = size;
      attitude = size / (kStandardGravity * lapse);
      break;
    default:
      attitude = size;
  }
  attitude = std::min(attitude, options.largest_tilt);
  const auto add = [&](Block b, double sigma) { P.diagonal().segment<3>(layout.offset(b)).array() += sigma * sigma; };
  add(Block::kPosition, position);
  add(Block::kVelocity, velocity);
  add(Block::kAttitude, attitude);
}

}  // namespace piste
