#include "piste/study/reference_track.h"

#include <iterator>

#include "core/time_search.h"

namespace piste {

ReferenceTrack::ReferenceTrack(const Solution& solution, const std::vector<ImuSample>& imu, const Interval& span)
    : world_(solution.world()) {
  auto sample = imu.begin();
  for (std::size_t i = 0; i < solution.size(); ++i) {
    const double time = solution.time(i);
    if (!span.contains(time)) continue;
    while (sample != imu.end() && sample->time < time) ++sample;
    if (sample == imu.end()) break;
    const Estimate x = solution.estimate(i);
    const auto next = std::next(sample) == imu.end() ? sample : std::next(sample);  // the rate at the row lies between
    const Vector3d rate = (sample->dtheta + next->dtheta) / (sample->interval + next->interval);
    rows_.push_back({time, x.q_wb, x.v_wb, x.p_wb, rate});
  }
}

ReferenceTrack ReferenceTrack::in(const World& world) const {
  ReferenceTrack out = *this;
  out.world_ = world;
  if (rows_.empty()) return out;
  // Both frames are fixed to the Earth, so one rotation and one shift apply to all points.
  const Vector3d& here = rows_.front().p_wr;
  const Vector3d there = world.from_geodetic(world_.to_geodetic(here));
  const Matrix3d turn = world.rotation_wn(there) * world_.rotation_wn(here).transpose();
  for (Row& row : out.rows_) {
    row.q_wr = (Quaterniond(turn) * row.q_wr).normalized();
    row.v_wr = turn * row.v_wr;
    row.p_wr = there + turn * (row.p_wr - here);
  }
  return out;
}

ReferenceTrack::State ReferenceTrack::at(double time, const BodyMounting& body) const {
  auto after = first_at_or_after(rows_, time);
  if (after == rows_.begin()) ++after;
  if (after == rows_.end()) --after;
  const Row &a = *(after - 1), &b = *after;
  const double part = (time - a.time) / (b.time - a.time);
  const auto between = [part](const Vector3d& u, const Vector3d& v) -> Vector3d { return u + part * (v - u); };
  const Quaterniond q_wr = a.q_wr.slerp(part, b.q_wr);
  const Vector3d w_wr_r = between(a.w_ir_r, b.w_ir_r) - q_wr.conjugate() * world_.earth_rate();
  return {(q_wr * body.q_rb).normalized(), between(a.v_wr, b.v_wr) + q_wr * w_wr_r.cross(body.p_rb_r),
          between(a.p_wr, b.p_wr) + q_wr * body.p_rb_r};
}

}  // namespace piste
