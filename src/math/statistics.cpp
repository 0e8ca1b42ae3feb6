#include "piste/math/statistics.h"

#include <boost/math/distributions/chi_squared.hpp>

namespace piste {

double chi_squared_quantile(double probability, double dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

}  // namespace piste
