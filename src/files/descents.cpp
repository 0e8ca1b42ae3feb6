#include "piste/files/descents.h"

#include <fmt/format.h>

#include <cmath>

#include "io/csv.h"
#include "io/json.h"
#include "piste/math/earth.h"

namespace piste {
namespace {

std::string exact_or_null(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

void add_cell(std::string& text, double value, int decimals) {
  text += ',';
  if (std::isfinite(value)) append_fixed(text, value, decimals);
}

constexpr int kSecondDecimals = 6, kMetreDecimals = 4;

}  // namespace

std::string descents_json(const DescentReport& report) {
  std::vector<std::string> gates;
  for (const Passage& gate : report.gates) {
    json::Members runs;
    for (std::size_t r = 0; r < report.runs.size(); ++r) {
      const Crossing& c = gate.runs[r];
      runs.emplace_back(report.runs[r], json::object({{"time_s", exact_or_null(c.time)},
                                                      {"sigma_time_s", exact_or_null(c.sigma_time)},
                                                      {"offset_m", exact_or_null(c.offset)},
                                                      {"gained_s", exact_or_null(c.gained)},
                                                      {"sigma_gained_s", exact_or_null(c.sigma_gained)}}));
    }
    gates.push_back("\n    " + json::object({{"name", json::string(gate.name)},
                                             {"distance_m", exact_or_null(gate.distance)},
                                             {"runs", json::object(runs)}}));
  }
  std::string list = "[";
  for (std::size_t i = 0; i < gates.size(); ++i) list += (i > 0 ? "," : "") + gates[i];
  return json::object({{"runs", json::strings(report.runs)},
                       {"line", json::string(report.line)},
                       {"how_line", json::string(report.how_line)},
                       {"without_sigma", json::strings(report.without_sigma)},
                       {"gates", list + "\n  ]"}},
                      0) +
         "\n";
}

std::string gained_csv(const DescentReport& report) {
  std::string text = "distance_m";
  for (std::size_t r = 0; r < report.runs.size(); ++r) {
    const std::string& name = report.runs[r];
    if (r > 0) text += fmt::format(",gained_s_{0},sigma_s_{0}", name);
    text += fmt::format(",time_s_{0},offset_m_{0},speed_m_s_{0},energy_J_kg_{0},radius_m_{0},load_g_{0}", name);
  }
  text += '\n';
  for (const Passage& place : report.along) {
    append_fixed(text, place.distance, kMetreDecimals);
    for (std::size_t r = 0; r < report.runs.size(); ++r) {
      const Crossing& c = place.runs[r];
      if (r > 0) {
        add_cell(text, c.gained, kSecondDecimals);
        add_cell(text, c.sigma_gained, kSecondDecimals);
      }
      // Kinetic and potential, above the first crossing of the first run.
      const double energy =
          0.5 * c.speed * c.speed + kStandardGravity * (c.height - report.along.front().runs.front().height);
      add_cell(text, c.time, kSecondDecimals);
      for (const double value : {c.offset, c.speed, energy, std::min(c.radius, 1e6), c.load})
        add_cell(text, value, kMetreDecimals);
    }
    text += '\n';
  }
  return text;
}

std::string sections_csv(const DescentReport& report) {
  std::string text = "from,to,length_m";
  for (const std::string& name : report.runs) text += ",duration_s_" + name;
  for (std::size_t r = 1; r < report.runs.size(); ++r) text += fmt::format(",gained_s_{0},sigma_s_{0}", report.runs[r]);
  text += '\n';
  for (const Section& section : report.sections) {
    text += section.from + "," + section.to;
    add_cell(text, section.length, kMetreDecimals);
    for (const double duration : section.duration) add_cell(text, duration, kSecondDecimals);
    for (std::size_t r = 1; r < report.runs.size(); ++r) {
      add_cell(text, section.gained[r], kSecondDecimals);
      add_cell(text, section.sigma[r], kSecondDecimals);
    }
    text += '\n';
  }
  return text;
}

}  // namespace piste
