#include "configuration/output_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

namespace piste {
namespace {

constexpr std::array<std::pair<std::string_view, bool RowExtras::*>, 6> kColumns{
    {{"enu", &RowExtras::enu},
     {"ecef", &RowExtras::ecef},
     {"utm", &RowExtras::utm},
     {"speed", &RowExtras::speed},
     {"acceleration", &RowExtras::acceleration},
     {"rates", &RowExtras::rates}}};

void read_columns(const Config& output, RowExtras& columns) {
  for (const std::string& word : output.words("columns")) {
    const auto known = std::find_if(kColumns.begin(), kColumns.end(), [&](const auto& c) { return c.first == word; });
    if (known != kColumns.end()) {
      columns.*(known->second) = true;
    } else if (word.starts_with("epsg")) {
      output.fail("columns", "codes of EPSG need PROJ, which this build does not have; `utm` is there without it");
    } else {
      output.fail("columns", fmt::format("`{}` is none of: enu, ecef, utm, speed, acceleration, rates", word));
    }
  }
}

// The name becomes part of a file's name.
void check_name(const Config& at, const std::string& name) {
  const bool plain = !name.empty() && std::all_of(name.begin(), name.end(), [](unsigned char c) {
    return std::isalnum(c) != 0 || c == '_' || c == '-';
  });
  if (!plain) at.fail(name, "a point's name has letters, digits, `_` and `-` alone: it becomes part of a file's name");
}

std::vector<OutputPoint> read_points(const Config& output) {
  std::vector<OutputPoint> points;
  const auto at = output.find_map("at");
  if (!at) return points;
  for (const std::string& name : at->names()) {
    check_name(*at, name);
    OutputPoint point{.name = name};
    if (at->is_map(name)) {
      const Config map = at->map(name);
      point.lever_arm = map.vector("lever_arm", dimension::kLength);
      point.q_bp = from_euler(map.vector("boresight", dimension::kAngle, Vector3d::Zero()));
    } else {
      point.lever_arm = at->vector(name, dimension::kLength);
    }
    points.push_back(point);
  }
  return points;
}

void refuse_batch(const Config& config, std::string_view key, SmootherKind smoother) {
  if (smoother != SmootherKind::kBatch) return;
  config.fail(key, "needs whole covariances, which the batch does not give; choose `smoother: rts`, or none");
}

}  // namespace

OutputOptions read_output_options(const Config& config, SmootherKind smoother) {
  OutputOptions options;
  if (config.has("week")) {
    constexpr long kLast = 9999;
    const long week = config.integer("week");
    if (week < 1 || week > kLast) config.fail("week", "a GPS week is expected, counted from 1980, such as 2374");
    options.week = static_cast<int>(week);
  }
  const auto output = config.find_map("output");
  if (!output) return options;
  options.columns.time = output->choice<RowTime>("time",
                                                 {{"seconds", RowTime::kSeconds},
                                                  {"gps_week", RowTime::kGpsWeek},
                                                  {"utc", RowTime::kUtc},
                                                  {"unix", RowTime::kUnix}},
                                                 RowTime::kSeconds);
  options.columns.sea_height = output->choice<bool>("geoid", {{"none", false}, {"egm96", true}}, false);
  options.covariance = output->choice<bool>("covariance", {{"none", false}, {"full", true}}, false);
  read_columns(*output, options.columns);
  options.points = read_points(*output);
  if (options.covariance) refuse_batch(*output, "covariance", smoother);
  if (!options.points.empty()) refuse_batch(*output, "at", smoother);
  return options;
}

std::vector<EventSource> read_events(const Config& config, const OutputOptions& output, SmootherKind smoother) {
  std::vector<EventSource> events;
  for (const Config& source : config.maps("events")) {
    refuse_batch(config, "events", smoother);
    EventSource event;
    event.marks.format = source.choice<MarkFormat>("format",
                                                   {{"csv", MarkFormat::kCsv},
                                                    {"ubx", MarkFormat::kUbx},
                                                    {"novatel", MarkFormat::kNovatel},
                                                    {"rtklib_pos", MarkFormat::kRtklibPos},
                                                    {"exif", MarkFormat::kExif}},
                                                   MarkFormat::kCsv);
    event.marks.file =
        event.marks.format == MarkFormat::kExif ? source.path("file").string() : source.existing_file("file").string();
    event.offset = source.quantity("offset", dimension::kTime, 0);
    event.drift = source.quantity("drift", dimension::kRatio, 0);
    event.delay = source.quantity("delay", dimension::kTime, 0);
    event.at = source.text("at", "");
    if (!event.at.empty() && output.point(event.at) == nullptr) {
      source.fail("at", fmt::format("`{0}` is no point; name it: `output: {{at: {{{0}: 0 0 -0.4 m}}}}`", event.at));
    }
    events.push_back(event);
  }
  return events;
}

}  // namespace piste
