#include "piste/report/kml.h"

#include <fmt/format.h>

#include <array>
#include <iterator>
#include <vector>

#include "math/geoid.h"
#include "math/gps_time.h"
#include "piste/math/units.h"
#include "plot/markup.h"
#include "plot/thin.h"

namespace piste {
namespace {

std::string coordinates(const Solution& solution, std::size_t i, char separator = ',') {
  const Geodetic place = solution.world().to_geodetic(solution.position(i));
  const double height = has_geoid() ? place.height - geoid_undulation(place) : place.height;
  return fmt::format("{1:.9f}{0}{2:.9f}{0}{3:.3f}", separator, place.longitude * kDegreesPerRadian,
                     place.latitude * kDegreesPerRadian, height);
}

// The track with times, or the line without.
std::string track(const Solution& solution, const std::vector<std::size_t>& rows, std::optional<int> week) {
  std::string out;
  if (!week) {
    out += "<LineString><altitudeMode>absolute</altitudeMode><coordinates>\n";
    for (const std::size_t i : rows) out += coordinates(solution, i) + '\n';
    return out + "</coordinates></LineString>";
  }
  out += "<gx:Track><altitudeMode>absolute</altitudeMode>\n";
  for (const std::size_t i : rows) out += fmt::format("<when>{}</when>\n", utc_text({*week, solution.time(i)}));
  for (const std::size_t i : rows) out += fmt::format("<gx:coord>{}</gx:coord>\n", coordinates(solution, i, ' '));
  return out + "</gx:Track>";
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

std::string kml(const Solution& solution, const std::string& name, std::optional<int> week, std::size_t limit) {
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<kml xmlns=\"http://www.opengis.net/kml/2.2\" "
      "xmlns:gx=\"http://www.google.com/kml/ext/2.2\">\n<Document>\n  <name>{}</name>\n  <description>Heights are "
      "above the {}.</description>\n{}",
      escape_markup(name), has_geoid() ? "sea (EGM96)" : "WGS84 ellipsoid, not above the sea", kStyles);
  if (!solution.empty()) {
    std::array<std::vector<double>, 3> columns;
    for (std::size_t i = 0; i < solution.size(); ++i) {
      const Vector3d p = solution.position(i);
      for (std::size_t axis = 0; axis < 3; ++axis) columns[axis].push_back(p[static_cast<Eigen::Index>(axis)]);
    }
    out += fmt::format("  <Placemark><name>{}</name><styleUrl>#track</styleUrl>{}</Placemark>\n", escape_markup(name),
                       track(solution, thin(columns, limit), week));
    out += placemark(solution, 0, "start");
    out += placemark(solution, solution.size() - 1, "end");
  }
  return out + "</Document>\n</kml>\n";
}

}  // namespace piste
