#include "piste/report/alignment_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "piste/core/state_table.h"
#include "piste/math/units.h"
#include "plot/markup.h"
#include "report/drawing.h"
#include "report/findings_tables.h"
#include "report/page.h"

namespace piste {
namespace {

constexpr std::string_view kHowToReadAlignment =
    R"(<p><strong>Clock offset and drift.</strong> Time of the reference = reading of the body IMU − offset − drift · (reading −
first reading). The correlation of the norms of the angular rates, which no mounting changes, gives the offset at which
the fit begins; the fit gives the rest.</p>
<p><strong>Boresight</strong> is roll, pitch, heading of the rotation that turns body components into those of the reference.
The <strong>lever arm</strong> goes from the reference to the body IMU, along the reference's axes.</p>
<p><strong>Biases and scales</strong> belong to the body IMU: measured = (1 + scale) · true + bias. They stand here because the
alignment needs them; the estimates that compare methods are made after it.</p>
<p><strong>The residual</strong> should be noise: flat where the sensor file's level is, without the shape of the motion. An
error of timing shows as a residual that grows with the rate of change of the signal, an error of boresight as one axis showing up in
another, a wrong lever arm as forces that grow with the square of the rate.</p>
<p><strong>Sigmas</strong> are those of the fit, with the noise as correlated in time as it was found.</p>
)";

// A value and its sigma with as many decimals as are significant.
page::Row row(const std::string& name, double value, double sigma) {
  if (!std::isfinite(sigma)) return {name, "not determined", ""};
  const int decimals = sigma > 0 ? std::clamp(1 - static_cast<int>(std::floor(std::log10(sigma))), 0, 12) : 6;
  return {name, fmt::format("{:.{}f}", value, decimals), fmt::format("{:.{}f}", sigma, decimals)};
}

std::string parameters(const Alignment& a) {
  using L = AlignmentLayout;
  const auto sigma = [&](int index) { return std::sqrt(a.variance(index)); };
  std::vector<page::Row> rows{row("clock offset at the first sample [s]", a.clock_offset, sigma(L::kClockOffset)),
                              row("clock drift [ppm]", 1e6 * a.clock_drift, 1e6 * sigma(L::kClockDrift))};
  const auto triad = [&](Block block, std::string_view unit, double factor, const Vector3d& value, const Vector3d& s) {
    for (int i = 0; i < 3; ++i) {
      std::string name(info(block).name);
      std::replace(name.begin(), name.end(), '_', ' ');
      rows.push_back(row(fmt::format("{} {} [{}]", name, info(block).axes[static_cast<std::size_t>(i)], unit),
                         factor * value(i), factor * s(i)));
    }
  };
  triad(Block::kBoresight, "deg", kDegreesPerRadian, to_euler(a.q_rb), a.boresight_sigma());
  triad(Block::kLeverArm, "mm", 1e3, a.p_rb_r, a.sigma(L::kLeverArm));
  std::string out =
      "<div class=\"tables\">\n" + page::table("Mounting and clocks", {"parameter", "value", "sigma"}, rows);
  rows.clear();
  triad(Block::kGyroBias, "deg/s", kDegreesPerRadian, a.gyro_bias, a.sigma(L::kGyroBias));
  triad(Block::kAccelBias, "m/s²", 1, a.accel_bias, a.sigma(L::kAccelBias));
  triad(Block::kGyroScale, "ppm", 1e6, a.gyro_scale, a.sigma(L::kGyroScale));
  triad(Block::kAccelScale, "ppm", 1e6, a.accel_scale, a.sigma(L::kAccelScale));
  return out + page::table("Errors of the body IMU", {"parameter", "value", "sigma"}, rows) + "</div>\n";
}

std::string result(const AlignmentPicture& p) {
  const Alignment& a = *p.alignment;
  return parameters(a) + page::list("The motion does not determine:", a.undetermined) +
         fmt::format("<p>Left in the band, root mean square of one axis: {:.4g} deg/s and {:.4g} m/s².</p>\n",
                     kDegreesPerRadian * a.gyro_residual, a.accel_residual);
}

// The head of a page: the four numbers for which one aligns.
std::string tiles(const Alignment& a) {
  using L = AlignmentLayout;
  const auto tile = [](std::string_view name, const page::Row& of, std::string_view unit) {
    return page::tile(name, fmt::format("{} {}", of[1], unit),
                      of[2].empty() ? "" : fmt::format("± {} {}", of[2], unit));
  };
  const auto largest = [](const Vector3d& sigma) { return sigma.maxCoeff(); };
  return page::tiles(
      {tile("Clock offset", row("", a.clock_offset, std::sqrt(a.variance(L::kClockOffset))), "s"),
       tile("Clock drift", row("", 1e6 * a.clock_drift, 1e6 * std::sqrt(a.variance(L::kClockDrift))), "ppm"),
       tile("Boresight, its angle",
            row("", kDegreesPerRadian * Eigen::AngleAxisd(a.q_rb).angle(),
                kDegreesPerRadian * largest(a.boresight_sigma())),
            "deg"),
       tile("Lever arm, its length", row("", 1e3 * a.p_rb_r.norm(), 1e3 * largest(a.sigma(L::kLeverArm))), "mm")});
}

std::string table_of(std::string_view caption, const TextTable& rows) {
  return page::wide(page::table(caption, rows.front(), {rows.begin() + 1, rows.end()}));
}

std::string errors(const Findings& found) {
  std::string out =
      fmt::format("<p class=\"soft\">{}. Values ± total sigma.</p>\n", escape_markup(phases_text(found))) +
      table_of("By axis: measured = (1 + scale) · true + bias", findings_by_axis(found));
  for (const TextTable& triad : findings_by_triad(found)) out += table_of("All axes of a triad at once", triad);
  return out;
}

}  // namespace

std::string alignment_html(const AlignmentPicture& p) {
  const std::string subtitle = fmt::format("piste {} · two IMUs on one plate, from {:.3f} to {:.3f} s of GPS time",
                                           escape_markup(p.version), p.aligned->time.front(), p.aligned->time.back());
  page::Drawing drawing;
  const std::string clocks = drawing.add(clock_figures(p)), correlation = drawing.add(correlation_figures(p)),
                    drift = drawing.add(drift_figures(p)), signals = drawing.add(signal_figures(p)),
                    spectra = drawing.add(spectrum_figures(p));
  return page::render(
      {.title = p.title,
       .subtitle = subtitle,
       .head = tiles(*p.alignment) + page::warnings(p.alignment->warnings) + drawing.head(),
       .sections = {{"result", "Result", result(p)},
                    {"errors", "Errors of the IMU", p.findings != nullptr ? errors(*p.findings) : ""},
                    {"clocks", "Before and after", clocks},
                    {"correlation", "Correlation", correlation},
                    {"drift", "The clock over time", drift},
                    {"signals", "Every axis", signals},
                    {"spectra", "Spectra", spectra},
                    {"reading", "How to read it", std::string(kHowToReadAlignment)},
                    {"configuration", "Configuration", fmt::format("<pre>{}</pre>\n", escape_markup(p.config_text))}},
       .style = drawing.style(),
       .scripts = drawing.scripts()});
}

}  // namespace piste
