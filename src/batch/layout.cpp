#include "layout.h"

#include <algorithm>
#include <utility>

namespace piste {

BatchLayout::BatchLayout(StateLayout layout) : whole(std::move(layout)) {
  for (const Block b : whole.blocks()) {
    Part& part = info(b).prior ? constant : node;
    part.blocks.push_back(b);
    for (int k = 0; k < info(b).size; ++k) part.rows.push_back(whole.offset(b) + k);
  }
}

int BatchLayout::Part::offset(Block block) const {
  int row = 0;
  for (const Block b : blocks) {
    if (b == block) return row;
    row += info(b).size;
  }
  return -1;
}

int BatchLayout::Part::stored() const {
  return size() + static_cast<int>(std::count_if(blocks.begin(), blocks.end(), is_rotation));
}

void BatchLayout::Part::store(const Estimate& x, double* values) const {
  for (const Block b : blocks) {
    if (is_rotation(b)) {
      Eigen::Map<Eigen::Vector4d>{values} = rotation(x, b).coeffs();
      values += 4;
    } else {
      Eigen::Map<Eigen::VectorXd>(values, info(b).size) = additive(x, b);
      values += info(b).size;
    }
  }
}

void BatchLayout::Part::load(const double* values, Estimate& x) const {
  for (const Block b : blocks) {
    if (is_rotation(b)) {
      rotation(x, b).coeffs() = Eigen::Map<const Eigen::Vector4d>(values);
      values += 4;
    } else {
      additive(x, b) = Eigen::Map<const Eigen::VectorXd>(values, info(b).size);
      values += info(b).size;
    }
  }
}

void BatchLayout::Part::copy(const Estimate& from, Estimate& to) const {
  for (const Block b : blocks) {
    if (is_rotation(b)) {
      rotation(to, b) = rotation(from, b);
    } else {
      additive(to, b) = additive(from, b);
    }
  }
}

void BatchLayout::Part::difference(const Estimate& x, const Estimate& from, double* error) const {
  for (const Block b : blocks) {
    const int size = info(b).size;
    if (is_rotation(b)) {
      Eigen::Map<Vector3d>{error} = so3_log(rotation(x, b) * rotation(from, b).conjugate());
    } else {
      for (int k = 0; k < size; ++k) error[k] = additive(x, b)(k) - additive(from, b)(k);
    }
    error += size;
  }
}

Eigen::VectorXd BatchLayout::Part::select(const FullError& error) const {
  Eigen::VectorXd out(size());
  int row = 0;
  for (const Block b : blocks) {
    out.segment(row, info(b).size) = error.segment(full_offset(b), info(b).size);
    row += info(b).size;
  }
  return out;
}

void BatchLayout::Part::put(const double* error, ErrorVector& into) const {
  for (const int row : rows) into(row) = *error++;
}

FullError BatchLayout::Part::expand(const double* error) const {
  FullError full = FullError::Zero();
  for (const Block b : blocks) {
    full.segment(full_offset(b), info(b).size) = Eigen::Map<const Eigen::VectorXd>(error, info(b).size);
    error += info(b).size;
  }
  return full;
}

}  // namespace piste
