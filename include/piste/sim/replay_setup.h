#pragma once
/// How `montecarlo` replays the runs of a scenario. This is the section `montecarlo:` of the scenario; the section and
/// each of its keys are optional.
/// ```yaml
/// montecarlo:
///   imu: mt9a_1                   # default: the first one; a list of up to four is fused to one IMU
///   gnss: gnss_l1l2               # a word or a list; default: the first one
///   attitude: ln200_attitude      # a word or a list; default: none
///   sensor: ../sensors/x.yaml     # the filter's model of the IMUs; default: the simulator's
///   estimate: [gyro_bias]         # default: bias, drift and scale of gyro and accel, and boresight where there is an
///                                 # attitude. As in `replay`, drifts of receivers and attitudes are added, and blocks
///                                 # for which the sensor has no error are left out.
///                                 # The filter is given the true delays of receivers and attitudes. An estimated
///                                 # delay starts at a value that is drawn about the truth with its prior
///   heading: known                # known: the start is drawn about the truth; auto: it is unknown to the filter
///   headings: as_given            # of the trunk at the start: as_given | random, drawn anew each run
///   smoother: rts                 # rts | batch
///   start: {position: 0.5 m, velocity: 5 cm/s, tilt: 0.33 deg, heading: 1 deg}   # 1-sigma of a known start
///   outages: [[20 s, 10 s]]       # GNSS withheld: [start, length] since the departure, the end of the first rest
///   end: 5 s                      # since the departure: later data are not used; default: the whole run
///   every: 1 s                    # between the epochs that are evaluated
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

/// 1-sigmas of a start that is drawn about the truth: each axis of position and of velocity, roll and pitch, and the
/// heading.
struct StartSigmas {
  double position = 0.5, velocity = 0.05;
  double tilt = 0.33 / kDegreesPerRadian, heading = kDegree;
};

/// The section, read.
struct ReplaySetup {
  std::size_t imu = 0;                      ///< of Scenario::imus
  std::vector<std::size_t> further;         ///< likewise, of several IMUs that are fused: all but the first
  std::vector<std::size_t> gnss, attitude;  ///< of the lists of Scenario; gnss is empty only where it has no receiver
  ImuSensor sensor;                         ///< the filter's model of the IMU; of several, of their mean
  std::vector<ImuSensor> imus;              ///< of each of several
  std::vector<Block> estimate;              ///< blocks beyond position, velocity and attitude
  std::optional<AdaptationOptions> adapt;   ///< whether the filter estimates the noise
  enum class Heading { kKnown, kAuto } heading = Heading::kKnown;
  SmootherKind smoother = SmootherKind::kRts;  ///< kRts or kBatch
  bool random_headings = false;   ///< of the trunk at the start, drawn anew each run; else as the motion says
  StartSigmas start;              ///< of a known heading
  std::vector<Interval> outages;  ///< s since the departure
  double end = 0;                 ///< s since the departure: later data are not used
  double every = 1;               ///< s between the evaluated epochs
};

/// Sets the options in `filter` for vehicle, odometer, barometer, two antennas and magnetometer: the true values,
/// except where these state an uncertainty.
void set_aids(FilterOptions& filter, const Scenario& scenario, const ImuSetup& imu);

/// Reads the section `montecarlo:` of a scenario file, whose sensors and motion are in `scenario` already. Throws
/// ConfigError `FILE:LINE: …`.
ReplaySetup read_replay_setup(const Config& file, const Scenario& scenario);

}  // namespace piste
