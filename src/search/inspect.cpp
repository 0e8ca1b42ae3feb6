#include "piste/search/inspect.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <thread>
#include <utility>

#include "core/time_search.h"
#include "inspect/column_repair.h"
#include "math/time.h"
#include "piste/core/error.h"
#include "piste/math/statistics.h"
#include "search/calibration.h"
#include "search/contradiction.h"
#include "search/examine.h"
#include "search/joined.h"
#include "search/settling.h"

namespace piste {
namespace {

// The IMU in GPS time, if a receiver's log states its clock.
ImuRecording on_known_clock(const Inspection& inspection, std::size_t imu) {
  ImuRecording recording = inspection.logs[imu].imu;
  if (const ReceiverClock* clock = inspection.imu_clock(); clock != nullptr && imu == inspection.first(LogKind::kImu)) {
    for (double& t : recording.time) t = clock->gps_time(t);
  }
  return recording;
}

// Shifts fixes to the week of the IMU, as replay does, if both then have time in common. Returns whether the fixes were
// in another week.
template <class Fix>
bool bring_to_week(std::vector<Fix>& fixes, const Interval& imu) {
  if (fixes.empty()) return false;
  const double shift = week_shift(fixes.front().time, imu.start);
  if (shift == 0 || !(overlap(imu, {fixes.front().time + shift, fixes.back().time + shift}) > 0)) return false;
  for (Fix& fix : fixes) fix.time += shift;
  return true;
}

// Shifts the logs to one week: the week of the first IMU.
void bring_to_one_week(Inspection& inspection) {
  const auto imu = inspection.first(LogKind::kImu);
  if (!imu || !inspection.logs[*imu].imu_health) return;
  const std::vector<double> time = on_known_clock(inspection, *imu).time;
  const Interval span{time.front(), time.back()};
  for (InspectedLog& log : inspection.logs) {
    if (bring_to_week(log.gnss.fixes, span) && log.gnss_health) log.gnss_health = gnss_health(log.gnss);
    bring_to_week(log.attitude.fixes, span);
  }
}

// Whether the filter can run: no fault may make a log mean something else.
bool may_run(const Inspection& inspection) {
  const LogMatch* match = inspection.first_match();
  const bool clock_found = match != nullptr && match->clock;
  return std::none_of(inspection.suspicions.begin(), inspection.suspicions.end(), [&](const Suspicion& s) {
    return s.fault <= LogFault::kNoOverlap && s.fault != LogFault::kSameLog &&
           s.fault != LogFault::kTimeBack &&  // such rows were sorted
           !(s.fault == LogFault::kNoOverlap && clock_found);
  });
}

// Compares the first IMU with every attitude log.
void compare_attitudes(Inspection& inspection, std::vector<Suspicion>& found) {
  const auto imu = inspection.first(LogKind::kImu);
  if (!imu) return;
  const LogMatch* track = inspection.first_match();
  const bool known = track != nullptr && track->motion && !track->motion->mirrored;
  const Matrix3d axes = known ? track->motion->R_bs : Matrix3d(Matrix3d::Identity());
  for (std::size_t j = 0; j < inspection.logs.size(); ++j) {
    InspectedLog& log = inspection.logs[j];
    if (!log.is(LogKind::kAttitude) || !log.attitude_sampling) continue;
    AttitudeMatch m = match(inspection.logs[*imu].imu, log.attitude);
    append(found, suspicions(m, axes, inspection.logs[*imu].log.file, log.log.file));
    if (m.contradicts) {
      log.left_out = m.why_not;
      found.push_back({LogFault::kNotUsed, log.log.file, m.why_not, "it is left aside"});
    }
    inspection.attitudes.push_back({*imu, j, std::move(m)});
  }
}

// Estimates the delay of velocities that are late against the positions, or whose delay coarse positions do not
// determine.
void estimate_late_velocities(const InspectedLog& receiver, FilterOptions& options) {
  constexpr double kTold = 0.02, kSigmas = 5, kLatest = 0.3;  // s, sigmas, s
  const auto& fit = receiver.gnss_health->velocity;
  if (!fit) return;
  const auto known = fit->known_delay();
  if (!known && fit->sigma_delay < kTold) return;
  options.gnss.front().velocity_delay = known.value_or(0);
  options.estimate.push_back(Block::kVelocityDelay);
  options.priors.velocity_delay = std::clamp(kSigmas * fit->sigma_delay, kTold, kLatest);
}

std::size_t all_cores() { return std::max(1U, std::thread::hardware_concurrency()); }

// The log, with the vehicle constraints if a car carries the IMU.
WholeLog whole_log(const Inspection& inspection, const Recording& recording, const ConditioningOptions& conditioning,
                   const FilterOptions& options) {
  WholeLog log{recording, conditioning, options, std::nullopt, inspection.imu_clock() == nullptr};
  if (inspection.vehicle.is_car()) log.vehicle.emplace();
  return log;
}

// Refines the calibration over the whole log, with the vehicle constraints if a car carries the IMU. Drops them if no
// filter runs with them, or if they contradict the fixes.
void settle(Inspection& inspection, const Recording& recording, const ConditioningOptions& conditioning,
            const FilterOptions& options, Calibration& found, const Work& work) {
  WholeLog log = whole_log(inspection, recording, conditioning, options);
  auto there = settled(log, found, work);
  const ProgressCallback of_vehicle = work.step("vehicle", cost_of_contradiction(log) / 2);
  if (log.vehicle && (!there || vehicle_contradicts(log, *there, of_vehicle))) {
    inspection.vehicle = {};
    log.vehicle.reset();
    work.expect_more(cost_of_settling(log));
    there = settled(log, found, work);
  }
  if (there) found = std::move(*there);
  const ProgressCallback of_velocities = work.step("velocities", cost_of_contradiction(log) / 2);
  found.velocities_contradict = velocities_contradict(log, found, of_velocities);
}

// Replaces the noise by an estimate from more of the motion than the first minutes, if its likelihood is higher.
void retune(const Inspection& inspection, const Recording& recording, const ConditioningOptions& conditioning,
            const FilterOptions& options, Calibration& found, const Work& work) {
  if (!found.fits()) return;
  auto again = retuned(whole_log(inspection, recording, conditioning, options), found, all_cores(), work);
  if (again) found = std::move(*again);
}

// Reports two clocks whose offset is unknown.
void look_for_clock(const Inspection& inspection, std::vector<Suspicion>& found) {
  const LogMatch* match = inspection.first_match();
  if (match == nullptr || match->clock || inspection.imu_clock() || inspection.calibration() || !may_run(inspection))
    return;
  found.push_back({LogFault::kClockUntold, inspection.logs[*inspection.first(LogKind::kImu)].log.file,
                   "the motion does not tell how far its clock and the receiver's are apart",
                   "if it is not in GPS time, give `clock: {offset: ...}`, or log a livelier start"});
}

void leave_velocities_out(FilterOptions& options) {
  options.gnss.front().use_velocity = false;
  options.gnss.front().velocity_delay.reset();
  std::erase(options.estimate, Block::kVelocityDelay);
}

// Whether the first IMU may be calibrated with a receiver.
bool may_calibrate(const Inspection& inspection, const InspectedLog& receiver) {
  return inspection.first(LogKind::kImu) && receiver.gnss_health && may_run(inspection);
}

// `later`: the cost of other receivers after this one.
std::optional<Calibration> try_calibration(Inspection& inspection, const InspectedLog& receiver,
                                           std::vector<Suspicion>& found, const Work& work, double later) {
  constexpr double kFar = 3, kSure = 0.3, kCoarse = 0.5;  // m
  const double kDecided = std::log(2) + 3;                // of ln p, between two readings
  const auto imu = inspection.first(LogKind::kImu);
  if (!may_calibrate(inspection, receiver)) return std::nullopt;
  const InspectedLog& body = inspection.logs[*imu];
  FilterOptions options;
  options.sensor = guess_sensor(*body.imu_health, "guess");
  options.estimate = imu_error_blocks(options.sensor);
  options.gnss = {{.name = std::filesystem::path(receiver.log.file).stem().string()}};
  estimate_late_velocities(receiver, options);
  ConditioningOptions conditioning;
  conditioning.imu = guess_conditioning(inspection);
  conditioning.gyro_range = options.sensor.gyro.range;
  conditioning.accel_range = options.sensor.accel.range;
  try {
    const LogMatch* match = inspection.first_match();
    // Rests show the clock whatever velocities are late by.
    const bool known = match != nullptr && match->clock && (match->clock->by_rest || !match->velocities_may_be_late);
    const Recording recording{body.imu, {receiver.gnss}, {}};
    // A receiver's latency is constant, so its own two times determine the drift.
    const ToldClock clock{known ? match->clock->sigma : std::numeric_limits<double>::infinity(),
                          inspection.imu_clock() != nullptr};
    const WholeLog whole = whole_log(inspection, recording, conditioning, options);
    const double calibrating = cost_of_calibration(recording, clock, all_cores()),
                 settling = cost_of_settling(whole) + cost_of_contradiction(whole),
                 retuning = cost_of_retuning(whole, all_cores());
    const double rest = retuning + later;  // cost after the current calibration
    const auto calibrated = [&](const FilterOptions& used, Antenna antenna, double after) {
      work.expect(calibrating + settling + after);
      auto all = calibrate(recording, conditioning, used, clock, antenna, all_cores(), work);
      work.expect(settling + after);
      if (all && all->fits()) settle(inspection, recording, conditioning, used, *all, work);
      return all;
    };
    // If the motion hardly determines the lever arm, its estimate may absorb another error. A receiver accurate to
    // centimetres is in no phone.
    const bool coarse = receiver.gnss_health->median_sigma.head<2>().maxCoeff() > kCoarse;
    const auto found_with = [&](const FilterOptions& used) {
      auto all = calibrated(used, Antenna::kNearBy, (coarse ? calibrating + settling : 0) + rest);
      if (!coarse || (all && all->fits() && all->lever_arm_sigma.maxCoeff() < kHousing)) return all;
      auto housed = calibrated(used, Antenna::kInHousing, rest);
      if (!housed || !housed->fits() || !all || !all->fits()) return housed && housed->fits() ? housed : all;
      // The sigma of the housing is narrow: it has to be the likelier of the two beyond doubt.
      const double innovations =
          static_cast<double>(receiver.gnss.fixes.size()) + static_cast<double>(receiver.gnss_health->velocities);
      return innovations * (housed->likelihood - all->likelihood) > kDecided ? housed : all;
    };
    auto found_here = found_with(options);
    if (!found_here) return std::nullopt;
    if (found_here->velocities_contradict) {
      leave_velocities_out(options);
      auto of_positions = found_with(options);
      const bool fits = of_positions && of_positions->fits();
      // If the positions become less likely without the velocities, the velocities are not at fault. Where positions
      // alone do not determine the clock, what was found with velocities stays, and the whole log fits without them.
      if (!fits || of_positions->likelihood_of_positions > found_here->likelihood_of_positions ||
          !drifts_plausibly(*found_here)) {
        if (fits) found_here = std::move(of_positions);
        found_here->velocities_contradict = true;
        found.push_back({LogFault::kVelocityContradicts, receiver.log.file,
                         "its velocities put the antenna, the clock or the track elsewhere than its positions do",
                         "`use: position`, as the configuration does, unless you know better"});
      } else {
        found_here->velocities_contradict = false;
      }
    }
    work.expect(rest);
    retune(inspection, recording, conditioning, options, *found_here, work);
    const Calibration& calibration = *found_here;
    const Vector3d& arm = calibration.lever_arm;
    if (calibration.fits() && arm.norm() > kFar && calibration.lever_arm_sigma.norm() < kSure * arm.norm()) {
      found.push_back({LogFault::kLeverArm, receiver.log.file,
                       fmt::format("the antenna seems to be {:.1f} m from the IMU", arm.norm()),
                       "is that so? If not, the clocks or the axes do not fit"});
    }
    return found_here;
  } catch (const Error&) {
    return std::nullopt;  // no start: the logs are too short, or nothing moves
  }
}

// Cost of examining, in filtered rows of an IMU. kBytes of text are read and examined in the time of one row; two logs
// are compared in the time of kComparing rows.
constexpr double kBytes = 400, kComparing = 2e4;

double cost_of_reading(const InspectedLog& log) {
  if (log.log.content) return static_cast<double>(log.log.content->size()) / kBytes;
  double bytes = 0;
  for (const std::string& file : {log.log.file, log.log.accel_file, log.log.gravity_file}) {
    std::error_code unreachable;
    const auto size = file.empty() ? 0 : std::filesystem::file_size(file, unreachable);
    if (!unreachable) bytes += static_cast<double>(size);
  }
  return bytes / kBytes;
}

double cost_of_examining(const std::vector<InspectedLog>& logs) {
  double cost = kComparing;
  for (const InspectedLog& log : logs) cost += cost_of_reading(log);
  return cost;
}

// Expected cost of calibrations after the logs are read, by the sizes of the files: rows of an IMU have some hundred
// bytes.
double guessed_cost_of_calibrating(const std::vector<InspectedLog>& logs) {
  constexpr double kRowBytes = 80, kRuns = 200;
  double rows = 0;
  bool receiver = false;
  for (const InspectedLog& log : logs) {
    if (log.is(LogKind::kImu) && rows == 0) rows = cost_of_reading(log) * kBytes / kRowBytes;
    receiver = receiver || log.is(LogKind::kGnss);
  }
  return receiver ? kRuns * rows / static_cast<double>(all_cores()) : 0;
}

// Rows a second apart are a slow log where seconds are certain: of a calendar, or as the turns of the track have it.
void judge_time_unit(Inspection& inspection) {
  const auto imu = inspection.first(LogKind::kImu);
  if (!imu || !inspection.logs[*imu].imu_health) return;
  const InspectedLog& body = inspection.logs[*imu];
  const LogMatch* match = inspection.first_match();
  const bool calendar = body.log.columns && body.log.columns->time.unit == "calendar";
  if (!calendar && (match == nullptr || !match->clock)) return;
  for (Suspicion& s : inspection.suspicions) {
    if (s.fault != LogFault::kTimeUnit || s.file != body.log.file) continue;
    if (const auto low = low_rate(body.imu_health->sampling, body.log.file)) s = *low;
  }
}

// Examines each log, and compares them.
void examine_all(Inspection& inspection, const Work& work) {
  std::vector<Suspicion>& found = inspection.suspicions;
  std::vector<InspectedLog>& logs = inspection.logs;
  for (InspectedLog& log : logs) {
    work.step("reading", cost_of_reading(log));
    examine(log, found);
  }
  bring_to_one_week(inspection);
  take_out_leaps(inspection);
  work.step("comparing motions", kComparing);
  const auto imu = inspection.first(LogKind::kImu), gnss = inspection.first(LogKind::kGnss);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    for (std::size_t j = 0; j < logs.size(); ++j) {
      if (logs[i].imu_health && logs[j].gnss_health && (i == imu || j == gnss)) {
        const bool clock_known = inspection.imu_clock() != nullptr && i == imu;
        LogMatch m = match(on_known_clock(inspection, i), logs[j].gnss, *logs[j].gnss_health,
                           clock_known ? std::vector<Interval>{} : logs[i].imu_health->rest);
        m.clock_told = clock_known;
        if (m.motion && logs[i].guess) m.motion->sign_told = !logs[i].guess->guessed_sign;
        append(found, suspicions(m, logs[i].log.file, logs[j].log.file));
        inspection.matches.push_back({i, j, std::move(m)});
      }
      if (j <= i) continue;
      if (logs[i].imu_health && logs[j].imu_health)
        append(found, suspicions(match(logs[i].imu, logs[j].imu), logs[i].log.file, logs[j].log.file));
      if (logs[i].gnss_health && logs[j].gnss_health && logs[i].left_out.empty()) {
        const PairMatch m = match(logs[i].gnss, logs[j].gnss);
        append(found, suspicions(m, logs[i].log.file, logs[j].log.file));
        if (logs[j].left_out.empty()) logs[j].left_out = m.why_left_out(logs[i].log.file);
      }
    }
  }
  judge_time_unit(inspection);
  judge_rests(inspection);
  if (const LogMatch* m = inspection.first_match()) {
    inspection.vehicle =
        guess_vehicle(on_known_clock(inspection, *imu), logs[*gnss].gnss, *logs[*gnss].gnss_health, *m);
  }
  compare_attitudes(inspection, found);
}

bool is_of_rates(LogFault fault) { return fault == LogFault::kGyroDegrees || fault == LogFault::kGyroRadians; }
bool is_of_forces(LogFault fault) { return fault == LogFault::kAccelG || fault == LogFault::kAccelMetres; }
bool same_unit(LogFault a, LogFault b) {
  return a == b || (is_of_rates(a) && is_of_rates(b)) || (is_of_forces(a) && is_of_forces(b));
}

// Whether a wrong unit is one that a label names: of a guess there is a doubt already.
bool is_of_label(const InspectedLog& log, LogFault fault) {
  const std::string_view of = is_of_rates(fault) ? "gyro:" : is_of_forces(fault) ? "accel:" : "";
  return of.empty() || !log.guess ||
         std::ranges::none_of(log.guess->doubts, [&](const std::string& doubt) { return doubt.starts_with(of); });
}

// Corrects the units and axes of logs with guessed columns if the motion refutes the guess. Returns whether there were
// any. `refuted`: suspicions that the correction removes.
bool mend_columns(const Inspection& inspection, std::vector<InspectedLog>& logs, std::vector<Suspicion>& refuted) {
  bool any = false;
  const auto mend = [&](std::size_t log, const auto& by) {
    LogFile& file = logs[log].log;
    const auto columns = file.columns ? repaired(*file.columns, by) : std::nullopt;
    if (!columns) return;
    any = true;
    file.columns = columns;
    for (const Suspicion& s : inspection.suspicions) {
      if (s.file != file.file || !is_mended_by_columns(s.fault) || !is_of_label(inspection.logs[log], s.fault))
        continue;
      const auto said = [&](const Suspicion& before) {
        return before.file == s.file && same_unit(before.fault, s.fault);
      };
      if (std::ranges::any_of(refuted, said)) continue;  // of the labels, and not of a reading on the way
      refuted.push_back({s.fault, s.file, s.what, "`columns` in the configuration reads it so; check it"});
    }
  };
  for (const InspectedMatch& m : inspection.matches) {
    if (m.imu == inspection.first(LogKind::kImu) && m.gnss == inspection.first(LogKind::kGnss)) {
      mend(m.imu, m.match);
      if (m.match.interchanged) mend(m.gnss, VelocityFit{.interchanged = true});
    }
  }
  for (std::size_t i = 0; i < logs.size(); ++i) {
    const auto& health = inspection.logs[i].gnss_health;
    if (health && health->velocity) mend(i, *health->velocity);
  }
  return any;
}

// Ignores files that are no log, to which the first suspicions belong, if the logs of an IMU and of a receiver are
// present: users give whole folders.
void set_aside_unknown(Inspection& inspection, std::size_t count) {
  if (!inspection.first(LogKind::kImu) || !inspection.first(LogKind::kGnss)) return;
  for (std::size_t i = 0; i < count; ++i) {
    Suspicion& s = inspection.suspicions[i];
    if (s.fault != LogFault::kUnreadable) continue;
    s.fault = LogFault::kNotUsed;
    s.remedy = "it is left aside, as the others have an IMU and a receiver";
  }
}

}  // namespace

Inspection inspect(const std::vector<std::string>& files, const StageProgress& progress) {
  return inspect(sources_of(files), progress);
}

Inspection inspect(const std::vector<LogSource>& sources, const StageProgress& progress) {
  constexpr int kMostReadings = 3;  // units first, as axes show only with right units
  const Work work(progress);
  std::vector<Suspicion> unknown, refuted;
  std::vector<InspectedLog> recognised = recognise(sources, unknown);
  const double guessed = guessed_cost_of_calibrating(recognised);
  Inspection inspection;
  for (int reading = 0; reading < kMostReadings; ++reading) {
    inspection = {.logs = recognised, .matches = {}, .attitudes = {}, .suspicions = unknown};
    work.expect(cost_of_examining(recognised) + guessed);
    examine_all(inspection, work);
    if (reading + 1 == kMostReadings || !mend_columns(inspection, recognised, refuted)) break;
  }
  std::vector<Suspicion>& found = inspection.suspicions;
  set_aside_unknown(inspection, unknown.size());
  rank(found);
  std::vector<Suspicion> implausible;
  const auto receivers = static_cast<double>(
      std::ranges::count_if(inspection.logs, [&](const auto& log) { return may_calibrate(inspection, log); }));
  double others = receivers - 1;
  for (InspectedLog& log : inspection.logs) {
    if (!may_calibrate(inspection, log)) continue;
    log.calibration = try_calibration(inspection, log, implausible, work, std::max(0.0, others--) * guessed);
  }
  append(found, std::move(implausible));
  look_for_clock(inspection, found);
  append(found, std::move(refuted));
  advise_as_written(inspection);
  rank(found);
  // The second time of another receiver's log does not concern the IMU.
  const ReceiverClock* const clock = inspection.imu_clock();
  for (InspectedLog& log : inspection.logs) {
    if (log.clock && &*log.clock != clock) log.clock.reset();
  }
  work.finish();
  return inspection;
}

}  // namespace piste
