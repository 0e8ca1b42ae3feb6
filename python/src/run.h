#pragma once
/// A replay with its configuration and verdict, as Python holds it.

#include "piste/consistency/verdict.h"
#include "piste/files/summary.h"
#include "piste/replay/replay.h"

namespace piste::python {

struct Run {
  ReplayConfig config;
  Replay replay;
  Verdict verdict;
  RunTimes times;
};

}  // namespace piste::python
