#include "piste/report/inspection_text.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <utility>

#include "math/words.h"
#include "piste/math/earth.h"
#include "piste/math/units.h"

namespace piste {
namespace {

constexpr double kMicroG = 1e-6 * kStandardGravity;

std::string three(const Vector3d& v, double unit, std::string_view format, std::string_view name) {
  if (!v.allFinite()) return "not known";
  std::string text;
  for (int i = 0; i < 3; ++i) text += fmt::format(fmt::runtime(format), v(i) / unit) + ' ';
  return text + std::string(name);
}

std::string range(const TriadHealth& t, double unit, std::string_view name) {
  std::string text;
  for (int i = 0; i < 3; ++i) {
    text +=
        fmt::format("{} {:.4g} to {:.4g}{}", "xyz"[i], t.smallest(i) / unit, t.largest(i) / unit, i < 2 ? ", " : " ");
  }
  return text + std::string(name);
}

class SheetWriter {
 public:
  explicit SheetWriter(std::string title) : sheet_{std::move(title), {}} {}
  void add(std::string name, std::string text) { sheet_.facts.push_back({std::move(name), std::move(text)}); }
  InspectionSheet take() { return std::move(sheet_); }

  void rows(const Sampling& s, const RowFaults& faults) {
    add("rows", fmt::format("{}, from {:.3f} to {:.3f} s ({:.1f} s)", s.rows, s.span.start, s.span.end,
                            s.span.end - s.span.start));
    add("rate", fmt::format("{:.5g} Hz, jitter {:.3f} ms{}", s.rate(), 1e3 * s.jitter,
                            s.resolution > 0 ? fmt::format(", times in steps of {:.4g} ms", 1e3 * s.resolution) : ""));
    if (s.gaps.empty()) {
      add("gaps", "none");
    } else {
      const auto longest = std::max_element(s.gaps.begin(), s.gaps.end(), [](const Interval& a, const Interval& b) {
        return a.end - a.start < b.end - b.start;
      });
      add("gaps", fmt::format("{}, {} rows missing, the longest of {:.3f} s at {:.3f} s", s.gaps.size(), s.missing,
                              longest->end - longest->start, longest->start));
    }
    static constexpr std::array<std::string_view, RowFault::kKinds> kNames{
        "text", "NaN", "fields", "checksum", "repeated time", "time back", "impossible value"};
    if (faults.total() > 0) {
      std::vector<std::string> kinds;
      for (std::size_t i = 0; i < RowFault::kKinds; ++i) {
        if (faults.counts[i] > 0) kinds.push_back(fmt::format("{} {}", faults.counts[i], kNames[i]));
      }
      add("refused", fmt::format("{} rows: {}", faults.total(), fmt::join(kinds, ", ")));
    }
    if (!faults.unknown_columns.empty())
      add("passed over", fmt::format("columns {}", fmt::join(faults.unknown_columns, ", ")));
  }

 private:
  InspectionSheet sheet_;
};

void describe(SheetWriter& sheet, const ImuHealth& h) {
  sheet.add("values", h.increments ? "increments, as labelled" : "rates, as labelled");
  sheet.add("gyroscopes", range(h.gyro, kDegree, "deg/s"));
  sheet.add("accelerometers", range(h.accel, 1, "m/s^2"));
  for (const auto& [name, t, unit] : {std::tuple{"gyroscopes", &h.gyro, kDegree}, {"accelerometers", &h.accel, 1.0}}) {
    if (t->limit.maxCoeff() == 0) continue;
    sheet.add("clipping", fmt::format("{} x {} y {} z {} samples at {:.4g} {}", name, t->clipped[0], t->clipped[1],
                                      t->clipped[2], t->limit.maxCoeff() / unit, unit == 1.0 ? "m/s^2" : "deg/s"));
  }
  const double per = h.increments ? h.sampling.interval : 1;
  sheet.add("smallest step", fmt::format("gyroscopes {:.3g} deg/s, accelerometers {:.3g} m/s^2",
                                         h.gyro.quantum.maxCoeff() / kDegree / per, h.accel.quantum.maxCoeff() / per));
  if (h.rest.empty()) {
    sheet.add("rest", "none of two seconds");
  } else {
    double all = 0;
    for (const Interval& r : h.rest) all += r.end - r.start;
    sheet.add("rest", fmt::format("{:.0f} s in {} intervals, the first from {:.1f} to {:.1f} s", all, h.rest.size(),
                                  h.rest.front().start, h.rest.front().end));
    sheet.add("noise at rest", three(h.gyro.noise, kDegree, "{:.3g}", "deg/s/sqrt(Hz), ") +
                                   three(h.accel.noise, kMicroG, "{:.3g}", "ug/sqrt(Hz)"));
    sheet.add("mean at rest",
              three(h.gyro.mean, kDegree, "{:.3f}", "deg/s, ") + three(h.accel.mean, 1, "{:.3f}", "m/s^2"));
  }
  sheet.add("gravity", h.has_gravity
                           ? fmt::format("{:.3f} m/s^2 {}", h.force, h.rest.empty() ? "(median in motion)" : "at rest")
                           : std::string("not in the accelerations"));
  if (h.magnetic_rows > 0) sheet.add("magnetometer", fmt::format("{} rows", h.magnetic_rows));
}

void describe(SheetWriter& sheet, const GnssHealth& h) {
  static constexpr std::array<std::string_view, kQualities> kNames{"unknown", "single", "sbas",  "differential",
                                                                   "precise", "float",  "fixed", "dead reckoned"};
  std::vector<std::string> kinds;
  for (std::size_t i = 0; i < kNames.size(); ++i) {
    if (h.qualities[i] > 0) kinds.push_back(fmt::format("{} {}", h.qualities[i], kNames[i]));
  }
  if (h.without_fix > 0) kinds.push_back(fmt::format("{} epochs without fix", h.without_fix));
  sheet.add("quality", fmt::format("{}", fmt::join(kinds, ", ")));
  sheet.add("sigma", fmt::format("median {}; smallest {}; largest {}", three(h.median_sigma, 1, "{:.3g}", "m"),
                                 three(h.smallest_sigma, 1, "{:.3g}", "m"), three(h.largest_sigma, 1, "{:.3g}", "m")));
  sheet.add("scatter", fmt::format("from fix to fix {}; at rest {}", three(h.noise, 1, "{:.3g}", "m"),
                                   three(h.rest_scatter, 1, "{:.3g}", "m")));
  sheet.add("speed", fmt::format("median {:.1f} m/s under way, at most {:.1f} m/s", h.speed, h.top_speed));
  sheet.add("height", fmt::format("{:.1f} to {:.1f} m", h.lowest, h.highest));
  sheet.add("jumps", h.jumps.empty() ? std::string("none")
                                     : fmt::format("{}, the first of {:.1f} m at {:.3f} s", h.jumps.size(),
                                                   h.jumps.front().distance, h.jumps.front().time));
  if (!h.repeated.empty()) {
    sheet.add("repeated fixes", fmt::format("{} stretches, the first from {:.3f} to {:.3f} s", h.repeated.size(),
                                            h.repeated.front().start, h.repeated.front().end));
  }
  if (h.quantum.maxCoeff() > 0) sheet.add("rounded", three(h.quantum, 1, "{:.3g}", "m (north east down)"));
  if (h.velocities == 0) {
    sheet.add("velocity", "none");
  } else if (!h.velocity) {
    sheet.add("velocity", fmt::format("{} fixes", h.velocities));
  } else {
    const VelocityFit& v = *h.velocity;
    sheet.add("velocity",
              fmt::format("{} fixes, {} of the positions within {:.3g} m/s{}", h.velocities,
                          v.as_given() ? "the derivative" : "NOT the derivative", v.residual_as_given,
                          std::isfinite(v.sigma_delay)
                              ? fmt::format(", later than them by {:.3f} s +- {:.3f}", v.delay, v.sigma_delay)
                              : ""));
  }
}

void describe(SheetWriter& sheet, const LogMatch& m) {
  sheet.add("overlap", fmt::format("{:.1f} s as the clocks stand", m.overlap));
  if (m.clock) {
    const std::string by = m.clock->by_rest ? "by when the body rests in both"
                                            : fmt::format("correlation of the turn rates {:.2f}", m.clock->correlation);
    sheet.add("clock", fmt::format("the IMU's is {} {} the receiver's, +- {}; {}", time_text(std::abs(m.clock->offset)),
                                   m.clock->offset < 0 ? "behind" : "ahead of", time_text(m.clock->sigma), by));
  } else {
    sheet.add("clock", "the offset is not determined by the motion");
  }
  if (!m.motion) {
    sheet.add("axes", "not determined by the motion");
    return;
  }
  sheet.add(
      "axes",
      fmt::format("{} point forward, right, down; {:.1f} deg off on average, the next best choice {:.0f} deg more",
                  m.motion->axes, m.motion->tilt / kDegree, m.motion->margin / kDegree) +
          (m.motion->as_likely.empty() ? "" : fmt::format("; as likely: {}", fmt::join(m.motion->as_likely, ", "))));
  sheet.add("units", fmt::format("by the motion, gyroscopes are to be multiplied by {:.4g}, forces by {:.4g}",
                                 m.motion->gyro_factor, m.motion->accel_factor));
}

void describe(SheetWriter& sheet, const AttitudeMatch& m) {
  sheet.add("overlap", fmt::format("{:.1f} s as the clocks stand", m.overlap));
  if (m.correlation > 0) sheet.add("correlation", fmt::format("{:.3f} of the magnitudes of the rates", m.correlation));
  if (!m.fit) {
    sheet.add("clock and axes", m.why_not);
    return;
  }
  const AttitudeFit& f = *m.fit;
  sheet.add("clock", fmt::format("the attitude's times are {} +- {}", delay_text(attitude_delay(f, 0)),
                                 time_text(f.sigma_offset)));
  sheet.add("axes", fmt::format("its forward, right, down are {} of the IMU", axes_text(f.axes)));
  sheet.add("boresight", three(to_euler(f.left), kDegree, "{:.3f}", "deg +- ") +
                             three(f.sigma_left, kDegree, "{:.3f}", "(roll pitch heading, relative to these axes)"));
  sheet.add("rates", fmt::format("{} deg/s (rms) are left of {} deg/s; the gyroscopes are off by {}",
                                 plain(f.residual / kDegree, 2), plain(f.rate / kDegree, 2),
                                 three(f.gyro_bias, kDegree, "{:.3f}", "deg/s")));
}

InspectionSheet sheet_of(const InspectedLog& log) {
  if (!log.guess) {
    SheetWriter sheet(log.log.file);
    sheet.add("format", log.left_out.empty() ? "none that piste reads" : "left aside: " + log.left_out);
    return sheet.take();
  }
  SheetWriter sheet(fmt::format("{}: {}", log.log.file, name_of(log.guess->kind)));
  sheet.add("format", fmt::format("{} ({})", name_of(log.guess->format), log.guess->why));
  for (const std::string& doubt : log.guess->doubts) sheet.add("to be checked", doubt);
  if (log.log.repair) sheet.add("repaired", log.repaired());
  if (log.imu.stamp_jitter > 0) {
    sheet.add("stamps", fmt::format("scatter by {} (rms) about the even clock of the samples, on which they are laid",
                                    time_text(log.imu.stamp_jitter)));
  }
  if (log.imu.unpaired > 0)
    sheet.add("unpaired", fmt::format("{} rows without those of the other file", log.imu.unpaired));
  if (log.clock) {
    sheet.add("its clock",
              fmt::format("ahead of GPS time by {:.4f} s at {:.3f} s, {:.2f} ppm; fixes come with +- {:.3f} s",
                          log.clock->offset, log.clock->since, 1e6 * log.clock->drift, log.clock->scatter));
  }
  if (log.imu_health) {
    sheet.rows(log.imu_health->sampling, log.faults);
    describe(sheet, *log.imu_health);
  } else if (log.gnss_health) {
    sheet.rows(log.gnss_health->sampling, log.faults);
    describe(sheet, *log.gnss_health);
  } else if (log.attitude_sampling) {
    sheet.rows(*log.attitude_sampling, log.faults);
  } else {
    sheet.add("rows", "too few to determine anything");
  }
  return sheet.take();
}

}  // namespace

std::vector<InspectionSheet> inspection_sheets(const Inspection& inspection) {
  std::vector<InspectionSheet> sheets;
  for (const InspectedLog& log : inspection.logs) sheets.push_back(sheet_of(log));
  for (const InspectedMatch& m : inspection.matches) {
    SheetWriter sheet(
        fmt::format("{} compared with {}", inspection.logs[m.imu].log.file, inspection.logs[m.gnss].log.file));
    describe(sheet, m.match);
    if (&m.match == inspection.first_match() && inspection.vehicle.is_car())
      sheet.add("a car", inspection.vehicle.why());
    if (m.imu == inspection.first(LogKind::kImu) && inspection.logs[m.gnss].calibration) {
      const Calibration& found = *inspection.logs[m.gnss].calibration;
      sheet.add("lever arm",
                fmt::format("{} +- {} (forward right down), from a filter that took {} and rejected {} measurements",
                            three(found.lever_arm, 1, "{:.2f}", "m"), three(found.lever_arm_sigma, 1, "{:.2f}", "m"),
                            found.used, found.rejected) +
                    (found.fits() && found.in_housing ? "; IMU and antenna are taken to be in one housing"
                     : !found.tells_arm()             ? "; it is not in the configuration: too rough, or not fitting"
                                                      : ""));
      sheet.add("in motion",
                fmt::format("clock {:.4f} s +- {:.4f} s, drift {:.1f} ppm; noise {} deg/s/sqrt(Hz), {} ug/sqrt(Hz)",
                            found.clock_offset, found.clock_sigma, 1e6 * found.clock_drift,
                            plain(found.sensor.gyro.noise / kDegree, 2),
                            plain(found.sensor.accel.noise / kStandardGravity * 1e6, 2)));
    }
    sheets.push_back(sheet.take());
  }
  for (const InspectedAttitude& a : inspection.attitudes) {
    SheetWriter sheet(
        fmt::format("{} compared with {}", inspection.logs[a.attitude].log.file, inspection.logs[a.imu].log.file));
    describe(sheet, a.match);
    sheets.push_back(sheet.take());
  }
  return sheets;
}

std::string inspection_text(const Inspection& inspection, const std::optional<std::string>& config) {
  std::string text;
  for (const InspectionSheet& sheet : inspection_sheets(inspection)) {
    text += sheet.title + '\n';
    for (const auto& [name, fact] : sheet.facts) text += fmt::format("  {:<15} {}\n", name, fact);
    text += '\n';
  }
  if (config) text += "A configuration for replay:\n\n" + *config + '\n';
  if (inspection.suspicions.empty()) return text + "Nothing looks wrong.\n";
  text += "What looks wrong, the worst first:\n";
  for (std::size_t i = 0; i < inspection.suspicions.size(); ++i) {
    const Suspicion& s = inspection.suspicions[i];
    if (i > 0 && !is_severe(s.fault) && is_severe(inspection.suspicions[i - 1].fault)) text += "Worth knowing:\n";
    text += fmt::format("{:3}. {}: {}\n     {}\n", i + 1, s.file, s.what, s.remedy);
  }
  return text;
}

}  // namespace piste
