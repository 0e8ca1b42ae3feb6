/// GPX 1.1 and GeoJSON (RFC 7946).

#include <fmt/format.h>

#include "exports/formats.h"
#include "math/geoid.h"

namespace piste::export_formats {

std::vector<ExportedFile> gpx(const ExportRun& run) {
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<gpx version=\"1.1\" creator=\"piste\" "
      "xmlns=\"http://www.topografix.com/GPX/1/1\">\n<trk><trkseg>\n";
  for (std::size_t i = 0; i < run.track.size(); ++i) {
    const Geodetic& place = run.track.place[i];
    const double undulation = geoid_undulation(place);
    fmt::format_to(std::back_inserter(text),
                   "<trkpt lat=\"{:.10f}\" lon=\"{:.10f}\"><ele>{:.4f}</ele><time>{}</time>"
                   "<geoidheight>{:.4f}</geoidheight></trkpt>\n",
                   kDegreesPerRadian * place.latitude, kDegreesPerRadian * place.longitude, place.height - undulation,
                   utc_text(gps_time_of(run, i)), undulation);
  }
  text += "</trkseg></trk>\n</gpx>\n";
  return {{".gpx", std::move(text)}};
}

std::vector<ExportedFile> geojson(const ExportRun& run) {
  std::string times, places;
  for (std::size_t i = 0; i < run.track.size(); ++i) {
    const Geodetic& place = run.track.place[i];
    const char* comma = i > 0 ? ",\n" : "";
    fmt::format_to(std::back_inserter(times), "{}\"{}\"", comma, utc_text(gps_time_of(run, i)));
    fmt::format_to(std::back_inserter(places), "{}[{:.10f},{:.10f},{:.4f}]", comma, kDegreesPerRadian * place.longitude,
                   kDegreesPerRadian * place.latitude, place.height);
  }
  return {
      {".geojson", fmt::format("{{\"type\": \"Feature\", \"properties\": {{\"coordTimes\": [\n{}]}},\n\"geometry\": "
                               "{{\"type\": \"LineString\", \"coordinates\": [\n{}]}}}}\n",
                               times, places)}};
}

}  // namespace piste::export_formats
