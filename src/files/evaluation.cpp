#include "piste/files/evaluation.h"

#include <fmt/format.h>

#include <cmath>

#include "io/csv.h"
#include "io/json.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// The shortest text that is read back as the same number.
std::string exact(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

std::string exact(const Vector3d& v) { return fmt::format("[{}, {}, {}]", exact(v.x()), exact(v.y()), exact(v.z())); }

json::Members statistics(const ErrorStatistics& s, std::string_view unit, double factor) {
  json::Members members;
  for (const auto& [name, value] : std::initializer_list<std::pair<std::string_view, double>>{
           {"rmse", s.rmse}, {"mean", s.mean}, {"median", s.median}, {"std", s.std}, {"min", s.min}, {"max", s.max}}) {
    members.emplace_back(fmt::format("{}_{}", name, unit), exact(factor * value));
  }
  return members;
}

std::string rotation_of(const std::optional<ErrorStatistics>& s) {
  return s ? json::object(statistics(*s, "deg", kDegreesPerRadian)) : "null";
}

std::string align_entry(const Evaluation& found) {
  const Similarity& motion = found.alignment;
  const auto row = [&](int i) { return exact(Vector3d(motion.rotation.row(i))); };
  return json::object({{"kind", json::string(name_of(found.options.align))},
                       {"rotation", json::array({row(0), row(1), row(2)})},
                       {"translation_m", exact(motion.translation)},
                       {"scale", exact(motion.scale)}},
                      1);
}

std::string ape_entry(const Evaluation& found) {
  json::Members members = statistics(found.ape, "m", 1);
  members.emplace_back("rotation", rotation_of(found.ape_rotation));
  members.emplace_back("cep50_m", exact(found.cep50));
  members.emplace_back("cep95_m", exact(found.cep95));
  return json::object(members, 1);
}

std::string rpe_entry(const Evaluation& found) {
  json::Members steps;
  for (const RelativeErrors& errors : found.rpe) {
    json::Members members{{"pairs", fmt::format("{}", errors.pairs)}};
    if (errors.distance) {
      for (auto& member : statistics(*errors.distance, "m", 1)) members.push_back(std::move(member));
      members.emplace_back("rotation", rotation_of(errors.rotation));
    }
    steps.emplace_back(errors.step.name(), json::object(members));
  }
  return json::object(steps, 1);
}

std::string sigma_entry(const Evaluation& found) {
  json::Members members;
  for (std::size_t i = 0; i < kNavigationErrors; ++i) {
    const auto& share = found.within_sigma[i];
    if (std::isnan(share[0])) continue;
    members.emplace_back(std::string(navigation_error_name(i)),
                         json::array({exact(share[0]), exact(share[1]), exact(share[2])}));
  }
  return members.empty() ? "{}" : json::object(members, 1);
}

// Errors of angles are in degrees.
double factor_of(std::size_t error) { return error < 6 ? 1 : kDegreesPerRadian; }

void append_cell(std::string& text, double value, int decimals) {
  text += ',';
  if (std::isfinite(value)) append_fixed(text, value, decimals);
}

}  // namespace

std::string evaluation_json(const Evaluation& found) {
  json::Members members{{"estimate", json::string(found.estimate)},       {"reference", json::string(found.reference)},
                        {"epochs", fmt::format("{}", found.rows.size())}, {"in_gaps", fmt::format("{}", found.in_gaps)},
                        {"outside", fmt::format("{}", found.outside)},    {"time_offset_s", exact(found.time_offset)}};
  if (found.options.find_offset) members.emplace_back("sigma_time_offset_s", exact(found.sigma_time_offset));
  members.emplace_back("align", align_entry(found));
  members.emplace_back("ape", ape_entry(found));
  members.emplace_back("rpe", rpe_entry(found));
  members.emplace_back("within_sigma", sigma_entry(found));
  if (found.nees) members.emplace_back("nees", exact(*found.nees));
  return json::object(members, 0) + "\n";
}

std::string evaluation_csv(const Evaluation& found) {
  constexpr int kTime = 6, kMetres = 6, kDegrees = 7;
  std::string text = "time_s,error_along_m,error_right_m,error_up_m";
  for (std::size_t i = 0; i < kNavigationErrors; ++i) text += fmt::format(",error_{}", navigation_error_name(i));
  for (std::size_t i = 0; i < kNavigationErrors; ++i) text += fmt::format(",sigma_{}", navigation_error_name(i));
  text += ",distance_m,angle_deg";
  if (found.nees) text += ",nees";
  text += '\n';
  for (const ErrorRow& row : found.rows) {
    append_fixed(text, row.time, kTime);
    for (const double value : {row.along, row.across, row.up}) append_cell(text, value, kMetres);
    for (const auto& values : {row.error, row.sigma}) {
      for (std::size_t i = 0; i < kNavigationErrors; ++i) {
        append_cell(text, factor_of(i) * values[i], i < 6 ? kMetres : kDegrees);
      }
    }
    append_cell(text, row.distance, kMetres);
    append_cell(text, kDegreesPerRadian * row.angle, kDegrees);
    if (found.nees) append_cell(text, row.nees, kMetres);
    text += '\n';
  }
  return text;
}

}  // namespace piste
