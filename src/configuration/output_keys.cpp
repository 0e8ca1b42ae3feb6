#include "configuration/output_keys.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

#include "math/projection.h"

namespace piste {
namespace {

constexpr std::array<std::pair<std::string_view, bool RowExtras::*>, 6> kColumns{
    {{"enu", &RowExtras::enu},
     {"ecef", &RowExtras::ecef},
     {"utm", &RowExtras::utm},
     {"speed", &RowExtras::speed},
     {"acceleration", &RowExtras::acceleration},
     {"rates", &RowExtras::rates}}};

// `EPSG:2056`, in any letters.
std::optional<int> epsg_code(std::string_view word) {
  constexpr std::string_view kPrefix = "epsg:";
  if (word.size() <= kPrefix.size()) return std::nullopt;
  for (std::size_t i = 0; i < kPrefix.size(); ++i) {
    if (std::tolower(static_cast<unsigned char>(word[i])) != kPrefix[i]) return std::nullopt;
  }
  word.remove_prefix(kPrefix.size());
  int code = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), code);
  if (error != std::errc() || end != word.data() + word.size()) return std::nullopt;
  return code;
}

void check_projection(const Config& output, int code) {
  try {
    const Projection projection(code);
  } catch (const NoProjection& e) {
    output.fail("columns", fmt::format("{}; `utm` and `enu` are there without", e.what()));
  }
}

void read_columns(const Config& output, RowExtras& columns) {
  for (const std::string& word : output.words("columns")) {
    const auto known = std::find_if(kColumns.begin(), kColumns.end(), [&](const auto& c) { return c.first == word; });
    if (known != kColumns.end()) {
      columns.*(known->second) = true;
    } else if (const std::optional<int> code = epsg_code(word)) {
      check_projection(output, *code);
      columns.epsg.push_back(*code);
    } else {
      output.fail("columns", fmt::format("`{}` is none of: enu, ecef, utm, EPSG:2056 (any code of a projection in "
                                         "metres), speed, acceleration, rates",
                                         word));
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
    event.find_delay = source.is_scalar("delay") && source.text("delay") == "auto";
    if (event.find_delay && event.marks.format != MarkFormat::kCsv) {
      source.fail("delay", "`auto` needs marks with places, which only `format: csv` has");
    }
    if (!event.find_delay) event.delay = source.quantity("delay", dimension::kTime, 0);
    event.at = source.text("at", "");
    if (!event.at.empty() && output.point(event.at) == nullptr) {
      source.fail("at", fmt::format("`{0}` is no point; name it: `output: {{at: {{{0}: 0 0 -0.4 m}}}}`", event.at));
    }
    for (const std::string& program : source.words("text")) {
      if (program != "metashape" && program != "pix4d") {
        source.fail("text", fmt::format("`{}` is none of: metashape, pix4d", program));
      }
      (program == "pix4d" ? event.pix4d : event.metashape) = true;
    }
    events.push_back(event);
  }
  return events;
}

}  // namespace piste
