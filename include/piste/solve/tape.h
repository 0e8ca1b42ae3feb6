#pragma once
/// The state of a filter at one instant, and the record of all that it did.

#include <cstddef>
#include <variant>
#include <vector>

#include "piste/model/dynamics.h"
#include "piste/solve/update.h"

namespace piste {

/// Time, estimate and covariance.
struct FilterState {
  double time = 0;
  Estimate x;
  Covariance P;
  /// The error of `x` as the measurements so far have it: the best estimate is x ⊞ mean. Zero in a filter that corrects
  /// `x` itself; in one that is linearised about a reference, `x` is the reference.
  ErrorVector mean = {};
};

/// All that a filter did, in order. A smoother goes through it backwards.
struct Tape {
  struct Propagation {
    Transition transition;
  };
  struct Correction {
    Update update;
    ResetJacobian reset;
  };
  /// What noise told the scales, taken back (solve/noise_score.h): the estimate moved by −P times the score.
  struct TakenBack {
    Eigen::Matrix<double, 6, 1> score;
  };
  /// The end of an IMU epoch, for which the smoother gives its estimate: an index into `epochs`.
  struct EpochEnd {
    std::size_t index;
  };
  using Epoch = FilterState;
  std::vector<std::variant<Propagation, Correction, TakenBack, EpochEnd>> events;
  std::vector<Epoch> epochs;  ///< beside the events, as each is as large as several of these

  void end_epoch(const Epoch& epoch) {
    events.emplace_back(EpochEnd{epochs.size()});
    epochs.push_back(epoch);
  }
  void clear() {
    events.clear();
    epochs.clear();
  }
};

}  // namespace piste
