#pragma once
/// How `montecarlo` replays the runs of a scenario. This is the section `montecarlo:` of the scenario; the section and
/// each of its keys are optional.
/// ```yaml
/// montecarlo:
///   imu: mt9a_1                   # default: the first one; a list of up to four is taken as one IMU
///   gnss: gnss_l1l2               # a word or a list; default: the first one
///   attitude: ln200_attitude      # a word or a list; default: none
///   sensor: ../sensors/x.yaml     # what the filter is told of the IMUs; default: what the simulator uses
///   estimate: [gyro_bias]         # default: bias, drift and scale of gyro and accel, and boresight where there is an
///                                 # attitude. As in `replay`, drifts of receivers and attitudes are added, and what
///                                 # the sensor has no error of is left out
///                                 # Of the delays of receivers and attitudes the filter is told the truth, or, of one
///                                 # that is estimated, a value that is drawn about it with the prior
///   heading: known                # known: the start is drawn about the truth; auto: the filter knows nothing of it
///   headings: as_given            # of the trunk at the start: as_given | random, drawn anew each run
///   smoother: rts                 # rts | batch
///   start: {position: 0.5 m, velocity: 5 cm/s, tilt: 0.33 deg, heading: 1 deg}   # 1-sigma of a known start
///   outages: [[20 s, 10 s]]       # GNSS withheld: [start, length] since the departure, the end of the first rest
///   end: 5 s                      # since the departure: the replay sees nothing later; default: the whole run
///   every: 1 s                    # between the epochs that are looked at
/// ```

#include <cstddef>
#include <optional>
#include <vector>

#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/core/sensor.h"
#include "piste/core/state_table.h"
#include "piste/math/units.h"

namespace piste {

class Config;
struct Scenario;
struct ImuSetup;

/// 1-sigma of a start that is drawn about the truth: of each axis of position and of velocity, of roll and pitch, and
/// of the heading.
struct StartSigmas {
  double position = 0.5, velocity = 0.05;
  double tilt = 0.33 / kDegreesPerRadian, heading = kDegree;
};

/// The section, read.
struct ReplaySetup {
  std::size_t imu = 0;                      ///< of Scenario::imus
  std::vector<std::size_t> further;         ///< likewise, of several IMUs that are taken as one: those beside the first
  std::vector<std::size_t> gnss, attitude;  ///< of the lists of Scenario; gnss is empty only where it has no receiver
  ImuSensor sensor;                         ///< what the filter is told of the IMU; of several, of their mean
  std::vector<ImuSensor> units;             ///< of each of several
  std::vector<Block> estimate;              ///< blocks beyond position, velocity and attitude
  std::optional<AdaptationOptions> adapt;   ///< whether the filter learns the noise
  enum class Heading { kKnown, kAuto } heading = Heading::kKnown;
  SmootherKind smoother = SmootherKind::kRts;  ///< kRts or kBatch
  bool random_headings = false;   ///< of the trunk at the start, drawn anew each run; else as the motion says
  StartSigmas start;              ///< of a known heading
  std::vector<Interval> outages;  ///< s since the departure
  double end = 0;                 ///< s since the departure: nothing later is seen
  double every = 1;               ///< s between the epochs that are looked at
};

/// Sets in `filter` what it is told of vehicle, odometer, barometer, two antennas and magnetometer: the truth, where
/// they do not say how uncertain it is.
void set_aids(FilterOptions& filter, const Scenario& scenario, const ImuSetup& imu);

/// Reads the section `montecarlo:` of a scenario file, whose sensors and motion are in `scenario` already. Throws
/// ConfigError `FILE:LINE: …`.
ReplaySetup read_replay_setup(const Config& file, const Scenario& scenario);

}  // namespace piste
