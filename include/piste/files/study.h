#pragma once
/// The files of a study: tables in CSV, and `summary.json`. Equal studies give equal bytes.

#include <string>
#include <vector>

#include "piste/study/study_findings.h"

namespace piste {

/// A file of an output folder.
struct StudyFile {
  std::string name, content;
};

/// The tables. Values are corrections to add, in m/s² and °/s; a scale has the unit 1. A missing number is an empty
/// field. `p_value` tests the number alone; `significant` is 1 if the p-value is below 5 % after Holm's correction over
/// its table.
///
///     table_1, table_6, filter_bias   sensor,axis,unit,bias,std,standard_error,p_value,significant
///                                     at rest before, in the run, and of Method::kMarkovSmoothed
///     table_2       sensor,axis,unit,before,after,difference,p_value
///     table_3, 4    sensor,axis,unit,value,std,standard_error,p_value,reverse_value
///     table_5       sensor,axis,correlation
///     table_7       method,estimates,position_rmse_m,velocity_rmse_m_s,attitude_rmse_deg,outage_drift_m,remark
///     cross_axis    sensor,axis,element,value,std,standard_error,p_value
///     scale_scatter sensor,axis,runs,std_alone,std_with_cross_axis,explained
///     estimates     run,sensor,axis,unit,method,quantity,value,sigma,standard_error,systematic,half_width_95,truth
///                   each number of each run; sigma is the formal one
///     comparisons   sensor,axis,quantity,unit,method,against,runs,difference,std,standard_error,p_value,p_holm
///     coverage      method,quantity,triad,inside,all,rate,worst
///     timing        delay_ms,axis,forward,forward_standard_error,reverse,reverse_standard_error
///     phases        run,activity,phase,start_s,end_s
std::vector<StudyFile> study_csv(const Study& study);

/// `summary.json`: name, low-pass, sensors; the runs with their phases, warnings and failures, and the alignment of
/// each IMU; what is missing; the ranking with its winner, its lead and its confidence; and the coverage.
std::string study_json(const Study& study);

}  // namespace piste
