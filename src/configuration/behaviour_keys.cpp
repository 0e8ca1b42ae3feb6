#include "configuration/behaviour_keys.h"

#include <fmt/format.h>

#include <string_view>

namespace piste {
namespace {

// The values that a key may have, and how an error says so.
struct AllowedRange {
  double least, most;
  std::string_view said;
};

// Changes `value` to that of the key, if it is there.
void read_within(const Config& map, std::string_view key, const Dimension& dimension, const AllowedRange& range,
                 double& value) {
  value = map.quantity(key, dimension, value);
  if (!(value >= range.least && value <= range.most)) map.fail(key, fmt::format("must be {}", range.said));
}

void read_within(const Config& map, std::string_view key, const AllowedRange& range, int& value) {
  const long read = map.integer(key, value);
  if (!(static_cast<double>(read) >= range.least && static_cast<double>(read) <= range.most)) {
    map.fail(key, fmt::format("must be {}", range.said));
  }
  value = static_cast<int>(read);
}

void read_rest(const Config& config, RestOptions& options) {
  const auto rest = config.find_map("rest");
  if (!rest) return;
  options.detect = rest->flag("detect", options.detect);
  options.sigma_velocity = rest->quantity("sigma_velocity", dimension::kVelocity, options.sigma_velocity);
  options.sigma_rate = rest->quantity("sigma_rate", dimension::kAngularRate, options.sigma_rate);
  options.correlation_time = rest->magnitude("correlation_time", dimension::kTime, options.correlation_time);
  options.interval = rest->quantity("interval", dimension::kTime, options.interval);
  if (!(options.sigma_velocity > 0 && options.sigma_rate > 0 && options.interval > 0)) {
    config.fail("rest", "sigmas and interval must be above zero");
  }
  constexpr double kMillimetre = 0.001;  // a least value of 1 mm, 1 mm/s or 1 mm/s² is reported as above zero
  read_within(*rest, "sway", dimension::kVelocity,
              {kMillimetre, options.moving, "from 0.001 to 0.5 m/s, such as `0.06 m/s`"}, options.sway);
  read_within(*rest, "resolved", dimension::kVelocity,
              {kMillimetre, options.moving, "from 0.001 to 0.5 m/s, such as `0.15 m/s`"}, options.resolved);
  read_within(*rest, "sway_distance", dimension::kLength, {kMillimetre, 100, "from 0.001 to 100 m, such as `0.3 m`"},
              options.sway_distance);
  read_within(*rest, "turn", dimension::kAngle, {0.1 * kDegree, 180 * kDegree, "from 0.1 to 180 deg, such as `5 deg`"},
              options.turn);
  read_within(*rest, "shortest", dimension::kTime, {0.5, 600, "from 0.5 to 600 s, such as `1 s`"}, options.shortest);
  read_within(*rest, "gyro_quiet", dimension::kAngularRate,
              {0.001 * kDegree, 60 * kDegree, "from 0.001 to 60 deg/s, such as `1.7 deg/s`"}, options.gyro_quiet);
  read_within(*rest, "force_quiet", dimension::kAcceleration,
              {kMillimetre, 10, "from 0.001 to 10 m/s^2, such as `0.15 m/s^2`"}, options.force_quiet);
}

void read_trust(const Config& config, FaultDetectionOptions& options) {
  options.gate = config.number("gate", options.gate);
  if (!(options.gate > 0 && options.gate < 1)) {
    config.fail("gate", "a probability between 0 and 1 is expected, such as 0.999");
  }
  const auto trust = config.find_map("trust");
  if (!trust) return;
  read_within(*trust, "readmit_after", {1, 1000, "from 1 to 1000 fixes, such as `5`"}, options.readmit_after);
  read_within(*trust, "distrust", dimension::kTime, {0, 3600, "from 0 to 3600 s, such as `40 s`"}, options.distrust);
}

}  // namespace

BehaviourOptions read_behaviour(const Config& config) {
  BehaviourOptions options;
  read_rest(config, options.rest);
  read_trust(config, options.trust);
  if (const auto gaps = config.find_map("gaps")) {
    read_within(*gaps, "longest", dimension::kTime, {0.01, 3600, "from 0.01 to 3600 s, such as `300 s`"},
                options.gaps.longest);
  }
  if (const auto spikes = config.find_map("spikes")) options.spikes.mend = spikes->flag("mend", options.spikes.mend);
  return options;
}

void read_heading_search(const Config& initial, bool searched, StartOptions& start) {
  for (const std::string_view key : {"hypotheses", "listened", "look_back"}) {
    if (searched || !initial.has(key)) continue;
    initial.fail(key, "only a heading that is not known is searched for: `heading: auto`; or leave the key out");
  }
  read_within(initial, "hypotheses", {4, 72, "from 4 to 72 headings, such as `12`"}, start.hypotheses);
  read_within(initial, "listened", dimension::kTime, {1, 600, "from 1 to 600 s, such as `30 s`"}, start.listened);
  read_within(initial, "look_back", dimension::kTime, {0, 600, "from 0 to 600 s, such as `40 s`"}, start.look_back);
}

}  // namespace piste
