#include "math/magnetic_field.h"

#include <GeographicLib/Geocentric.hpp>
#include <GeographicLib/SphericalHarmonic.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "math/wmm2025.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr int kModelDegree = 12;
constexpr double kRadius = 6371200;  // m: of the model's sphere
constexpr double kMicroPerNano = 1e-3;

// The coefficients, as GeographicLib orders them: by order, then by degree.
struct FieldCoefficients {
  FieldCoefficients()
      : g(GeographicLib::SphericalEngine::coeff::Csize(kModelDegree, kModelDegree), 0.0),
        h(GeographicLib::SphericalEngine::coeff::Ssize(kModelDegree, kModelDegree), 0.0),
        g_change(g),
        h_change(h) {
    std::istringstream text{std::string(assets::wmm2025())};
    std::string head;
    std::getline(text, head);
    std::istringstream(head) >> epoch;
    const GeographicLib::SphericalEngine::coeff place(g, h, kModelDegree);
    int n = 0, m = 0;
    double values[4];
    while (text >> n >> m >> values[0] >> values[1] >> values[2] >> values[3]) {
      if (n > kModelDegree) break;  // the line of nines that ends the file
      const int k = place.index(n, m);
      g[static_cast<std::size_t>(k)] = values[0];
      g_change[static_cast<std::size_t>(k)] = values[2];
      if (m == 0) continue;
      const auto s = static_cast<std::size_t>(k - (kModelDegree + 1));  // there are no sines of order 0
      h[s] = values[1];
      h_change[s] = values[3];
    }
  }

  double epoch = 0;
  std::vector<double> g, h, g_change, h_change;
};

// Gradient of the potential's sum at a point of ECEF.
Vector3d field_gradient(const std::vector<double>& c, const std::vector<double>& s, const Vector3d& point) {
  const GeographicLib::SphericalHarmonic sum(c, s, kModelDegree, kRadius, GeographicLib::SphericalHarmonic::SCHMIDT);
  Vector3d out;
  sum(point.x(), point.y(), point.z(), out.x(), out.y(), out.z());
  return out;
}

}  // namespace

Vector3d magnetic_field(const Geodetic& place, double year) {
  static const FieldCoefficients model;
  Vector3d point;
  std::vector<double> axes(9);
  GeographicLib::Geocentric::WGS84().Forward(place.latitude / kDegree, place.longitude / kDegree, place.height,
                                             point.x(), point.y(), point.z(), axes);
  const Vector3d ecef = -kRadius * (field_gradient(model.g, model.h, point) +
                                    (year - model.epoch) * field_gradient(model.g_change, model.h_change, point));
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> from_enu(axes.data());
  const Vector3d enu = from_enu.transpose() * ecef;
  return kMicroPerNano * Vector3d(enu.y(), enu.x(), -enu.z());
}

}  // namespace piste
