#pragma once
/// The motion of any body on the plate, from the reference solution.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// How a body IMU is mounted relative to the reference.
struct BodyMounting {
  Quaterniond q_rb = Quaterniond::Identity();
  Vector3d p_rb_r = Vector3d::Zero();  ///< from r to b, in r
};

/// The track of the reference.
class ReferenceTrack {
 public:
  /// The rows of a reference IMU's solution within `span`. The IMU's samples give the angular rate, which is needed to
  /// transfer the velocity by a lever arm.
  ReferenceTrack(const Solution& solution, const std::vector<ImuSample>& imu, const Interval& span);

  /// The same in another world frame.
  ReferenceTrack in(const World& world) const;

  struct State {
    Quaterniond q_wb;
    Vector3d v_wb, p_wb;
  };
  /// The motion of a body on the plate at `time`, interpolated between rows.
  /// @pre span().contains(time)
  State at(double time, const BodyMounting& body) const;

  Interval span() const { return {rows_.front().time, rows_.back().time}; }
  bool empty() const { return rows_.empty(); }

 private:
  struct Row {
    double time;
    Quaterniond q_wr;
    Vector3d v_wr, p_wr, w_ir_r;
  };
  World world_;
  std::vector<Row> rows_;
};

}  // namespace piste
