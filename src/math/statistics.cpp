#include "piste/math/statistics.h"

#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/normal.hpp>

namespace piste {

double chi_squared_quantile(double probability, double dof) {
  return boost::math::quantile(boost::math::chi_squared(dof), probability);
}

double normal_quantile(double probability) { return boost::math::quantile(boost::math::normal(), probability); }

Band chi_squared_band(double probability, double dof, double count) {
  const double total = dof * count, tail = (1 - probability) / 2;
  return {chi_squared_quantile(tail, total) / total, chi_squared_quantile(1 - tail, total) / total};
}

}  // namespace piste
