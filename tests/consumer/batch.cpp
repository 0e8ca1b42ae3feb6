// Links with piste::batch. Every header of its front door stands here, as those of piste/piste.h in main.cpp. Both
// front doors are open, as in a program that replays and then studies: no name may mean two things.

#include "piste/batch.h"

#include <filesystem>
#include <iterator>
#include <limits>

#include "address.h"
#include "piste/piste.h"

namespace {

using consumer::address;
using consumer::Exported;

const Exported kExported[] = {
    {"piste/condition/aligned_signals.h", address(piste::low_passed)},
    {"piste/condition/time_sync.h", address(piste::bring_together)},
    {"piste/files/alignment.h", address(piste::alignment_json)},
    {"piste/files/findings.h", address(piste::findings_json)},
    {"piste/fit/imu_fit.h", address(piste::findings)},
    {"piste/fit/known_errors_of.h", address(piste::errors_of_lines)},
    {"piste/fit/phases.h", address<piste::Phases(const piste::AlignedImus&)>(piste::phases)},
    {"piste/align/align_config.h", address<piste::AlignConfig(const std::filesystem::path&)>(piste::read_align_config)},
    {"piste/align/aligned_pair.h", address(piste::for_each_pair)},
    {"piste/outputs/batch_folders.h", address(piste::write_allan)},
    {"piste/report/alignment_page.h", address(piste::alignment_html)},
    {"piste/report/alignment_text.h", address(piste::alignment_text)},
    {"piste/report/findings_text.h", address(piste::findings_text)},
    {"piste/study/missing.h", address(piste::missing)},
    {"piste/study/ranking.h", address(piste::leaders)},
    {"piste/study/study.h", address(piste::run_study)},
    {"piste/study/study_tables.h", address(piste::before_after)},
    {"piste/batch/batch.h", address(piste::run_batch)},
    {"piste/allan/allan_variance.h", address(piste::allan_curve)},
    {"piste/allan/gmwm.h", address(piste::fit_gmwm)},
    {"piste/allan/noise_process.h", address(piste::allan_covariance)},
    {"piste/allan/sensor_noise.h", address(piste::axis_noise)},
    {"piste/recordings/allan.h", address(piste::find_noise)},
    {"piste/files/allan.h", address(piste::allan_json)},
    {"piste/report/allan_page.h", address(piste::allan_page)},
    {"piste/report/allan_text.h", address(piste::allan_text)},
    {"piste/files/study.h", address(piste::study_csv)},
    {"piste/report/study_figures.h", address(piste::study_figures)},
    {"piste/report/study_page.h", address(piste::study_html)},
    {"piste/report/study_text.h", address(piste::study_text)},
};

// Of piste/condition/alignment.h.
bool undetermined_is_zero() {
  piste::Alignment alignment;
  alignment.p_rb_r = {1, 2, 3};
  alignment.covariance.setZero();
  alignment.covariance(piste::AlignmentLayout::kLeverArm + 1, piste::AlignmentLayout::kLeverArm + 1) =
      std::numeric_limits<double>::infinity();
  return alignment.known(alignment.p_rb_r, piste::AlignmentLayout::kLeverArm) == piste::Vector3d(1, 0, 3);
}

bool short_logs_are_refused() {
  try {
    piste::align({}, {}, {});
  } catch (const piste::DataError&) {
    return true;
  }
  return false;
}

}  // namespace

int main() {
  const bool right = undetermined_is_zero() && short_logs_are_refused() &&
                     consumer::all_link(std::begin(kExported), std::end(kExported));
  return right ? 0 : 1;
}
