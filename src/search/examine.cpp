#include "search/examine.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "core/receiver_class.h"
#include "core/recording.h"
#include "io/left_out_rows.h"
#include "piste/core/error.h"
#include "piste/io/log_io.h"
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

void read_receiver(InspectedLog& l) {
  constexpr double kUsualVelocity = 0.5;  // m/s
  if (const auto& map = l.log.columns) {
    const bool moves = map->find("velocity") != nullptr || map->find("speed") != nullptr;
    const bool stated = map->find("sigma_velocity") != nullptr || map->find("speed_accuracy") != nullptr;
    if (moves && !stated) l.log.sigma_velocity = Vector3d::Constant(kUsualVelocity);
  }
  if (l.log.format == LogFormat::kNovatel) l.log.sigma_velocity = Vector3d::Constant(kUsualVelocity);
  l.gnss = read_gnss(l.log, &l.faults);
  if (says_no_sigma(l.gnss)) read_again(l, receiver_class(l.gnss.fixes).sigma(), l.gnss, read_gnss);
  read_spread(l, l.gnss, read_gnss);
  read_repaired(l, l.gnss, read_gnss);
  l.clock = clock_of(l);
  if (l.gnss.fixes.size() < 3) return;
  l.gnss_health = gnss_health(l.gnss);
  if (l.log.format == LogFormat::kNovatel && l.gnss_health->velocities == 0) l.log.sigma_velocity.reset();
  state_velocity_sigma(l);
}

// Stamps are judged as logged; all else is examined with the stamps that replay will use.
void read_body(InspectedLog& l) {
  l.log.even_stamps = false;
  l.imu = read_imu(l.log, &l.faults);
  read_spread(l, l.imu, read_imu);
  read_repaired(l, l.imu, read_imu);
  if (l.imu.time.size() >= 3) l.imu_health = imu_health(l.imu);
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

}  // namespace

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
  if (l.imu_health) append(found, suspicions(*l.imu_health, l.faults, file));
  if (l.gnss_health) append(found, suspicions(*l.gnss_health, l.faults, file));
  if (l.attitude_sampling)
    append(found, suspicions(*l.attitude_sampling, l.faults, file, kFastestAttitude, kSlowestAttitude));
  if (!l.imu_health && !l.gnss_health && !l.attitude_sampling)
    append(found, suspicions(Sampling{}, l.faults, file, kFastestGnss, kSlowestGnss));
}

}  // namespace piste
