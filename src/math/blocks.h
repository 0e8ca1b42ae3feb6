#pragma once
// Many small dense matrices of one size, and the products that a long chain of them takes.

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <vector>

namespace piste {

/// Matrices of one size, one after the other in memory. Each column is padded with zeros to a whole group of four
/// doubles, so that products read and write whole groups, and allocate nothing.
class Blocks {
 public:
  using Stride = Eigen::OuterStride<>;
  using View = Eigen::Map<Eigen::MatrixXd, 0, Stride>;
  using ConstView = Eigen::Map<const Eigen::MatrixXd, 0, Stride>;

  Blocks() = default;
  /// All zero.
  Blocks(std::size_t count, Eigen::Index rows, Eigen::Index columns) { reset(count, rows, columns); }

  /// The same, in the memory that it has.
  void reset(std::size_t count, Eigen::Index rows, Eigen::Index columns) {
    resize(count, rows, columns);
    std::fill(values_.begin(), values_.end(), 0.0);
  }
  /// Values are undefined after a change of size. The padding behind a column stays zero if rows and columns do not
  /// change.
  void resize(std::size_t count, Eigen::Index rows, Eigen::Index columns) {
    if (rows != rows_ || columns != columns_) values_.clear();
    count_ = count;
    rows_ = rows;
    columns_ = columns;
    stride_ = (rows + 3) / 4 * 4;
    values_.resize(count * static_cast<std::size_t>(stride_ * columns), 0.0);
  }

  std::size_t size() const { return count_; }
  Eigen::Index rows() const { return rows_; }
  Eigen::Index columns() const { return columns_; }
  View operator[](std::size_t i) { return {values_.data() + place(i), rows_, columns_, Stride(stride_)}; }
  ConstView operator[](std::size_t i) const { return {values_.data() + place(i), rows_, columns_, Stride(stride_)}; }

 private:
  std::size_t place(std::size_t i) const { return i * static_cast<std::size_t>(stride_ * columns_); }

  std::size_t count_ = 0;
  Eigen::Index rows_ = 0, columns_ = 0, stride_ = 0;
  std::vector<double> values_;
};

/// Where the factors of a product are: the element (i, j) of B is B[i * row + j * column], and A has whole groups.
struct Factors {
  const double *A, *B;
  Eigen::Index inner, stride, row, column;
};
/// C ← `kept` C + `factor` A B, where `kept` is 0 or 1; or of a symmetric C at least the lower triangle.
void multiply(double factor, const Factors& of, bool kept, bool lower, Blocks::View C);

template <class ViewA, class ViewB>
Factors factors(const ViewA& A, const ViewB& B) {
  return {A.data(), B.data(), A.cols(), A.outerStride(), 1, B.outerStride()};
}
template <class ViewA, class ViewB>
Factors factors_transposed(const ViewA& A, const ViewB& B) {
  return {A.data(), B.data(), A.cols(), A.outerStride(), B.outerStride(), 1};
}

/// C ← A B, or with Bᵀ in place of B. @pre A, B and C are views of Blocks, of which C is another than A and B; A and C
/// have as many rows
template <class ViewA, class ViewB>
void set_product(const ViewA& A, const ViewB& B, Blocks::View C) {
  multiply(1, factors(A, B), false, false, C);
}
template <class ViewA, class ViewB>
void set_product_transposed(const ViewA& A, const ViewB& B, Blocks::View C) {
  multiply(1, factors_transposed(A, B), false, false, C);
}
/// C ← C + factor A B, and so on.
template <class ViewA, class ViewB>
void add_product(double factor, const ViewA& A, const ViewB& B, Blocks::View C) {
  multiply(factor, factors(A, B), true, false, C);
}
template <class ViewA, class ViewB>
void add_product_transposed(double factor, const ViewA& A, const ViewB& B, Blocks::View C) {
  multiply(factor, factors_transposed(A, B), true, false, C);
}
/// The same for a symmetric product: only the lower triangle is computed right.
template <class ViewA, class ViewB>
void add_symmetric_transposed(double factor, const ViewA& A, const ViewB& B, Blocks::View C) {
  multiply(factor, factors_transposed(A, B), true, true, C);
}

/// A ← A⁻¹ of a symmetric positive definite A, by Gauss-Jordan elimination (Higham 2002, Accuracy and Stability of
/// Numerical Algorithms, section 14.4). The matrix is scaled to a unit diagonal, so that units do not matter. Returns
/// whether A is positive definite; if it is not, A is spoilt. The part above the diagonal is not read. @pre A is of
/// Blocks
bool invert_definite(Blocks::View A);

}  // namespace piste
