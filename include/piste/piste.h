#pragma once
/// The front door of piste: the conventions, then all public headers that need only piste::piste. The headers that need
/// least squares over whole logs are in batch.h.
///
/// Data is of three kinds, and each step is a pure function from one kind to the next:
///
///     Log (measurements)  →  Solution (estimates with their sigmas)  →  findings (conclusions)
///
/// ## Frames
///
///     i  inertial                            b  body: the MEMS-IMU, forward-right-down
///     e  Earth-centred, Earth-fixed          r  reference IMU
///     w  world: north-east-down axes at the  a  GNSS antenna
///        run's origin, fixed to the Earth    n  local level: north-east-down axes at the body
///
/// ## Symbols
///
/// Inner letters cancel: p_w = R_wb p_b, and R_wr = R_wb R_br.
///
///     R_wb, q_wb      turns b components into w; Hamilton quaternion
///     p_wb, v_wb      position of b from the origin of w, and velocity of b over the ground, both in w
///     p_ba_b          lever arm from b to a, in b
///     w_ib_b, f_ib_b  angular rate and specific force of b against i, in b
///     R_rb            boresight: b components into r
///     R               alone: covariance of a measurement; P: covariance of the estimate's error
///
/// Euler angles are roll, pitch, heading of R_nb = R_z(heading) R_y(pitch) R_x(roll).
///
/// ## Mechanization
///
///     R_wb' = −[ω_ie] R_wb + R_wb [ω_ib]      v' = R_wb f + g_w(p) − 2 ω_ie × v      p' = v
///
/// with ω_ie constant in w and g_w the normal gravity (gravitation and centrifugal acceleration).
///
/// ## Errors
///
/// truth = estimate ⊞ error, and residual = measured − predicted. For (position ρ, velocity ν, attitude θ,
/// boresight β):
///
///     p_wb = p̂_wb + ρ    v_wb = Exp(θ) v̂_wb + J_l(θ) ν    R_wb = Exp(θ) R̂_wb    R_rb = Exp(β) R̂_rb
///
/// and value + error for every other block. Sigmas in files and pictures are those of the ordinary errors in n: north,
/// east, down, roll, pitch, heading, like the values. The sigmas and coloured errors of fixes are in n too.
/// World::rotation_wn is the only rotation between w and n, so a run does not depend on the origin of w.
///
/// ## IMU error model
///
///     measured = (1 + scale) · true + bias + drift + noise, per axis
///
/// `bias` is a random constant of the run, and `drift` its change in the run: none, a random walk, or a first-order
/// Gauss-Markov process. This is an error to subtract; papers that add a correction have the opposite sign.
///
/// ## Units
///
/// Inside the library all numbers are in SI and radians, and names have no unit. In files the unit is text and is
/// checked: a configuration has `0.05 deg/s/sqrt(Hz)`, the header of a file `gyro_x_deg_s`. Time is GPS seconds of
/// week.
///
/// ## Failure
///
/// Bad input throws piste::Error, which states where the fault is and how to correct it. The library does not print and
/// does not exit.

// Interrupts long computations.
#include "piste/math/interruption.h"

// The parts of a run.
#include "piste/core/error.h"
#include "piste/core/estimate.h"
#include "piste/core/log.h"
#include "piste/core/options.h"
#include "piste/core/sensor.h"
#include "piste/core/sensor_class.h"
#include "piste/core/solution.h"
#include "piste/core/version.h"

// The steps of a run: simulate or read, inspect, condition, solve, analyse, write and show; and ensembles of runs,
// compared with the truth.
#include "piste/condition/pipeline.h"
#include "piste/condition/rest_detection.h"
#include "piste/condition/signal.h"
#include "piste/configuration/replay_config.h"
#include "piste/configuration/sensor_file.h"
#include "piste/consistency/consistency.h"
#include "piste/consistency/disputes.h"
#include "piste/consistency/range_sums.h"
#include "piste/consistency/verdict.h"
#include "piste/consistency/warnings.h"
#include "piste/descents/descents.h"
#include "piste/diagnosis/diagnose.h"
#include "piste/diagnosis/run_warnings.h"
#include "piste/evaluate/evaluation.h"
#include "piste/exports/exports.h"
#include "piste/files/consistency.h"
#include "piste/files/descents.h"
#include "piste/files/evaluation.h"
#include "piste/files/replay.h"
#include "piste/files/summary.h"
#include "piste/files/tuning.h"
#include "piste/filter/filter.h"
#include "piste/filter/run.h"
#include "piste/filter/update.h"
#include "piste/io/log_io.h"
#include "piste/io/solution_io.h"
#include "piste/live/live.h"
#include "piste/outputs/descents_folder.h"
#include "piste/outputs/evaluation_folder.h"
#include "piste/outputs/folders.h"
#include "piste/outputs/replay_folder.h"
#include "piste/replay/replay.h"
#include "piste/report/consistency_page.h"
#include "piste/report/consistency_text.h"
#include "piste/report/descents_page.h"
#include "piste/report/evaluation_page.h"
#include "piste/report/html.h"
#include "piste/report/inspection_page.h"
#include "piste/report/inspection_text.h"
#include "piste/report/kml.h"
#include "piste/report/tuning_page.h"
#include "piste/search/inspect.h"
#include "piste/search/readings.h"
#include "piste/search/rounds.h"
#include "piste/search/tune.h"
#include "piste/sim/campaign.h"
#include "piste/sim/simulation.h"
#include "piste/smoother/rts.h"
#include "piste/start/attitude_noise.h"
#include "piste/start/initial_stretch.h"
#include "piste/start/start.h"
#include "piste/trajectory/trajectory.h"
#include "piste/trial/ensemble.h"
#include "piste/tune/likeliest_noise.h"
#include "piste/tune/standing_heights.h"
