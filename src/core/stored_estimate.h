#pragma once
// Storage of estimates, row by row: the values that change in each row, and the constants separately.

#include <vector>

#include "piste/core/estimate.h"

namespace piste {

/// Appends the numbers of a vector or matrix, and reads as many; returns where the next values stand.
template <class Values>
void put_values(std::vector<double>& out, const Values& values) {
  out.insert(out.end(), values.data(), values.data() + values.size());
}
template <class Values>
const double* take_values(const double* p, Values&& values) {
  for (Eigen::Index k = 0; k < values.size(); ++k) values.data()[k] = *p++;
  return p;
}

/// Whether a block changes from row to row: navigation, what may be a process, and rotations, which are smoothed to
/// first order in their corrections.
inline bool changes(Block b) { return is_navigation(b) || info(b).process != nullptr || is_rotation(b); }

/// Storage for one layout, which must outlive it. Other blocks are not stored.
class StoredEstimate {
 public:
  explicit StoredEstimate(const StateLayout& layout) : layout_(layout) {}

  /// Appends attitude, velocity, position and the other blocks that change, or those that do not.
  void put_row(const Estimate& x, std::vector<double>& out) const {
    put_values(out, x.q_wb.coeffs());
    put_values(out, x.v_wb);
    put_values(out, x.p_wb);
    put_blocks(x, true, out);
  }
  void put_constants(const Estimate& x, std::vector<double>& out) const { put_blocks(x, false, out); }

  /// Reads them into `x`, and returns where the next values stand.
  const double* take_row(const double* p, Estimate& x) const {
    p = take_values(p, x.q_wb.coeffs());
    p = take_values(p, x.v_wb);
    p = take_values(p, x.p_wb);
    return take_blocks(p, true, x);
  }
  const double* take_constants(const double* p, Estimate& x) const { return take_blocks(p, false, x); }

 private:
  static bool belongs(Block b, bool changing) { return !is_navigation(b) && changes(b) == changing; }
  void put_blocks(const Estimate& x, bool changing, std::vector<double>& out) const {
    for (const Block b : layout_.blocks()) {
      if (!belongs(b, changing)) continue;
      if (is_rotation(b)) {
        put_values(out, rotation(x, b).coeffs());
      } else {
        put_values(out, additive(x, b));
      }
    }
  }
  const double* take_blocks(const double* p, bool changing, Estimate& x) const {
    for (const Block b : layout_.blocks()) {
      if (belongs(b, changing))
        p = is_rotation(b) ? take_values(p, rotation(x, b).coeffs()) : take_values(p, additive(x, b));
    }
    return p;
  }

  const StateLayout& layout_;
};

}  // namespace piste
