#pragma once
/// Where everything on the plate was, as the reference solution has it.

#include <vector>

#include "piste/core/log.h"
#include "piste/core/solution.h"

namespace piste {

/// How a body IMU sits against the reference.
struct BodyMounting {
  Quaterniond q_rb = Quaterniond::Identity();
  Vector3d p_rb_r = Vector3d::Zero();  ///< r → b, in r
};

class ReferenceTrack {
 public:
  /// Of the rows of a reference IMU's solution within `span`, and of its samples, whose rates move the velocity by the
  /// lever arm.
  ReferenceTrack(const Solution& solution, const std::vector<ImuSample>& imu, const Interval& span);

  /// The same in another world frame.
  ReferenceTrack in(const World& world) const;

  struct State {
    Quaterniond q_wb;
    Vector3d v_wb, p_wb;
  };
  /// Of a body on the plate, between the rows nearest to `time`.
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
