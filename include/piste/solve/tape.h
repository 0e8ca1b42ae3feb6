#pragma once
/// The state of a filter at one instant, and the record of all that it did.

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
  /// The end of an IMU epoch, for which the smoother gives its estimate.
  using Epoch = FilterState;
  std::vector<std::variant<Propagation, Correction, Epoch>> events;
};

}  // namespace piste
