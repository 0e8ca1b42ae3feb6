#pragma once
/// Thresholds, windows and factors for gaps, spikes, standstill, initialisation and fault detection. Each states the
/// reason for its value. SI and radians. The values that a user may need are keys of the configuration (docs/keys.md);
/// the others are here to be read, and for tests.

#include <cstddef>

#include "piste/core/log.h"
#include "piste/math/units.h"

namespace piste {

/// Detection of missing rows (gaps), and the interpolation that fills them.
struct GapOptions {
  // Missing rows are detected in units of the period: halfway between one row and two.
  double long_interval = 1.5;  ///< a gap is longer than this
  double behind = 0.5;         ///< and the clock stays this late over any neighbours
  std::size_t neighbours = 8;  ///< intervals on either side: a packet of nine rows has one stamp
  // The period is found from means over blocks.
  std::size_t block = 16;           ///< intervals: averaged over them, 1 ms of rounding becomes 1/16 ms
  std::size_t fewest_blocks = 5;    ///< with fewer, a gap may be in most of them: single intervals say more
  double blocks_without_gap = 0.1;  ///< share of the blocks that hold no gap even in a badly broken log

  double longest = 300;  ///< s that are bridged: after more, a new start is better than coasting

  // The straight line that fills a gap, and its noise.
  double edge = 0.2;                        ///< s averaged on either side: less follows vibration, more misses motion
  double reach = 10, reach_in_lengths = 5;  ///< s, or lengths of the gap: its noise is measured within this
  std::size_t fewest_lengths = 4;  ///< lengths of the gap measured there: with fewer, the rms is not significant
  double caution = 2;              ///< times that rms: the motion in the gap may exceed that around it
  GapNoise unknown{1, 3};          ///< with fewer: covers a skier (rad/s/sqrt(Hz), m/s²/sqrt(Hz))
};

/// The largest change of a body's motion in one sample: a rate of change, and a change too small to repair at any rate.
struct Abruptness {
  double per_second, least;
};

/// Conditions under which a sample is a spike (condition/spikes.h). All must hold.
struct SpikeOptions {
  bool mend = true;            ///< false: no spike is detected, and samples stay as measured
  Abruptness gyro{250, 1};     ///< rad/s², rad/s: a skier's landing turns the body with some 100 rad/s²
  Abruptness accel{5000, 20};  ///< m/s³, m/s²: the force of a landing grows within 20 ms or more to some 10 g
  double around = 2;       ///< s on either side to compare with: an impact rings that long, and steps return within it
  std::size_t fewest = 8;  ///< rows on either side without a gap: with fewer, the motion around is not known
  double sigmas = 20;      ///< least departure, in robust sigmas of lines around: normal noise exceeds 8 once in 1e15;
                           ///< the margin is for vibration, whose tails are longer
  double furthest = 6;     ///< times the largest one around: neighbours of a knock have 0.1 to 0.5 of its peak
  std::size_t most_others = 2;  ///< as large departures around, at most: what recurs is motion
};

/// Detection of standstill, here called rest (condition/rest_detection.h), and the zero-velocity and zero-angular-rate
/// updates (ZUPT, ZARU) in it.
struct RestOptions {
  bool detect = true;

  // ZUPT and ZARU.
  double sigma_velocity = 0.01;   ///< 1-sigma of a stationary body's velocity [m/s]: a person sways
  double sigma_rate = 0.0034907;  ///< 1-sigma of its angular rate [rad/s], 0.2 deg/s: sway and slow turning
  double correlation_time = 8;    ///< of that rate [s]: ZARUs within it together count as one
  double interval = 0.5;          ///< between the updates [s]
  int patience = 3;  ///< rejections in a row that withdraw a rest: a right update is rejected once in a thousand

  // Detection by GNSS, window by window.
  double cell = 0.25;      ///< s by which windows move: the resolution of start and end
  std::size_t window = 4;  ///< cells: one second, which holds a fix of most receivers
  double sway = 0.06;      ///< m/s: largest mean speed of a stationary body, beyond the noise of GNSS
  double moving = 0.5;     ///< m/s beyond which a body certainly moves: half the pace of a slow walker
  double resolved = 0.15;  ///< m/s: a receiver with more noise does not separate rest from slow motion
  double rest_sigmas = 2, moving_sigmas = 3;  ///< of that noise, beyond `sway` and `moving`: chance is no motion
  double farthest =
      16;  ///< s before and after a window in which positions may resolve its speed: later ones are of another motion

  // Detection by the IMU. Its bounds are learned where GNSS shows rest or motion.
  double as_quiet = 3;          ///< times the median at rest, where GNSS also shows rest: room for wind and breathing
  double alone_quantile = 0.9;  ///< of rest, times a factor, without GNSS: nothing else confirms the rest
  double alone_factor = 1.5;
  double moving_quantile = 0.01;  ///< of motion: rest must be quieter than this, or is not separable
  double gyro_quiet = 0.03;       ///< rad/s, and
  double force_quiet = 0.15;      ///< m/s²: rms of a standing person without rest by GNSS; how far its mean may move
  double turning = 0.02;          ///< rad/s: a larger mean rate of a reference IMU is no sway

  // Tests of detected rests over their whole length.
  double shortest = 1;         ///< s: no shorter than the window that found it
  double drawn_in = 0.25;      ///< s removed at both ends, one cell: the body may stop and depart within it
  double sway_distance = 0.3;  ///< m, plus three sigmas of the fixes: a body that moves further departs
  double turn = 5 * kDegree;   ///< rad about its own mean rate: more is a slow turn
  double halved = 4;           ///< s: least length of a part of a refuted rest: in less, slow motion would not show
};

/// Initialisation: the heading search, where no heading is configured, and the 1-sigmas of the initial state.
struct StartOptions {
  // Multiple-model (MMAE) heading search (start/heading_search.h).
  int hypotheses = 12;           ///< 30 deg apart: the truth is within 15 deg of one, where the filter is still linear
  double least_weight = 1e-6;    ///< relative to the best: below, a hypothesis is dropped; five sigmas
  double most_gates = 4;         ///< limits the NIS of one innovation, in gates: an outlier must not decide
  double sure = 10 * kDegree;    ///< 1-sigma of the best heading at which one filter takes over
  double agree = 0.5;            ///< of that sigma, plus
  double agree_apart = kDegree;  ///< rad: hypotheses within this of the best agree with it
  double outvoted = 1e-3;        ///< weight below which a hypothesis need not agree
  double listened = 30;          ///< s of the rest before departure that are filtered: enough for the biases to settle
  double rest_step = 0.1;        ///< s of a rest that are merged to one sample in the search: sway is slower
  double departed = 2, departed_sigmas = 6;  ///< m, and sigmas, from the first fix: the body has departed
  double look_back = 40;         ///< s of further motion, back-smoothed: by its end attitude and biases are determined
  double least_sigma = kDegree;  ///< least 1-sigma of the smoothed attitude: its model is not perfect

  // Standstill at the start.
  double rest_begins = 0.5, rest_lasts = 1;  ///< s: a rest at the start begins within, and lasts at least
  double longest_rest = 10;  ///< s of it that are used for levelling: noise is averaged out, sway is not
  double bias_rest = 2;      ///< s: a rest that determines the gyro bias lasts so long already: sway is averaged out

  // Position and velocity.
  double reach = 3;         ///< s of fixes from which the initial motion is estimated: more would include later motion
  int fewest = 3;           ///< fixes, even if further away: for position, velocity and acceleration
  double any_speed = 300;   ///< m/s: 1-sigma of an unknown velocity
  double acceleration = 3;  ///< m/s²: 1-sigma, of a vehicle or a skier
  double fastest = 100;     ///< m/s: if a moving body's fixes imply a higher speed, one is an outlier
  double swaying = 1;       ///< m/s: the same for a body at rest
  double least_position = 1, least_velocity = 0.5;  ///< m, m/s: least 1-sigma: fixes may state too small sigmas

  // Attitude.
  double force_time = 1;            ///< s over which the first specific force is averaged, against vibration
  double tilt_sigma = 2 * kDegree;  ///< 1-sigma of roll and pitch: loose, as the filter uses the same samples again
  double unlevelled = 5;            ///< times that without a rest for levelling
  double most_tilt = 30 * kDegree;  ///< 1-sigma of the tilt of a body that moves: beyond, the filter is not linear
  double reference_sigma = 5 * kDegree;  ///< of a heading from the reference: loose, as the filter uses it again
  double loose = 5;  ///< times the sigmas of the fixes: the filter uses these again, so that only 1/25 counts twice
};

/// Innovation test of each fix, and fault detection and exclusion (FDE): whether the receiver or the filter is at fault
/// where they disagree (filter/fault_detection.h).
struct FaultDetectionOptions {
  double gate = 0.999;    ///< probability that a right fix passes the gate
  int readmit_after = 5;  ///< rejections in a row after which the filter is taken to be at fault and is reset
  double distrust = 40;   ///< longest exclusion of a receiver that jumped [s]

  double recent = 2;  ///< s between fixes over which a jump can be detected: the filter coasts well for so long
  double slight = 1;  ///< m or m/s: a smaller jump excludes the receiver only for `slight_patience`
  double slight_patience = 3;    ///< s for which a slight jump excludes it, while the jump may grow
  double missed_velocity = 0.5;  ///< m/s and
  double missed_force = 1;       ///< m/s²: how fast an error outside the covariance may grow
  double shortest_lapse = 0.5;   ///< s: such an error is taken to have grown for at least this
  double suspicion = 10;  ///< s after a gap or a reset in which the filter, and no receiver, is taken to be at fault
  double largest_tilt = 0.2;  ///< rad: largest tilt that a covariance inflation adds: beyond, the filter is not linear
};

/// All of these options. Conditioning reads gaps, spikes and the detection of rest. The filter reads ZUPT, ZARU, start
/// and trust.
struct BehaviourOptions {
  GapOptions gaps;
  SpikeOptions spikes;
  RestOptions rest;
  StartOptions start;
  FaultDetectionOptions trust;

  /// Throws ConfigError on values with which no run can be made.
  void validate() const;
};

}  // namespace piste
