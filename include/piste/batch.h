#pragma once
/// The front door of piste::batch: the functions that need least squares over whole logs. The conventions are in
/// piste.h.
///
/// Two IMUs on one plate are aligned, and one is fitted to the other. A campaign of several IMUs is studied. A run is
/// solved as a batch. The noise of an IMU is estimated from recordings at rest.

// Comparison of one IMU with a better one.
#include "piste/align/align_config.h"
#include "piste/align/aligned_pair.h"
#include "piste/condition/aligned_signals.h"
#include "piste/condition/alignment.h"
#include "piste/condition/time_sync.h"
#include "piste/files/alignment.h"
#include "piste/files/findings.h"
#include "piste/fit/imu_fit.h"
#include "piste/fit/known_errors_of.h"
#include "piste/fit/phases.h"
#include "piste/report/alignment_page.h"
#include "piste/report/alignment_text.h"
#include "piste/report/findings_text.h"

// Comparison of several IMUs over several runs.
#include "piste/files/study.h"
#include "piste/report/study_figures.h"
#include "piste/report/study_page.h"
#include "piste/report/study_text.h"
#include "piste/study/missing.h"
#include "piste/study/ranking.h"
#include "piste/study/study.h"
#include "piste/study/study_tables.h"

// A whole run as one least-squares problem.
#include "piste/batch/batch.h"

// The noise of an IMU at rest.
#include "piste/allan/allan_variance.h"
#include "piste/allan/gmwm.h"
#include "piste/allan/noise_process.h"
#include "piste/allan/sensor_noise.h"
#include "piste/files/allan.h"
#include "piste/recordings/allan.h"
#include "piste/report/allan_page.h"
#include "piste/report/allan_text.h"

// The output files of these programs.
#include "piste/outputs/batch_folders.h"
