#pragma once
// Eigenvalues and eigenvectors of a symmetric matrix, without a heap.

#include <Eigen/Core>

#include "math/square.h"

namespace piste {

/// X = V diag(values) Vᵀ; values ascending, a vector a column.
struct Eigenpairs {
  Eigen::Matrix<double, Eigen::Dynamic, 1, 0, Square::MaxRowsAtCompileTime, 1> values;
  Square vectors;
};

/// Of a symmetric matrix, whose lower triangle is read. Compiled once here: Eigen's solver takes seconds to compile.
Eigenpairs eigenpairs(const Square& X);

}  // namespace piste
