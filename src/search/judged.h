#pragma once
/// A replay of the configuration of an inspection, and what it says of it.

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "piste/configuration/replay_config.h"
#include "piste/core/log.h"
#include "piste/diagnosis/diagnose.h"
#include "piste/inspect/inspection.h"
#include "piste/replay/replay.h"

namespace piste {

/// Writes and reads the configuration of an inspection as it is at the moment.
using Configured = std::function<ReplayConfig(const Inspection&)>;

/// A configuration, and its logs with sums of samples (tune/thinned.h): an hour at most.
struct Ready {
  ReplayConfig config;
  ReplayOptions options;
  Log log;
};

Ready ready(ReplayConfig config);

/// The log-likelihood of innovations, by their source and the time of their fix [µs].
using Likelihoods = std::map<std::pair<std::string, long long>, double>;

Likelihoods likelihoods(const std::vector<Innovation>& innovations, const std::vector<std::string>& sources);

/// By how much `one` makes likelier what both predict.
double gain(const Likelihoods& one, const Likelihoods& other);

/// How likely a configuration makes its logs under way. Nothing where no replay runs: for want of a start, say.
std::optional<Likelihoods> weighed(const Inspection& found, const Configured& configured);

/// The verdict on a replay of a configuration, the causes of it, and how likely its innovations are.
struct Judged {
  ReplayConfig config;
  Diagnosis diagnosis;
  double likelihood = 0;
};

/// Nothing where no replay runs.
std::optional<Judged> judged(const Inspection& found, const Configured& configured);

}  // namespace piste
