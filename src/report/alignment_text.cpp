#include "piste/report/alignment_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "math/words.h"
#include "piste/core/state_table.h"

namespace piste {
namespace {

using Layout = AlignmentLayout;

constexpr double kPpm = 1e6;

std::string sigma_text(double value, double sigma, const char* unit) {
  return std::isfinite(sigma) ? fmt::format("{} {}", measured(value, sigma), unit) : std::string("not determined");
}

std::string triad_text(const Vector3d& value, const Vector3d& sigma, const char* unit) {
  const auto part = [&](int i) { return sigma_text(value(i), sigma(i), unit); };
  return fmt::format("{}, {}, {}", part(0), part(1), part(2));
}

}  // namespace

std::string alignment_text(const Alignment& a) {
  const double offset = std::sqrt(a.variance(Layout::kClockOffset)), drift = std::sqrt(a.variance(Layout::kClockDrift));
  std::string text = fmt::format(
      "clock: offset {}, drift {}\n"
      "boresight, roll pitch heading of R_rb: {}\n"
      "lever arm, r to b in r: {}",
      sigma_text(a.clock_offset, offset, "s"), sigma_text(kPpm * a.clock_drift, kPpm * drift, "ppm"),
      triad_text(kDegreesPerRadian * to_euler(a.q_rb), kDegreesPerRadian * a.boresight_sigma(), "deg"),
      triad_text(a.p_rb_r, a.sigma(Layout::kLeverArm), "m"));
  if (!a.undetermined.empty()) {
    text += fmt::format("\nthe motion does not determine: {}", fmt::join(a.undetermined, ", "));
  }
  for (const std::string& warning : a.warnings) text += "\nwarning: " + warning;
  return text;
}

}  // namespace piste
