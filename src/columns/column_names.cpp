#include "column_names.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <span>

#include "piste/math/units.h"

namespace piste {
namespace {

// The axis that the last word is, or the last letter of one of two letters, such as `gx` and `vn`.
char axis_of(const std::vector<std::string>& words, std::string_view axes) {
  if (words.empty()) return 0;
  const std::string& last = words.back();
  struct Named {
    std::string_view name;
    char axis;
  };
  constexpr std::array kNames = std::to_array<Named>({{"north", 'n'}, {"east", 'e'}, {"down", 'd'}, {"up", 'u'}});
  for (const Named& named : kNames) {
    if (last == named.name && axes.find(named.axis) != std::string_view::npos) return named.axis;
  }
  const bool is_axis = (last.size() == 1 && words.size() > 1) || last.size() == 2 || axes == "xyz";
  if (!is_axis || last.size() > 2 || axes.find(last.back()) == std::string_view::npos) return 0;
  return last.back();
}

std::string group_of(std::vector<std::string> words) {
  const bool letters = words.back().size() == 2 && words.back() != "up";
  words.back() = letters ? words.back().substr(0, 1) : "";
  return fmt::format("{}", fmt::join(words, " "));
}

// Whether a column is a field of an array, such as `theta[0]`.
bool is_array(const SampledColumn& c) { return c.cell.unit == "0" || c.cell.unit == "1" || c.cell.unit == "2"; }

// Triads along the sensor's axes.
std::string sensor_key(const SampledColumn& c) {
  const std::string first = c.words.back().size() == 2 ? c.words.back().substr(0, 1) : c.words.front();
  const bool is = c.words.back().size() == 2 || c.words.size() > 1;
  const auto letter = [&](std::string_view l) { return is && first == l; };
  if (c.has_any({"quat", "quaternion", "orientation", "pos", "position", "q", "bias", "offset", "drift"}) ||
      letter("q"))
    return {};
  if (c.has("gravity")) return "gravity";
  if (c.has("user")) return "linear";  // acceleration, without gravity
  if (c.has("dtheta") || (is_array(c) && c.words.front() == "theta") || (c.has("delta") && c.has("angle")))
    return "dtheta";
  if (c.has("dvel") || (is_array(c) && c.words.front() == "vel") || (c.has("delta") && c.has_any({"velocity", "vel"})))
    return "dvel";
  if (c.has_any({"mag", "magn", "magnetic", "magnetometer", "compass"}) || letter("m")) return "magnetic";
  if (c.has_any({"gyro", "gyr", "gyros", "gyroscope", "omega", "angular", "angvel", "rotation", "rate", "gy"}) ||
      letter("g") || letter("w")) {
    return "gyro";
  }
  if (c.has_any({"acc", "accel", "accelerometer", "acceleration", "force", "ac"}) || letter("a") || letter("f"))
    return "accel";
  const bool plain = c.words.size() == 2 && c.has_any({"measurement", "value", "reading"});  // of any sensor
  return plain || (c.words.size() == 1 && c.words[0].size() == 1) ? "axis" : "";
}

bool is_spread(const SampledColumn& c) {
  return c.has_any({"sd", "std", "stdev", "stddev", "sigma", "rms", "err"}) ||
         std::any_of(c.words.begin(), c.words.end(), [](const std::string& w) {
           return w.starts_with("sd") || (w.starts_with("std") && w.size() <= 5);
         });
}

// Accuracies, which several receivers and phones give for places, speeds and courses.
std::string accuracy_key(const SampledColumn& c) {
  // Of PX4, whose `variance` is a sigma, as its unit says. MAVLink's `eph` is a hundred times a dilution of precision.
  if (c.has_any({"eph", "epv"})) return c.is_whole() ? "" : c.has("eph") ? "horizontal_accuracy" : "vertical_accuracy";
  if (c.has("variance") && c.has_any({"s", "c"})) return c.has("s") ? "speed_accuracy" : "course_accuracy";
  if (!c.has_any({"acc", "accuracy"}) || measures(c.cell.unit, dimension::kAcceleration)) return {};
  if (c.has_any({"s", "speed", "vel", "velocity"})) return "speed_accuracy";
  if (c.has_any({"head", "heading", "bearing", "course", "cog"})) return "course_accuracy";
  if (c.has_any({"v", "vert", "vertical", "altitude", "height"})) return "vertical_accuracy";
  if (c.has_any({"h", "hor", "horizontal", "location", "position", "pos"}) || c.words.size() == 1) {
    return c.words.size() == 1 && c.words[0] == "acc" ? "" : "horizontal_accuracy";
  }
  return {};
}

std::string place_key(const SampledColumn& c) {
  if (is_array(c) && c.has_any({"lla", "coord"})) {
    const std::string& axis = c.words.back();
    return axis == "x" ? "latitude" : axis == "y" ? "longitude" : "height";
  }
  if (c.has_any({"lat", "latitude"})) return "latitude";
  if (c.has_any({"lon", "lng", "long", "longitude"})) return "longitude";
  if (c.has_any({"geoid", "undulation", "separation", "sep"})) return "geoid";
  if (measures(c.unit, dimension::kAngle) || measures(c.cell.unit, dimension::kAngle)) return {};  // of satellites
  if (c.has_any({"baro", "barometer", "barometric", "pressure", "press", "bmp"})) return {};
  // Above the place of the start or the ground: of ArduPilot's RelAlt, and of DJI's logs.
  if (c.has_any({"rel", "relative", "takeoff", "home", "ground", "agl"})) return {};
  const bool sea = c.has_any({"msl", "amsl", "sea"});
  if (sea && c.has_any({"height", "alt", "altitude", "hgt", "h"})) return "sea height";
  if (!sea && (is_ellipsoidal(c) || c.has_any({"height", "alt", "altitude", "hgt", "ele", "elevation"}) ||
               (c.words.size() == 1 && c.words[0] == "h"))) {
    return "height";
  }
  return {};
}

std::string motion_key(const SampledColumn& c) {
  if (c.words == std::vector<std::string>{"direction"} || (c.has("location") && c.has("orientation"))) return "course";
  if (c.words == std::vector<std::string>{"velocity"}) return "speed";  // with a direction in another column
  if (c.has_any({"course", "heading", "bearing", "cog", "track", "crs"}) || (c.has("head") && c.has("mot")))
    return "course";
  if (c.has_any({"speed", "sog", "spd"}) && !c.has_any({"vertical", "down", "up", "wind"})) return "speed";
  return {};
}

}  // namespace

bool is_ellipsoidal(const SampledColumn& c) { return c.has_any({"hae", "ellipsoid", "ellipsoidal", "ellips"}); }

std::optional<std::size_t> column_of(const std::vector<ColumnMeaning>& meanings, std::string_view key) {
  const auto found = std::find_if(meanings.begin(), meanings.end(),
                                  [&](const ColumnMeaning& m) { return m.key == key && m.axis == 0; });
  if (found == meanings.end()) return std::nullopt;
  return static_cast<std::size_t>(found - meanings.begin());
}

ColumnMeaning meaning_of(const SampledColumn& c) {
  if (c.words.empty()) return {};
  const auto one = [](std::string key) { return ColumnMeaning{std::move(key), 0, {}}; };
  if (std::string key = accuracy_key(c); !key.empty()) return one(std::move(key));
  const bool spread = is_spread(c);
  const std::string place = place_key(c);
  if (!place.empty() && !spread) return one(place);
  if (spread && place == "geoid") return {};
  if (spread && !place.empty()) {
    return {"sigma", place == "latitude" ? 'n' : place == "longitude" ? 'e' : 'u', "place"};
  }
  if (const char axis = axis_of(c.words, "nedu")) {
    const bool velocity = c.has_any({"vel", "velocity", "v"}) || c.words.back().front() == 'v' ||
                          (c.words.size() == 1 && c.words[0].starts_with("sdv"));
    if (velocity) return {spread ? "sigma_velocity" : "velocity", axis, group_of(c.words)};
    if (spread) return {"sigma", axis, group_of(c.words)};
  }
  if (spread) {  // of RTKLIB and NovAtel: sdn, stdev_n
    const char axis = c.words.back().back();
    const bool velocity = c.words.back().starts_with("sdv");
    if (std::string_view("nedu").find(axis) != std::string_view::npos && c.words.back().size() <= 4) {
      return {velocity ? "sigma_velocity" : "sigma", axis, velocity ? "sdv" : "sd"};
    }
    return {};
  }
  if (axis_of(c.words, "xyz") != 0) {
    if (std::string key = sensor_key(c); !key.empty())
      return {std::move(key), axis_of(c.words, "xyz"), group_of(c.words)};
  }
  if (c.has_any({"rate", "speed"}) && c.has_any({"roll", "pitch", "yaw"})) {
    return {"gyro", c.has("roll") ? 'x' : c.has("pitch") ? 'y' : 'z', "roll pitch yaw"};
  }
  if (c.has_any({"acc", "accel", "acceleration"}) && c.has_any({"longitudinal", "inline", "lateral", "vertical"})) {
    return {"accel", c.has("lateral") ? 'y' : c.has("vertical") ? 'z' : 'x', "vehicle"};
  }
  if (std::string key = motion_key(c); !key.empty()) return one(std::move(key));
  if (c.has("roll") || c.has("pitch")) return one(c.has("roll") ? "roll" : "pitch");
  if (c.has("yaw")) return one("heading");
  if (c.has("week") && !c.has("time")) return one("week");
  constexpr std::array<std::string_view, 12> kTimeAlone{"t",  "s",      "sec", "ms",    "msec", "millis",
                                                        "us", "micros", "ns",  "nanos", "usec", "nsec"};
  if (c.has_any({"time", "timestamp", "stamp", "tow", "sow", "epoch", "epoc", "seconds", "elapsed", "cts", "utc",
                 "gpst", "datetime", "gpstime", "utctime", "datenum"}) ||
      (c.words.size() == 1 && std::find(kTimeAlone.begin(), kTimeAlone.end(), c.words[0]) != kTimeAlone.end())) {
    return one("time");
  }
  if (c.has("date")) return one("date");
  if (c.words == std::vector<std::string>{"q"}) return one("q");  // of RTKLIB
  if (c.has_any({"fix", "quality"})) return one("fix");
  if (c.has_any({"temp", "temperature"})) return one("temperature");
  return {};
}

}  // namespace piste
