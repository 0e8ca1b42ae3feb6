#pragma once
/// What decides how gaps, spikes, rest, the start and distrust are treated: every threshold, window and factor, with
/// the reason for its value. SI and radians. The values that a user may need are keys of the configuration
/// (docs/keys.md); the others are here to be read, and for tests.

#include <cstddef>

#include "piste/core/log.h"
#include "piste/math/units.h"

namespace piste {

/// Where rows of a log are missing, and what takes their place.
struct GapOptions {
  // Where a row is missing, in periods of the rows: halfway between one row and two.
  double long_interval = 1.5;  ///< a gap's interval is longer
  double behind = 0.5;         ///< and the clock is still that late with its neighbours
  std::size_t neighbours = 8;  ///< intervals on either side: a packet of nine rows has one stamp
  // The period is found from means over blocks.
  std::size_t block = 16;           ///< intervals: rounding to a millisecond is a sixteenth of one there
  std::size_t fewest_blocks = 5;    ///< with fewer, a gap may be in most of them: single intervals say more
  double blocks_without_gap = 0.1;  ///< part of the blocks that surely hold no gap, however broken the log

  double longest = 300;  ///< s that are bridged: beyond, a start of its own is better than what coasting leaves

  // The line that fills a gap.
  double edge = 0.2;  ///< s on either side that it is drawn from: less follows vibration, more misses motion
  double reach = 10, reach_in_lengths = 5;  ///< s, and lengths of the gap: the motion near by that its noise is from
  std::size_t fewest_lengths = 4;  ///< lengths of the gap measured there: with fewer, the rms is a matter of chance
  double caution = 2;              ///< times that rms: the motion in the gap may be livelier than that around it
  GapNoise unknown{1, 3};          ///< with too little measured: whatever a skier does (rad/s/sqrt(Hz), m/s²/sqrt(Hz))
};

/// What a body at most does in one sample: a rate of change, and what is not worth mending however fast the log is.
struct Abruptness {
  double per_second, least;
};

/// What makes a sample a spike (condition/spikes.h). All conditions must hold.
struct SpikeOptions {
  bool mend = true;            ///< false: samples stay as they are, and no spike is looked for
  Abruptness gyro{250, 1};     ///< rad/s², rad/s: a skier's landing turns the body with some 100 rad/s²
  Abruptness accel{5000, 20};  ///< m/s³, m/s²: the force of a landing grows within 20 ms or more to some 10 g
  double around = 2;       ///< s on either side to compare with: an impact rings that long, and steps return within it
  std::size_t fewest = 8;  ///< rows on either side without a gap: with fewer, the motion around is not known
  double sigmas = 20;      ///< least departure, in robust sigmas of lines around: white noise has one in 1e15 beyond 8
  double furthest = 6;  ///< in parts of the furthest one around: a knock has neighbours of a tenth to half of its peak
  std::size_t most_others = 2;  ///< as large ones around: what comes back again and again is motion
};

/// When the body is at rest (condition/rest_detection.h), and the zero-velocity and zero-rate updates at rest.
struct RestOptions {
  bool detect = true;

  // Updates.
  double sigma_velocity = 0.01;   ///< of the velocity of a standing body: a person sways
  double sigma_rate = 0.0034907;  ///< of its angular rate, 0.2 deg/s: sway and slow turning
  double correlation_time = 8;    ///< of that rate [s]: zero-rate updates within it count together as one
  double interval = 0.5;          ///< between the updates [s]
  int patience = 3;  ///< refused in a row after which a rest is withdrawn: chance refuses one in a thousand

  // Detection: what GNSS shows in a window.
  double cell = 0.25;      ///< s by which windows move: a rest begins and ends as exactly as that
  std::size_t window = 4;  ///< cells: one second, which holds a fix of most receivers
  double sway = 0.06;      ///< m/s: largest mean speed of a standing body, beyond the noise of GNSS
  double moving = 0.5;     ///< m/s beyond which a body certainly moves: half the pace of a slow walker
  double resolved = 0.15;  ///< m/s: a receiver whose noise is larger cannot tell rest from a slow motion
  double rest_sigmas = 2, moving_sigmas = 3;  ///< of that noise, beyond `sway` and `moving`: chance is no motion
  double farthest =
      16;  ///< s before and after a window in which positions may resolve its speed: later ones tell of another motion

  // What the IMU shows, by the rests and motions that GNSS shows in the log.
  double as_quiet = 3;          ///< medians at rest, where GNSS shows rest as well: the wind and a heavy breath
  double alone_quantile = 0.9;  ///< of rest, and its factor, where there is no GNSS: nothing else confirms the rest
  double alone_factor = 1.5;
  double moving_quantile = 0.01;  ///< of motion: quieter than nearly all of it, or rest is not separable
  double gyro_quiet = 0.03;       ///< rad/s, and
  double force_quiet = 0.15;      ///< m/s²: rms of a person who stands, for logs whose GNSS shows no rest
  double turning = 0.02;          ///< rad/s: mean rate of a reference IMU beyond which it is not sway

  // Claimed rests.
  double shortest = 1;         ///< s: no shorter than the window that found it
  double drawn_in = 0.25;      ///< s at both ends, one cell: the body may stop and depart within it
  double sway_distance = 0.3;  ///< m that a standing body moves, beyond three sigmas of the fixes: more is a departure
  double turn = 5 * kDegree;   ///< that it turns about its own mean rate: more is a slow turn
  double halved = 4;           ///< s: a part of a refuted rest is no shorter, as a slow motion would not show in it
};

/// How a run begins: the heading, where nobody told it, and the sigmas of the start.
struct StartOptions {
  // The bank of headings (solve/heading_bank.h).
  int hypotheses = 12;           ///< 30 deg apart: the truth is within 15 deg of one, where the filter is still linear
  double least_weight = 1e-6;    ///< beside the best, at which one is dropped: five sigmas, so that no chance drops it
  double most_gates = 4;         ///< times its gate that one innovation counts: an outlier must not decide
  double sure = 10 * kDegree;    ///< 1-sigma of the best from which a single filter can go on
  double agree = 0.5;            ///< of that sigma, and
  double agree_apart = kDegree;  ///< beside it: hypotheses that are no further apart tell the same
  double outvoted = 1e-3;        ///< weight of one that need not agree any more
  double listened = 30;  ///< s of the rest before the departure that it filters: the biases settle, and no more is told
  double rest_step = 0.1;  ///< s of a rest that look for the heading as one sample: a standing body sways slower
  double departed = 2, departed_sigmas = 6;  ///< m and sigmas from the first fix: the body has left, whatever the noise
  double look_back = 40;  ///< s of motion beyond, from whose end a smoother looks back: attitude and biases are sure
  double least_sigma = kDegree;  ///< of the smoothed attitude: its model is not perfect

  // Rest at the start.
  double rest_begins = 0.5, rest_lasts = 1;  ///< s: a rest at the start begins so soon, and lasts so long
  double longest_rest = 10;                  ///< s of it that level the body: noise is averaged out, and sway stays
  double bias_rest = 2;  ///< s before which a rest began that tells the bias: sway is averaged over them

  // Position and velocity.
  double reach = 3;         ///< s of fixes that tell the first motion: more would tell of a later one
  int fewest = 3;           ///< fixes, even if they are further away: position, velocity and acceleration
  double any_speed = 300;   ///< m/s: 1-sigma of a velocity of which nothing is known
  double acceleration = 3;  ///< m/s²: 1-sigma, of a vehicle or a skier
  double fastest = 100;     ///< m/s between two fixes of a body that moves: faster, one of them is an outlier
  double swaying = 1;       ///< m/s, of a body at rest
  double least_position = 1, least_velocity = 0.5;  ///< m, m/s: least 1-sigma: the sigmas of fixes may claim too much

  // Attitude.
  double force_time = 1;            ///< s over which the first specific force is averaged: vibration is averaged out
  double tilt_sigma = 2 * kDegree;  ///< of roll and pitch: loose, as the filter uses the same samples again
  double unlevelled = 5;            ///< times that where no rest levels the body
  double most_tilt = 30 * kDegree;  ///< 1-sigma of the tilt of a body that moves: beyond, the filter is not linear
  double reference_sigma = 5 * kDegree;  ///< of a heading from the reference: loose, as the filter uses it again
  double loose = 5;  ///< times the sigmas of the fixes: the filter uses these again, and they count twice by a 25th
};

/// Whether a fix is used, and whether the receiver or the filter is wrong where they disagree (solve/trust.h).
struct TrustOptions {
  double gate = 0.999;    ///< probability with which a good fix passes the gate
  int readmit_after = 5;  ///< rejections in a row after which the filter takes itself to be wrong
  double distrust = 40;   ///< longest time for which a receiver that jumped is not used [s]

  double recent = 2;             ///< s between fixes over which a jump can be seen: a filter alone is good for so long
  double slight = 1;             ///< m or m/s: a smaller jump is not worth an outage
  double slight_patience = 3;    ///< s in which a slight jump may grow
  double missed_velocity = 0.5;  ///< m/s and
  double missed_force = 1;       ///< m/s²: how fast an error may grow that the covariance does not know
  double shortest_lapse = 0.5;   ///< s: such an error has grown for at least that long
  double suspicion = 10;  ///< s after a gap or a readmission in which the filter is taken to be wrong, and no receiver
  double largest_tilt = 0.2;  ///< rad: the most that a readmission adds; beyond, the filter is not linear
};

/// All of them. Conditioning reads gaps, spikes and the detection of rest; the filter reads the updates at rest, start
/// and trust.
struct BehaviourOptions {
  GapOptions gaps;
  SpikeOptions spikes;
  RestOptions rest;
  StartOptions start;
  TrustOptions trust;

  /// Throws ConfigError on values with which no run can be made.
  void validate() const;
};

}  // namespace piste
