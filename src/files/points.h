#pragma once
/// Files of named points of the body, and of whole covariances.

#include "piste/files/output.h"
#include "points/placed.h"

namespace piste {

/// `smoothed_NAME.csv` of each point (without a smoother `filtered_NAME.csv`), and `covariance_smoothed.csv`
/// (`covariance_filtered.csv`) if it is asked for, at the rate of the rows. @pre the run has its histories
void write_points(OutputFolder& output, const Replay& run, const ReplayConfig& config, const RowExtras& extras);

/// `events.csv`: name and time of each mark, then the columns of smoothed.csv there, of its point. Where they are asked
/// for, delays that were found (`events.json`), and marks as text of Metashape and Pix4D.
void write_events(OutputFolder& output, const Replay& run, const ReplayConfig& config, std::optional<int> week);

}  // namespace piste
