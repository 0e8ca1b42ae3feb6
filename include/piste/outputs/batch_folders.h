#pragma once
/// Writes the files and pages of align, study and allan into an output folder. The caller commits.

#include "piste/align/aligned_pair.h"
#include "piste/files/output.h"
#include "piste/recordings/allan.h"
#include "piste/study/study_config.h"
#include "piste/study/study_findings.h"

namespace piste {

/// `alignment.json`, `aligned.csv`, `alignment.html` and `figures/*.svg`, in the folder of the pair. `findings`: the
/// errors of the IMU, which the page then has as well, and `findings.json`; null: they were not estimated.
void write_alignment(OutputFolder& output, const AlignConfig& config, const AlignedPair& pair,
                     const Findings* findings = nullptr);

/// The tables of a study, `summary.json`, `figures/*.svg` and `study.html`.
void write_study(OutputFolder& output, const StudyConfig& config, const Study& study);

/// `sensor.yaml`, `allan.csv`, `allan.json` and `allan.html`.
void write_allan(OutputFolder& output, const AllanFindings& found);

}  // namespace piste
