#pragma once
/// The places of the terms in the sums of class Consistency.

#include <cstddef>

#include "piste/consistency/consistency.h"

namespace piste {

inline constexpr std::size_t kPhases = kPhaseNames.size();
inline constexpr double kHeadingTime = 5;  ///< s after the departure at which the heading is evaluated

/// Columns of Consistency::source_sums_, and of heading_.
enum SourceTerm {
  kDof,
  kCount,
  kRejected,
  kNis,
  kPairs,
  kProduct,
  kPower = kProduct + 3,
  kRunsSeen = kPower + 3,  // and over these the mean NIS of each, and its square
  kRunNis,
  kRunSquare,
  kSourceTerms
};
enum HeadingTerm { kRuns, kSquare, kLargest, kLargestSigma, kLargestRatio, kHeadingTerms };

inline std::size_t index(int i) { return static_cast<std::size_t>(i); }
inline std::size_t index(Phase phase) { return static_cast<std::size_t>(phase); }

}  // namespace piste
