#pragma once
/// Measures how well an IMU navigates with the errors that a method estimated.

#include <cstddef>
#include <optional>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/model/known_errors.h"
#include "piste/study/reference_track.h"
#include "piste/study/study_findings.h"

namespace piste {

/// Outages of `length` seconds. The first begins `first` seconds after the start of the run, the others follow every
/// `every` seconds. All end within the run.
struct OutagePlan {
  double first = 10, length = 10, every = 20;
};
/// The outages of a run.
std::vector<Interval> outages(const OutagePlan& plan, const Interval& run);

/// One run of one IMU, with the reference track to compare with. All methods are tested on it by the same replay.
///
/// The replay begins at the start of the run with the reference's attitude, velocity and position, with sigmas of 0.1
/// deg, 5 cm/s and 5 cm. It is filtered, not smoothed. The errors that a method estimated are subtracted from the IMU's
/// samples, and no error of the IMU is estimated. So the navigation shows the residual errors.
class Course {
 public:
  /// `log` has its own world, and `options` the sensor and the receivers. A reference attitude is not used. The replay
  /// covers the part of the run that the track covers. Throws DataError if this part is empty.
  Course(const Log& log, FilterOptions options, const Interval& run, const ReferenceTrack& track, BodyMounting body,
         const OutagePlan& plan = {});

  /// Number of outages.
  std::size_t windows() const { return outages_.size(); }

  /// The score with `errors` subtracted. Without `errors`, the replay estimates bias, drift and scale itself, from the
  /// sensor's sigmas. The RMSE are over all epochs of a replay with all GNSS; the drift comes from a second replay with
  /// outages. Throws DataError if the filter fails.
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
