#include "piste/experiment/inspect.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <utility>

#include "experiment/calibration.h"
#include "io/text_reader.h"
#include "piste/core/error.h"
#include "piste/math/units.h"

namespace piste {
namespace {

template <class List>
void append(List& to, List&& more) {
  to.insert(to.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
}

const Vector3d& sigma_of(const GeodeticFix& fix) { return fix.sigma_position; }
const Vector3d& sigma_of(const EulerFix& fix) { return fix.sigma; }

// Whether a log has no sigmas. Some formats have none, and their readers give infinite ones if none is stated.
template <class Recorded>
bool says_no_sigma(const Recorded& recorded) {
  return !recorded.fixes.empty() && std::none_of(recorded.fixes.begin(), recorded.fixes.end(),
                                                 [](const auto& fix) { return sigma_of(fix).allFinite(); });
}

// Reads such a log again with a sigma that its user might state.
template <class Recorded>
void read_again(InspectedLog& l, const Vector3d& sigma, Recorded& recorded,
                Recorded (*read)(const LogFile&, RowFaults*)) {
  l.log.sigma = sigma;
  l.faults = {};
  recorded = read(l.log, &l.faults);
}

// Guesses what a log is, reads it, and examines it by itself.
InspectedLog look_at(const std::string& file, std::vector<Suspicion>& found) {
  constexpr double kFastestGnss = 100, kSlowestGnss = 0.02, kFastestAttitude = 2000, kSlowestAttitude = 0.02;  // Hz
  const Vector3d kUsualSigma(3, 3, 6),
      kUsualAngle = Vector3d(1, 1, 2) / kDegreesPerRadian;  // m; of roll, pitch, heading
  InspectedLog l;
  l.log.file = file;
  try {
    const MappedFile mapped(file);
    l.log.content = mapped.text();
    l.guess = guess_log(file, mapped.text());
    l.log.format = l.guess->format;
    switch (l.guess->kind) {
      case LogKind::kImu:
        l.imu = read_imu(l.log, &l.faults);
        if (l.imu.time.size() >= 3) l.imu_health = imu_health(l.imu);
        break;
      case LogKind::kGnss:
        l.gnss = read_gnss(l.log, &l.faults);
        if (says_no_sigma(l.gnss)) read_again(l, kUsualSigma, l.gnss, read_gnss);
        if (l.gnss.fixes.size() >= 3) l.gnss_health = gnss_health(l.gnss);
        break;
      case LogKind::kAttitude: {
        l.attitude = read_attitude(l.log, &l.faults);
        if (says_no_sigma(l.attitude)) read_again(l, kUsualAngle, l.attitude, read_attitude);
        std::vector<double> time;
        time.reserve(l.attitude.fixes.size());
        for (const EulerFix& fix : l.attitude.fixes) time.push_back(fix.time);
        if (time.size() >= 3) l.attitude_sampling = sampling(time);
      }
    }
    l.log.content.reset();
  } catch (const DataError& e) {
    l.log.content.reset();
    found.push_back({LogFault::kUnreadable, file, e.what(), "piste cannot use this file as it is"});
    return l;
  }
  if (l.imu_health) append(found, suspicions(*l.imu_health, l.faults, file));
  if (l.gnss_health) append(found, suspicions(*l.gnss_health, l.faults, file));
  if (l.attitude_sampling)
    append(found, suspicions(*l.attitude_sampling, l.faults, file, kFastestAttitude, kSlowestAttitude));
  if (!l.imu_health && !l.gnss_health && !l.attitude_sampling)
    append(found, suspicions(Sampling{}, l.faults, file, kFastestGnss, kSlowestGnss));
  return l;
}

// Whether the filter can run: no fault may make a log mean something else.
bool may_run(const Inspection& inspection) {
  return std::none_of(inspection.suspicions.begin(), inspection.suspicions.end(), [](const Suspicion& s) {
    return s.fault <= LogFault::kNoOverlap && s.fault != LogFault::kSameLog;
  });
}

// Compares the first IMU with every attitude log.
void compare_attitudes(Inspection& inspection, std::vector<Suspicion>& found) {
  const auto imu = inspection.first(LogKind::kImu);
  if (!imu) return;
  const LogMatch* track = inspection.first_match();
  const bool told = track != nullptr && track->motion && !track->motion->mirrored;
  const Matrix3d axes = told ? track->motion->R_bs : Matrix3d(Matrix3d::Identity());
  for (std::size_t j = 0; j < inspection.logs.size(); ++j) {
    const InspectedLog& log = inspection.logs[j];
    if (!log.is(LogKind::kAttitude) || !log.attitude_sampling) continue;
    AttitudeMatch m = match(inspection.logs[*imu].imu, log.attitude);
    append(found, suspicions(m, axes, inspection.logs[*imu].log.file, log.log.file));
    inspection.attitudes.push_back({*imu, j, std::move(m)});
  }
}

std::optional<Calibration> try_calibration(const Inspection& inspection, const InspectedLog& receiver,
                                           std::vector<Suspicion>& found) {
  constexpr double kFar = 3, kSure = 0.3;  // m
  constexpr double kSureClock = 0.02;      // s
  const auto imu = inspection.first(LogKind::kImu);
  if (!imu || !receiver.gnss_health || !may_run(inspection)) return std::nullopt;
  const InspectedLog& body = inspection.logs[*imu];
  FilterOptions options;
  options.sensor = guess_sensor(*body.imu_health, "guess");
  options.estimate = imu_error_blocks(options.sensor);
  options.gnss = {{.name = std::filesystem::path(receiver.log.file).stem().string(), .drift = {}}};
  ConditioningOptions conditioning;
  conditioning.imu = guess_conditioning(inspection);
  conditioning.gyro_range = options.sensor.gyro.range;
  conditioning.accel_range = options.sensor.accel.range;
  try {
    const LogMatch* match = inspection.first_match();
    const bool search_clock = match == nullptr || !match->clock || match->clock->sigma > kSureClock;
    const auto found_here = calibrate({body.imu, {receiver.gnss}, {}}, conditioning, options, search_clock);
    if (!found_here) return std::nullopt;
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

}  // namespace

Inspection inspect(const std::vector<std::string>& files, const ProgressCallback& progress) {
  Inspection inspection;
  std::vector<Suspicion>& found = inspection.suspicions;
  std::vector<InspectedLog>& logs = inspection.logs;
  constexpr double kRead = 0.3, kMatched = 0.5;  // parts of the work
  const auto show = [&](double part) {
    if (progress) progress(part);
  };
  for (std::size_t i = 0; i < files.size(); ++i) {
    logs.push_back(look_at(files[i], found));
    show(kRead * static_cast<double>(i + 1) / static_cast<double>(files.size()));
  }
  const auto imu = inspection.first(LogKind::kImu), gnss = inspection.first(LogKind::kGnss);
  for (std::size_t i = 0; i < logs.size(); ++i) {
    for (std::size_t j = 0; j < logs.size(); ++j) {
      if (logs[i].imu_health && logs[j].gnss_health && (i == imu || j == gnss)) {
        LogMatch m = match(logs[i].imu, logs[j].gnss, *logs[j].gnss_health);
        append(found, suspicions(m, logs[i].log.file, logs[j].log.file));
        inspection.matches.push_back({i, j, std::move(m)});
      }
      if (j <= i) continue;
      if (logs[i].imu_health && logs[j].imu_health)
        append(found, suspicions(match(logs[i].imu, logs[j].imu), logs[i].log.file, logs[j].log.file));
      if (logs[i].gnss_health && logs[j].gnss_health)
        append(found, suspicions(match(logs[i].gnss, logs[j].gnss), logs[i].log.file, logs[j].log.file));
    }
  }
  compare_attitudes(inspection, found);
  rank(found);
  show(kMatched);
  std::vector<Suspicion> implausible;
  for (InspectedLog& log : logs) log.calibration = try_calibration(inspection, log, implausible);
  append(found, std::move(implausible));
  rank(found);
  return inspection;
}

}  // namespace piste
