#include "piste/report/kml.h"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <vector>

#include "piste/math/units.h"
#include "plot/markup.h"
#include "plot/thin.h"

namespace piste {
namespace {

std::string coordinates(const Solution& solution, std::size_t i) {
  const Geodetic place = solution.world().to_geodetic(solution.position(i));
  return fmt::format("{:.9f},{:.9f},{:.3f}", place.longitude * kDegreesPerRadian, place.latitude * kDegreesPerRadian,
                     place.height);
}

std::string placemark(const Solution& solution, std::size_t i, const char* name) {
  return fmt::format(
      "  <Placemark><name>{0}</name><description>time_s {1:.3f}</description>"
      "<styleUrl>#{0}</styleUrl><Point><altitudeMode>absolute</altitudeMode>"
      "<coordinates>{2}</coordinates></Point></Placemark>\n",
      name, solution.time(i), coordinates(solution, i));
}

constexpr std::string_view kStyles =
    R"(  <Style id="track"><LineStyle><color>ffcc6600</color><width>3</width></LineStyle></Style>
  <Style id="start"><IconStyle><color>ff50b000</color></IconStyle></Style>
  <Style id="end"><IconStyle><color>ff3030d0</color></IconStyle></Style>
)";

}  // namespace

std::string kml(const Solution& solution, const std::string& name, std::size_t limit) {
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\">\n<Document>\n"
      "  <name>{}</name>\n  <description>Heights are above the WGS84 ellipsoid, not above the sea.</description>\n{}",
      escape_markup(name), kStyles);
  if (!solution.empty()) {
    std::array<std::vector<double>, 3> columns;
    for (std::size_t i = 0; i < solution.size(); ++i) {
      const Vector3d p = solution.position(i);
      for (std::size_t axis = 0; axis < 3; ++axis) columns[axis].push_back(p[static_cast<Eigen::Index>(axis)]);
    }
    out += fmt::format(
        "  <Placemark><name>{}</name><styleUrl>#track</styleUrl><LineString>"
        "<altitudeMode>absolute</altitudeMode><coordinates>\n",
        escape_markup(name));
    for (const std::size_t i : thin(columns, limit)) out += coordinates(solution, i) + '\n';
    out += "</coordinates></LineString></Placemark>\n";
    out += placemark(solution, 0, "start");
    out += placemark(solution, solution.size() - 1, "end");
  }
  return out + "</Document>\n</kml>\n";
}

}  // namespace piste
