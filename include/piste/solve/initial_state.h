#pragma once
/// Where a filter begins.

#include <optional>

#include "piste/model/heading.h"

namespace piste {

/// An estimate, and the covariance of its error. Of the navigation blocks alone (9 × 9, order ρ, ν, θ), where the other
/// blocks begin as the state table says; or of the whole layout.
struct Start {
  double time = 0;
  Estimate x;
  Covariance covariance = Covariance::Identity(9, 9);
  /// A heading that is known only later, such as when a body that rested begins to move; the filter takes it then.
  std::optional<HeadingFix> heading = std::nullopt;
};

/// Covariance of a start, at the layout's size: of a constant its prior, of a process its level at the start.
Covariance initial_covariance(const StateLayout& layout, const FilterOptions& options, const Start& start);

}  // namespace piste
