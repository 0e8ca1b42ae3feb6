#include "filter/reference.h"

#include <algorithm>
#include <span>
#include <utility>

#include "core/stored_estimate.h"
#include "core/time_search.h"
#include "piste/math/so3.h"
#include "walker/fix_queue.h"

namespace piste {

Reference::Reference(StateLayout layout, std::filesystem::path scratch)
    : layout_(std::move(layout)), folder_(std::move(scratch)), scratch_(folder_) {}

void Reference::add(double time, const Estimate& x) {
  last_time_ = std::max(last_time_, time);
  rows_.push_back(time);
  StoredEstimate(layout_).put_row(x, rows_);
  ++size_;
}

void Reference::close() {
  if (rows_.empty()) return;
  pieces_.push_back(scratch_.add(std::span<const double>(rows_)));
  rows_.clear();
}

Reference::Reader::Reader(std::shared_ptr<const Reference> of)
    : of_(std::move(of)),
      next_piece_(of_->pieces_.size()),
      left_(of_->size_),
      before_{-1e300, of_->start},
      row_(before_) {}

const Reference::Row& Reference::Reader::at(double time) {
  while (left_ > 0 && row_.time < time - kSameInstant) next();
  const bool between = before_.time > -1e300 && before_.time < time && row_.time > time + kSameInstant;
  if (!between) return row_;
  between_ = {time,
              boxplus(row_.x, of_->layout_,
                      (row_.time - time) / (row_.time - before_.time) * boxminus(before_.x, row_.x, of_->layout_))};
  return between_;
}

void Reference::Reader::next() {
  if (next_ == rows_.size()) {
    of_->scratch_.read(of_->pieces_[--next_piece_], rows_);
    next_ = 0;
  }
  std::swap(before_, row_);
  const double* p = rows_.data() + next_;
  row_.time = *p++;
  p = StoredEstimate(of_->layout_).take_row(p, row_.x);
  next_ = static_cast<std::size_t>(p - rows_.data());
  --left_;
}

BodyMotion motion_between(const Estimate& from, const Estimate& to, double dt, const Vector3d& earth_rate,
                          const Gravity& gravity) {
  const Vector3d turned = so3_log(from.q_wb.conjugate() * to.q_wb);
  const Quaterniond half_way = from.q_wb * so3_exp(0.5 * turned);
  const Vector3d v = 0.5 * (from.v_wb + to.v_wb);
  const Vector3d acceleration = (to.v_wb - from.v_wb) / dt + 2 * earth_rate.cross(v) - gravity.value;
  return {.rate = turned / dt + half_way.conjugate() * earth_rate, .force = half_way.conjugate() * acceleration};
}

}  // namespace piste
