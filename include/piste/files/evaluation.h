#pragma once
/// The files of an evaluation.

#include <string>

#include "piste/evaluate/evaluation.h"

namespace piste {

/// `evaluation.json`: `align` (kind, rotation, translation, scale), `ape` and `rpe` with the statistics of distances
/// and rotation angles, `within_sigma` (shares within 1, 2, 3 sigma of the estimate; empty without sigmas), `nees` if
/// the estimate has covariances, and what was left out. Numbers have as many digits as they need to be read back
/// exactly. `rotation` is null without attitudes in both files.
std::string evaluation_json(const Evaluation& found);

/// `evaluation.csv`: one row an epoch. Errors, estimate minus reference, along, right and up of the reference's course,
/// those of evaluation.json's `within_sigma` with the estimate's sigmas, distance and angle. Empty where unknown.
std::string evaluation_csv(const Evaluation& found);

}  // namespace piste
