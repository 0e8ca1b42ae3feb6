#pragma once
/// Writes the files and the page of an evaluation into an output folder. The caller commits.

#include "piste/evaluate/evaluation.h"
#include "piste/files/output.h"

namespace piste {

/// `evaluation.csv`, `evaluation.html`, and last `evaluation.json`.
void write_evaluation(OutputFolder& output, const Evaluation& found);

}  // namespace piste
