#include "search/examine.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/receiver_class.h"
#include "core/recording.h"
#include "inspect/clock_leaps.h"
#include "inspect/column_repair.h"
#include "inspect/imu_bounds.h"
#include "inspect/tilt_rate.h"
#include "io/left_out_rows.h"
#include "piste/core/error.h"
#include "piste/io/log_io.h"
#include "piste/math/earth.h"
#include "piste/math/statistics.h"
#include "piste/math/units.h"
#include "search/joined.h"

namespace piste {
namespace {

const Vector3d& sigma_of(const GeodeticFix& fix) { return fix.sigma_position; }
const Vector3d& sigma_of(const EulerFix& fix) { return fix.sigma; }

// Whether a log has no sigmas. Readers of some formats give infinite sigmas if none is stated.
template <class Recorded>
bool says_no_sigma(const Recorded& recorded) {
  return !recorded.fixes.empty() && std::none_of(recorded.fixes.begin(), recorded.fixes.end(),
                                                 [](const auto& fix) { return sigma_of(fix).allFinite(); });
}

// Whether a row has the values of the one before.
bool repeats(const ImuRecording& imu, std::size_t i) {
  return imu.gyro[i] == imu.gyro[i - 1] && imu.accel[i] == imu.accel[i - 1];
}
bool repeats(const GnssRecording& gnss, std::size_t i) {
  const Geodetic &now = gnss.fixes[i].position, &before = gnss.fixes[i - 1].position;
  return now.latitude == before.latitude && now.longitude == before.longitude && now.height == before.height;
}

std::size_t rows_of(const ImuRecording& imu) { return imu.time.size(); }
template <class Recorded>
std::size_t rows_of(const Recorded& recorded) {
  return recorded.fixes.size();
}

// Reads a log again with the corrections found in it. Its faults are listed already.
template <class Recorded>
void read_once_more(const InspectedLog& l, Recorded& recorded, Recorded (*read)(const LogFile&, RowFaults*)) {
  RowFaults again;
  recorded = read(l.log, &again);
  if (l.log.repair) recorded.repaired.unreadable = again.total();
}

// Reads a log without sigmas again, with a sigma that a user might state.
template <class Recorded>
void read_again(InspectedLog& l, const Vector3d& sigma, Recorded& recorded,
                Recorded (*read)(const LogFile&, RowFaults*)) {
  l.log.sigma = sigma;
  l.faults = {};
  recorded = read(l.log, &l.faults);
}

// Reads a log with a coarse clock again: most of its rows have the stamp of the row before, but their own values.
template <class Recorded>
void read_spread(InspectedLog& l, Recorded& recorded, Recorded (*read)(const LogFile&, RowFaults*)) {
  const std::size_t shared = l.faults.count(RowFault::Kind::kTimeRepeated);
  if (2 * shared < shared + rows_of(recorded)) return;
  InspectedLog spread = l;
  spread.log.shared_stamps = true;
  spread.faults = {};
  Recorded again = read(spread.log, &spread.faults);
  std::size_t same = 0;
  for (std::size_t i = 1; i < rows_of(again); ++i) same += repeats(again, i) ? 1 : 0;
  if (2 * same >= shared) return;
  l = std::move(spread);
  recorded = std::move(again);
}

// Reads a log again with its rows sorted, or without a few unreadable rows. The faults stay listed.
template <class Recorded>
void read_repaired(InspectedLog& l, Recorded& recorded, Recorded (*read)(const LogFile&, RowFaults*)) {
  const std::size_t misplaced =
      l.faults.count(RowFault::Kind::kTimeRepeated) + l.faults.count(RowFault::Kind::kTimeBack);
  const std::size_t unreadable = l.faults.total() - misplaced;
  const bool few = unreadable > 0 && LeftOutRows::are_few(unreadable, rows_of(recorded) + misplaced) &&
                   l.faults.count(RowFault::Kind::kValue) == 0;
  if (misplaced == 0 && !few) return;
  l.log.repair = true;
  read_once_more(l, recorded, read);
}

// The clock of a logger whose log has both its own time and the time of each fix.
std::optional<ReceiverClock> clock_of(const InspectedLog& l) {
  if (!l.guess->boot_time) return std::nullopt;
  InspectedLog boot = l;
  boot.log.columns->time = *l.guess->boot_time;
  RowFaults faults;
  boot.gnss = read_gnss(boot.log, &faults);
  if (boot.gnss.fixes.size() != l.gnss.fixes.size()) return std::nullopt;  // the rows of one are not those of the other
  std::vector<double> logger, gps;
  for (const GeodeticFix& fix : boot.gnss.fixes) logger.push_back(fix.time);
  for (const GeodeticFix& fix : l.gnss.fixes) gps.push_back(fix.time);
  return fit_clock(logger, gps);
}

// The clock of a logger that writes its own time next to that of the receiver, in rows of their own.
std::optional<ReceiverClock> clock_told(const InspectedLog& l) {
  if (l.guess->clock.empty()) return std::nullopt;
  std::vector<double> logger, gps, offsets;
  for (const auto& [own, of_receiver] : l.guess->clock) {
    logger.push_back(own);
    gps.push_back(of_receiver);
    offsets.push_back(own - of_receiver);
  }
  if (auto fitted = fit_clock(logger, gps)) return fitted;
  ReceiverClock clock;  // of few pairs: without a drift
  clock.offset = median(std::move(offsets));
  clock.since = l.imu.time.empty() ? logger.front() : l.imu.time.front();
  clock.span = {clock.since, l.imu.time.empty() ? logger.back() : l.imu.time.back()};
  return clock;
}

// A receiver that states the same coarse accuracy for all its velocities, as phones do, does not know it. Then the
// sigma is measured against the derivative of the positions.
void state_velocity_sigma(InspectedLog& l) {
  constexpr double kCoarser = 5, kLeast = 0.3;  // times the measured sigma; m/s: errors are correlated
  const auto& fit = l.gnss_health->velocity;
  if (l.log.sigma_velocity || !fit || !fit->as_given()) return;
  const FixVelocity* first = nullptr;
  for (const GeodeticFix& fix : l.gnss.fixes) {
    if (!fix.velocity) continue;
    if (first == nullptr) first = &*fix.velocity;
    if (fix.velocity->sigma.head<2>().maxCoeff() != first->sigma.head<2>().maxCoeff()) return;
  }
  const double measured = std::max(kLeast, 2 * fit->residual);
  if (first == nullptr || first->sigma.x() < kCoarser * measured) return;
  l.coarse_velocity_sigma = first->sigma.x();
  l.log.sigma_velocity = Vector3d::Constant(std::ceil(10 * measured) / 10);
  read_once_more(l, l.gnss, read_gnss);
  l.gnss_health = gnss_health(l.gnss);
}

// Reads a log without sigmas again: with those that are usual of the quality that most fixes have, and factors for the
// others.
void read_with_usual_sigmas(InspectedLog& l) {
  std::array<std::size_t, kQualities> counts{};
  for (const GeodeticFix& fix : l.gnss.fixes) ++counts[static_cast<std::size_t>(fix.quality)];
  const auto most = static_cast<std::size_t>(std::max_element(counts.begin(), counts.end()) - counts.begin());
  const ReceiverClass& usual = receiver_class(static_cast<FixQuality>(most));
  for (std::size_t i = 0; i < kQualities; ++i) {
    const double factor = receiver_class(static_cast<FixQuality>(i)).axes[0] / usual.axes[0];
    if (counts[i] > 0 && factor != 1) l.log.sigma_scales.of_quality[i] = factor;
  }
  read_again(l, usual.sigma(), l.gnss, read_gnss);
}

// Leaves out velocities that are no derivative of the positions, by ten of their sigmas and more than positions that
// scatter explain: a course in another unit, or another sensor's speed.
void leave_out_refuted_velocities(InspectedLog& l) {
  constexpr double kSigmas = 10, kLeast = 0.7, kOfSpeed = 0.3;  // m/s of the scatter; a late velocity explains a part
  const GnssHealth& h = *l.gnss_health;
  if (!h.velocity || !h.velocity->as_given() || !(h.sigma_velocity > 0)) return;
  if (h.velocity->residual < std::max({kSigmas * h.sigma_velocity, kLeast, kOfSpeed * h.speed})) return;
  l.velocities_refuted = true;
  for (GeodeticFix& fix : l.gnss.fixes) fix.velocity.reset();
  const VelocityFit fit = *h.velocity;
  l.gnss_health = gnss_health(l.gnss);
  l.gnss_health->velocity = fit;
}

void read_receiver(InspectedLog& l) {
  constexpr double kUsualVelocity = 0.5;  // m/s
  if (const auto& map = l.log.columns) {
    const bool moves = map->find("velocity") != nullptr || map->find("speed") != nullptr;
    const bool stated = map->find("sigma_velocity") != nullptr || map->find("speed_accuracy") != nullptr;
    if (moves && !stated) l.log.sigma_velocity = Vector3d::Constant(kUsualVelocity);
  }
  const bool without_sigmas = l.log.format == LogFormat::kNovatel || l.log.format == LogFormat::kNmea;
  if (without_sigmas) l.log.sigma_velocity = Vector3d::Constant(kUsualVelocity);
  l.gnss = read_gnss(l.log, &l.faults);
  if (says_no_sigma(l.gnss)) read_with_usual_sigmas(l);
  read_spread(l, l.gnss, read_gnss);
  read_repaired(l, l.gnss, read_gnss);
  l.clock = clock_of(l);
  if (l.gnss.fixes.size() < 3) return;
  l.gnss_health = gnss_health(l.gnss);
  if (without_sigmas && l.gnss_health->velocities == 0) l.log.sigma_velocity.reset();
  if (l.gnss.above_sea > 0) {
    l.guess->doubts.emplace_back(
        "height: above the sea, and taken as above the ellipsoid, as no sentence has the geoid's height: add it where "
        "that matters, up to 100 m");
  }
  state_velocity_sigma(l);
  leave_out_refuted_velocities(l);
}

// Takes the unit of rates that no header states from the motion: as fast as gravity turns in the body.
void judge_rate_unit(InspectedLog& l) {
  if (!l.guess->guessed_rates || !l.log.columns) return;
  const auto gyro = l.log.columns->uses.find("gyro");
  if (gyro == l.log.columns->uses.end()) return;  // increments, as the motion has them
  std::string& unit = gyro->second.unit;
  if (unit != "rad/s" && unit != "deg/s") return;
  const auto factor = rate_factor_by_tilt(l.imu);
  if (!factor) return;
  std::erase_if(l.guess->doubts, [](const std::string& doubt) { return doubt.starts_with("gyro:"); });
  const std::string likelier = *factor == 1 ? unit : unit == "rad/s" ? "deg/s" : "rad/s";
  if (*factor != 1 && std::abs(*factor - (unit == "rad/s" ? kDegree : kDegreesPerRadian)) > 1e-6 * *factor) return;
  l.guess->doubts.push_back(fmt::format("gyro: in {}, as gravity turns in the body", likelier));
  if (unit == likelier) return;
  unit = likelier;
  l.guess->columns = l.log.columns;
  l.faults = {};
  l.imu = read_imu(l.log, &l.faults);
}

// Whether rows behind a step are those of before, as of a log that stands in the file twice.
bool repeats_itself(const ImuRecording& imu, const ClockStep& step) {
  const auto behind =
      static_cast<std::size_t>(std::adjacent_find(imu.time.begin(), imu.time.end(),
                                                  [&](double a, double b) { return a == step.time && b <= a; }) -
                               imu.time.begin() + 1);
  if (behind >= imu.time.size()) return false;
  for (std::size_t i = behind; i-- > 0 && imu.time[i] >= imu.time[behind];) {
    if (imu.gyro[i] == imu.gyro[behind] && imu.accel[i] == imu.accel[behind]) return true;
  }
  return false;
}

// Reads the log of a clock that was set back under way again, without these steps.
void take_out_steps(InspectedLog& l) {
  if (l.faults.count(RowFault::Kind::kTimeBack) == 0) return;
  InspectedLog standing = l;
  standing.log.as_it_stands = true;
  RowFaults ignored;
  const ImuRecording rows = read_imu(standing.log, &ignored);
  std::vector<ClockStep> steps = clock_steps(rows.time);
  if (steps.empty() || std::any_of(steps.begin(), steps.end(), [&](const auto& s) { return repeats_itself(rows, s); }))
    return;
  l.log.clock_steps = std::move(steps);
  l.faults = {};
  l.imu = read_imu(l.log, &l.faults);
}

Suspicion step_of_clock(const ClockStep& step, const std::string& file) {
  const std::string shown = step.step < 0 ? "and goes on evenly: a step of the clock, no disorder of rows"
                                          : "where the fixes go on: a step of the clock, no missing rows";
  return {LogFault::kClockJump, file,
          fmt::format("its clock was set {} by {:.6g} s behind t = {:.6f} s, {}", step.step < 0 ? "back" : "forward",
                      std::abs(step.step), step.time, shown),
          fmt::format("`clock: {{steps: [[{:.6f} s, {:.6g} s]]}}` takes it out, as the configuration does", step.time,
                      step.step)};
}

// Takes forces as small as gravity over the interval between rows, without a unit, for increments, and the rates with
// them: no log has the one without the other. At some 0.1 s they may as well be forces in g.
void judge_increments(InspectedLog& l) {
  const auto increments = [](const ImuHealth& h) {
    return h.force_unit && h.force_unit->fault == LogFault::kIncrementsForRates &&
           std::abs(std::log(kStandardGravity * h.sampling.interval)) > std::log(kGravityTolerance);
  };
  if (!l.guess->guessed_rates || !l.log.columns || !l.imu_health || !increments(*l.imu_health)) return;
  const ColumnMap& read = *l.log.columns;
  const ColumnUse *gyro = read.find("gyro"), *accel = read.find("accel");
  if (gyro == nullptr || accel == nullptr || !l.log.accel_file.empty() || accel->unit != "m/s^2") return;
  l.log.columns = l.guess->columns = increments_for_rates(read);
  std::erase_if(l.guess->doubts,
                [](const std::string& d) { return d.starts_with("gyro:") || d.starts_with("accel:"); });
  l.guess->doubts.emplace_back("gyro, accel: increments over the interval between rows, as gravity is in them");
  l.faults = {};
  l.imu = read_imu(l.log, &l.faults);
  l.imu_health = imu_health(l.imu);
}

// Stamps are judged as logged; all else is examined with the stamps that replay will use.
void read_body(InspectedLog& l) {
  l.log.even_stamps = false;
  l.imu = read_imu(l.log, &l.faults);
  take_out_steps(l);
  judge_rate_unit(l);
  read_spread(l, l.imu, read_imu);
  read_repaired(l, l.imu, read_imu);
  l.clock = clock_told(l);
  if (l.imu.time.size() >= 3) l.imu_health = imu_health(l.imu);
  judge_increments(l);
  l.log.even_stamps = true;
  if (l.log.accel_file.empty()) {
    even_stamps(l.imu);
  } else {
    read_once_more(l, l.imu, read_imu);
  }
}

void read_reference(InspectedLog& l) {
  const Vector3d kUsualAngle = Vector3d(1, 1, 2) / kDegreesPerRadian;  // of roll, pitch, heading
  l.attitude = read_attitude(l.log, &l.faults);
  if (says_no_sigma(l.attitude)) read_again(l, kUsualAngle, l.attitude, read_attitude);
  read_repaired(l, l.attitude, read_attitude);
  std::vector<double> time;
  time.reserve(l.attitude.fixes.size());
  for (const EulerFix& fix : l.attitude.fixes) time.push_back(fix.time);
  if (time.size() >= 3) l.attitude_sampling = sampling(time);
}

// The times in which a receiver moves, by its velocities, else by its positions.
std::vector<Interval> moving_times(const GnssRecording& gnss) {
  constexpr double kSlow = 1, kSure = 5, kLongest = 3;  // m/s; sigmas; s between fixes
  std::vector<Interval> moving;
  for (std::size_t i = 1; i < gnss.fixes.size(); ++i) {
    const GeodeticFix &before = gnss.fixes[i - 1], &now = gnss.fixes[i];
    const double dt = now.time - before.time;
    if (!(dt > 0 && dt <= kLongest)) continue;
    const auto moves = [&](const GeodeticFix& fix) {
      return fix.velocity->value.head<2>().norm() > std::max(kSlow, kSure * fix.velocity->sigma.head<2>().maxCoeff());
    };
    bool moved = before.velocity && now.velocity && moves(before) && moves(now);
    if (!before.velocity || !now.velocity) {
      const double spread = before.sigma_position.head<2>().norm() + now.sigma_position.head<2>().norm();
      moved =
          World(before.position).from_geodetic(now.position).head<2>().norm() > std::max(kSlow * dt, kSure * spread);
    }
    if (!moved) continue;
    if (!moving.empty() && moving.back().end == before.time) {
      moving.back().end = now.time;
    } else {
      moving.push_back({before.time, now.time});
    }
  }
  return moving;
}

}  // namespace

void judge_rests(Inspection& inspection) {
  const auto imu = inspection.first(LogKind::kImu), gnss = inspection.first(LogKind::kGnss);
  const LogMatch* match = inspection.first_match();
  if (!imu || !gnss || match == nullptr || !inspection.logs[*imu].imu_health || !inspection.logs[*gnss].gnss_health)
    return;
  if (inspection.imu_clock() != nullptr || (!match->clock && !(match->overlap > 0))) return;
  const double offset = match->clock ? match->clock->offset : 0;
  std::vector<Interval> moving = moving_times(inspection.logs[*gnss].gnss);
  for (Interval& span : moving) span = {span.start + offset, span.end + offset};
  InspectedLog& body = inspection.logs[*imu];
  const ImuHealth judged = imu_health(body.imu, moving);
  if (judged.rest.size() == body.imu_health->rest.size() && judged.force == body.imu_health->force) return;
  body.imu_health = judged;
}

void take_out_leaps(Inspection& inspection) {
  const auto imu = inspection.first(LogKind::kImu), gnss = inspection.first(LogKind::kGnss);
  if (!imu || !gnss || inspection.imu_clock() != nullptr) return;
  InspectedLog& body = inspection.logs[*imu];
  const InspectedLog& receiver = inspection.logs[*gnss];
  if (!body.imu_health || !receiver.gnss_health || !body.log.clock_steps.empty() || !body.log.accel_file.empty())
    return;
  const auto leaps = clock_leaps(body.imu, body.imu_health->sampling.gaps, receiver.gnss, *receiver.gnss_health);
  if (leaps.empty()) return;
  body.log.clock_steps = leaps;
  read_once_more(body, body.imu, read_imu);
  body.imu_health = imu_health(body.imu);
  const auto is_gap = [&](const Suspicion& s) { return s.fault == LogFault::kGaps && s.file == body.log.file; };
  std::erase_if(inspection.suspicions, is_gap);
  for (const ClockStep& step : leaps) inspection.suspicions.push_back(step_of_clock(step, body.log.file));
  for (Suspicion& s : suspicions(*body.imu_health, {}, body.log.file)) {
    if (is_gap(s)) inspection.suspicions.push_back(std::move(s));
  }
}

void examine(InspectedLog& l, std::vector<Suspicion>& found) {
  constexpr double kFastestGnss = 100, kSlowestGnss = 0.02, kFastestAttitude = 2000, kSlowestAttitude = 0.02;  // Hz
  if (!l.guess) return;
  const std::string& file = l.log.file;
  try {
    switch (l.guess->kind) {
      case LogKind::kImu:
        read_body(l);
        break;
      case LogKind::kGnss:
        read_receiver(l);
        break;
      case LogKind::kAttitude:
        read_reference(l);
    }
  } catch (const DataError& e) {
    found.push_back({LogFault::kUnreadable, file, e.what(), "piste cannot use this file as it is"});
    l.guess.reset();
    return;
  }
  for (const ClockStep& step : l.log.clock_steps) found.push_back(step_of_clock(step, file));
  if (l.gnss.not_used > 0 && l.guess->kind == LogKind::kGnss) {
    found.push_back({LogFault::kNoFix, file,
                     fmt::format("{} fixes beside {} are dead-reckoned: the receiver carried its last fix on",
                                 l.gnss.not_used, l.gnss.fixes.size()),
                     "they are no measurements and left out, as in an outage; `use_quality` says what is used"});
  }
  if (l.velocities_refuted) {
    found.push_back(
        {LogFault::kVelocityContradicts, file,
         fmt::format("its velocities are not the derivative of its positions: {:.2g} m/s are between them, at "
                     "a speed of {:.2g} m/s",
                     l.gnss_health->velocity->residual, l.gnss_health->speed),
         "`use: position`, as the configuration does; are speed, course and their units what they are read as?"});
  }
  if (l.gnss.unchecked > 0) {
    found.push_back({LogFault::kNotUsed, file,
                     fmt::format("{} sentences without a right checksum: not one has one", l.gnss.unchecked),
                     "they are read all the same; a garbled one is not noticed: let the logger write checksums"});
  }
  if (l.gnss.above_sea > 0) {
    found.push_back({LogFault::kNotUsed, file,
                     "no sentence has the height of the geoid: heights above the sea are taken as above the ellipsoid",
                     "add the geoid's height where that matters, up to 100 m"});
  }
  if (l.imu_health) append(found, suspicions(*l.imu_health, l.faults, file));
  if (l.gnss_health) append(found, suspicions(*l.gnss_health, l.faults, file));
  if (l.attitude_sampling)
    append(found, suspicions(*l.attitude_sampling, l.faults, file, kFastestAttitude, kSlowestAttitude));
  if (!l.imu_health && !l.gnss_health && !l.attitude_sampling)
    append(found, suspicions(Sampling{}, l.faults, file, kFastestGnss, kSlowestGnss));
}

}  // namespace piste
