#pragma once
/// How files show what a run estimates beyond navigation.

#include <string>
#include <utility>
#include <vector>

#include "piste/core/solution.h"

namespace piste {

/// Three axes of values and sigmas that a file shows: a block, or bias and drift together.
struct Quantity {
  std::string name;
  Block block;  ///< gives unit and axes
  bool total;   ///< with the drift of the same triad
  int size() const { return info(block).size; }
};

/// The estimated blocks beyond navigation, then the total biases.
std::vector<Quantity> quantities_of(const StateLayout& layout);

/// Value and sigma in the unit of the block; a scalar stands first. Boresight as Euler angles of R_rb.
std::pair<Vector3d, Vector3d> shown(const Quantity& q, const Estimate& x, const Sigmas& s);

}  // namespace piste
