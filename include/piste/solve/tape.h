#pragma once
/// What a filter believes at one instant, and the record of what it did.

#include <variant>
#include <vector>

#include "piste/model/dynamics.h"
#include "piste/solve/update.h"

namespace piste {

struct FilterState {
  double time = 0;
  Estimate x;
  Covariance P;
};

/// What a filter did, in order, for a smoother to run backwards.
struct Tape {
  struct Propagation {
    Transition transition;
  };
  struct Correction {
    Update update;
    ResetJacobian reset;
  };
  /// End of an IMU epoch: the smoother reports here.
  using Epoch = FilterState;
  std::vector<std::variant<Propagation, Correction, Epoch>> events;
};

}  // namespace piste
