#pragma once
// A run as a chain: nodes at the times where measurements belong, what the IMU says between them, and the measurements.

#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <memory>
#include <utility>
#include <vector>

#include "filter/reference.h"
#include "layout.h"
#include "model/preintegration.h"
#include "piste/filter/initial_state.h"
#include "piste/model/measurement_list.h"
#include "walker/fix_queue.h"

namespace piste {

/// A time at which the state is an unknown.
struct ChainNode {
  double time = 0;
  Estimate x;       ///< constants too
  Gravity gravity;  ///< near it
  Estimate side;    ///< that of the first layout: it fixes the branch of |v| during the iterations (MeasurementContext)
};

/// The errors with which an interval is summed.
struct ImuErrors {
  Vector3d rate, force, gyro_scale, accel_scale;  ///< the former two: bias and drift
};

/// A part of an IMU sample that lies between two nodes, as measured.
struct ChainStep {
  ImuStep step;
  StepNoise noise;
  BodyMotion reference;  ///< the motion of the reference
};

/// What lies between node i and node i + 1: steps [first, last) of the chain.
struct ChainInterval {
  std::size_t first = 0, last = 0;
  ImuSum sum;             ///< its motion is that with the errors of the IMU of the node before it
  ImuErrors summed;       ///< and its noise and derivatives that with these
  std::size_t count = 0;  ///< of the steps of which they are
};

/// One channel of a fix, at a node.
struct ChainFix {
  QueuedFix place;
  std::size_t node = 0;
  ImuStep step;                                  ///< within which it is, as measured
  double into_step = 0, elapsed = 0, moved = 0;  ///< as MeasurementContext has them
  Vector3d rate_variance, neighbour_rate;
  RateRegression rate_regression;
  bool still = false;
  RecentMotion recent;
};

/// Where an epoch of the filter is: at the end of a step in an interval, counted within it, or at its start.
struct ChainEpoch {
  double time = 0;
  std::size_t interval = 0;
  std::size_t steps = 0;  ///< of the interval that lie before it; 0: it is the node at its start
};

/// A fix of which the filter had a choice: its source, and the time that it states.
using FixKey = std::pair<int, double>;

/// Which measurements a batch has. Each fix that the filter compared is one; those that it used have the weight 1.
using FixWeights = std::map<FixKey, double>;

struct Chain {
  std::vector<ChainNode> nodes;
  std::vector<ChainNode> before;  ///< those of the chain that was laid before
  std::vector<ChainStep> steps;
  std::vector<ChainInterval> intervals;  ///< one fewer than nodes
  std::vector<ChainFix> fixes;
  std::vector<ChainEpoch> epochs;  ///< in the order of the filter's rows
};

/// How the processes of a node change over a time, kept while that stays the same.
class ProcessSteps {
 public:
  ProcessSteps(const FilterOptions& options, const BatchLayout& layout) : options_(options), layout_(layout) {}
  void over(double dt);
  /// No change of a block that no node has.
  const DriftStep& of(Block block) const { return steps_[static_cast<std::size_t>(block)]; }

 private:
  const FilterOptions& options_;
  const BatchLayout& layout_;
  double dt_ = 0;
  std::array<DriftStep, kBlocks.size()> steps_;
};

/// Lays the chain of a run about a trajectory, which gives the nodes their first values, the motion that scales
/// multiply, and the delays by which fixes get their places. `longest`: seconds between nodes at most. Fixes without a
/// weight are left out. `chain`: empty, or that which was laid before, with the solution in its nodes, which are nearer
/// to the new one than a trajectory that has epochs alone; where they have hardly moved, the noise of an interval and
/// its derivatives stay what they were. It is large, and its memory is used again. @pre `reference` has the epochs of
/// the filter, and begins with `start`
void lay_chain(const Log& log, const FilterOptions& options, const BatchLayout& layout, double start,
               const std::shared_ptr<const Reference>& reference, const FixWeights& weights, double longest,
               std::size_t threads, Chain& chain);

/// Nodes, intervals or fixes that one thread takes at a time.
inline constexpr std::size_t kPerTask = 256;

/// How a process of a node changes over `dt`.
DriftStep process_step(const FilterOptions& options, Block block, double dt);

}  // namespace piste
