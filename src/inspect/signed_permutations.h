#pragma once
/// The 48 signed permutations of three axes: 24 right-handed ones, and 24 left-handed ones.

#include <vector>

#include "piste/math/so3.h"

namespace piste {

/// All matrices with one ±1 in each row and column; the identity is the first.
inline const std::vector<Matrix3d>& signed_permutations() {
  static const std::vector<Matrix3d> all = [] {
    std::vector<Matrix3d> matrices;
    constexpr int kOrders[6][3] = {{0, 1, 2}, {1, 0, 2}, {0, 2, 1}, {2, 1, 0}, {1, 2, 0}, {2, 0, 1}};
    matrices.reserve(48);
    for (const auto& order : kOrders) {
      for (unsigned signs = 0; signs < 8; ++signs) {
        Matrix3d m = Matrix3d::Zero();
        for (int row = 0; row < 3; ++row) m(row, order[row]) = (signs >> row & 1U) != 0 ? -1 : 1;
        matrices.push_back(m);
      }
    }
    return matrices;
  }();
  return all;
}

}  // namespace piste
