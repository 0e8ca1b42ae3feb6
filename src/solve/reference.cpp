#include "piste/solve/reference.h"

#include "piste/math/so3.h"

namespace piste {

BodyMotion motion_between(const Estimate& from, const Estimate& to, double dt, const Vector3d& earth_rate,
                          const Gravity& gravity) {
  const Vector3d turned = so3_log(from.q_wb.conjugate() * to.q_wb);
  const Quaterniond half_way = from.q_wb * so3_exp(0.5 * turned);
  const Vector3d v = 0.5 * (from.v_wb + to.v_wb);
  const Vector3d acceleration = (to.v_wb - from.v_wb) / dt + 2 * earth_rate.cross(v) - gravity.value;
  return {.rate = turned / dt + half_way.conjugate() * earth_rate, .force = half_way.conjugate() * acceleration};
}

}  // namespace piste
