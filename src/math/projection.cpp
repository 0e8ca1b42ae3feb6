#include "math/projection.h"

#include <fmt/format.h>
#include <proj.h>

#include <string_view>

#include "piste/math/units.h"

namespace piste {

// What Projection holds.
namespace proj_objects {

template <auto Destroy>
struct Destroyer {
  template <class T>
  void operator()(T* object) const {
    Destroy(object);
  }
};
using Context = std::unique_ptr<PJ_CONTEXT, Destroyer<proj_context_destroy>>;
using Object = std::unique_ptr<PJ, Destroyer<proj_destroy>>;

}  // namespace proj_objects

namespace {

using proj_objects::Object;

bool is_in_metres(PJ_CONTEXT* context, const PJ* crs) {
  const Object axes(proj_crs_get_coordinate_system(context, crs));
  if (!axes || proj_cs_get_axis_count(context, axes.get()) != 2) return false;
  for (int i = 0; i < 2; ++i) {
    const char* unit = nullptr;
    proj_cs_get_axis_info(context, axes.get(), i, nullptr, nullptr, nullptr, nullptr, &unit, nullptr, nullptr);
    if (unit == nullptr || std::string_view(unit) != "metre") return false;
  }
  return true;
}

}  // namespace

struct Projection::Proj {
  proj_objects::Context context;
  proj_objects::Object transformation;
};

bool has_projections() { return true; }

Projection::Projection(int epsg) : proj_(std::make_unique<Proj>()) {
  proj_->context.reset(proj_context_create());
  PJ_CONTEXT* context = proj_->context.get();
  proj_log_level(context, PJ_LOG_NONE);
  const std::string name = fmt::format("EPSG:{}", epsg);
  const Object crs(proj_create(context, name.c_str()));
  if (!crs) throw NoProjection(fmt::format("PROJ knows no {}", name));
  if (!is_in_metres(context, crs.get())) {
    throw NoProjection(fmt::format("{} ({}) is no projection in metres", name, proj_get_name(crs.get())));
  }
  const Object as_stated(proj_create_crs_to_crs(context, "EPSG:4326", name.c_str(), nullptr));
  if (as_stated) proj_->transformation.reset(proj_normalize_for_visualization(context, as_stated.get()));
  if (!proj_->transformation) throw NoProjection(fmt::format("PROJ finds no way from WGS84 to {}", name));
}

Projection::~Projection() = default;

Eigen::Vector2d Projection::easting_northing(const Geodetic& place) const {
  const PJ_COORD from =
      proj_coord(kDegreesPerRadian * place.longitude, kDegreesPerRadian * place.latitude, place.height, HUGE_VAL);
  const PJ_COORD to = proj_trans(proj_->transformation.get(), PJ_FWD, from);
  return {to.enu.e, to.enu.n};
}

}  // namespace piste
