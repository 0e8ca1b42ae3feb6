#pragma once
/// Which errors of an IMU, taken for known, lead to the best navigation?

#include <cstddef>
#include <optional>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/experiment/reference_track.h"
#include "piste/experiment/study_findings.h"
#include "piste/model/known_errors.h"

namespace piste {

/// Where GNSS is withheld: windows of `length` seconds, the first one `first` seconds after the start of the run, then
/// one every `every` seconds, as far as they end within the run.
struct OutagePlan {
  double first = 10, length = 10, every = 20;
};
std::vector<Interval> outages(const OutagePlan& plan, const Interval& run);

/// One run of one IMU, and what is true of it as far as the reference knows.
///
/// A replay begins at the start of the run with the reference's attitude, velocity and position, known to 0.1 deg,
/// 5 cm/s and 5 cm, and is filtered, not smoothed. What is fed is taken out of the IMU's samples, and then no error of
/// the IMU is estimated: navigation shows what is left of them. The same replay serves every method.
class Course {
 public:
  /// `log` in its own world, `options` with sensor and receivers; a reference attitude is not used. The replay has the
  /// part of the run that the track covers. Throws DataError where it covers none.
  Course(const Log& log, FilterOptions options, const Interval& run, const ReferenceTrack& track, BodyMounting body,
         const OutagePlan& plan = {});

  /// Number of windows in which GNSS is withheld.
  std::size_t windows() const { return outages_.size(); }

  /// Of errors that are fed; without them the replay estimates bias, drift and scale itself, from the sensor's sigmas.
  /// RMSE over the epochs of a replay with all of GNSS; drift in another one with outages.
  /// Throws DataError where the filter fails.
  NavigationScore score(Method method, const std::optional<KnownErrors>& errors) const;

 private:
  Solution replay(const std::vector<ImuSample>& imu, const FilterOptions& options, bool with_outages) const;

  Log log_;
  FilterOptions options_;
  ReferenceTrack track_;
  BodyMounting body_;
  std::vector<Interval> outages_;
};

}  // namespace piste
