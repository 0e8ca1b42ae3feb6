#include "piste/model/measurement.h"

namespace piste {

Jacobian assemble(const StateLayout& layout, const Linearization& lin) {
  Jacobian H = Jacobian::Zero(3, layout.size());
  for (int i = 0; i < lin.count(); ++i) {
    const auto& term = lin.term(i);
    if (!layout.has(term.block)) continue;
    const int size = info(term.block).size;
    H.block(0, layout.offset(term.block), lin.rows, size) = term.jacobian.topLeftCorner(lin.rows, size);
  }
  return H;
}

BodyMotion MeasurementContext::motion(const Estimate& x) const {
  const ImuStep s = correct(step, x);
  const double from_middle = into_step - 0.5 * s.dt;
  return {s.mean_rate() + from_middle * s.rate_slope, s.mean_force() + from_middle * s.force_slope, rate_variance};
}

}  // namespace piste
