#pragma once
/// A replay with its configuration and verdict, as Python holds it.

#include "piste/consistency/verdict.h"
#include "piste/experiment/replay.h"
#include "piste/files/summary.h"

namespace piste::python {

struct Run {
  ReplayConfig config;
  Replay replay;
  Verdict verdict;
  RunTimes times;
};

}  // namespace piste::python
