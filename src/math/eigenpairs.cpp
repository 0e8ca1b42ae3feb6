#include "math/eigenpairs.h"

#include <Eigen/Eigenvalues>

namespace piste {

Eigenpairs eigenpairs(const Square& X) {
  const Eigen::SelfAdjointEigenSolver<Square> solver(X);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace piste
