#pragma once
/// The estimates beyond navigation as files show them.

#include <string>
#include <utility>
#include <vector>

#include "piste/core/solution.h"

namespace piste {

/// Values and sigmas of the elements of a block, or of the sum of bias and drift.
struct Quantity {
  std::string name;
  Block block;  ///< whose unit and axes it has
  bool total;   ///< whether the drift of the same triad is added
  int size() const { return info(block).size; }
};

/// The estimated blocks beyond navigation, then the total biases.
std::vector<Quantity> quantities_of(const StateLayout& layout);

/// Value and sigma in the unit of the block. A scalar is the first component. The boresight is given as Euler angles of
/// R_rb.
std::pair<BlockValues, BlockValues> shown(const Quantity& q, const Estimate& x, const Sigmas& s);

}  // namespace piste
