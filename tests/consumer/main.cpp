// Links with piste::piste alone. Every header of the front door stands here with something of it that must link:
// run.cmake fails where one is missing.

#include <cmath>
#include <filesystem>
#include <iterator>
#include <vector>

#include "address.h"
#include "piste/piste.h"

namespace {

using consumer::address;
using consumer::Exported;

const Exported kExported[] = {
    {"piste/core/estimate.h",
     address<piste::FullError(const piste::Estimate&, const piste::Estimate&)>(piste::boxminus)},
    {"piste/math/interruption.h", address(piste::check_interruption)},
    {"piste/core/options.h", address(+[](const piste::FilterOptions& options) { options.validate(); })},
    {"piste/core/solution.h", address(piste::sigmas_of)},
    {"piste/core/sensor_class.h", address(piste::class_of)},
    {"piste/core/version.h", address(piste::version)},
    {"piste/condition/pipeline.h",
     address<piste::Log(const piste::Recording&, const piste::ConditioningOptions&)>(piste::condition)},
    {"piste/condition/rest_detection.h",
     address<std::vector<piste::Interval>(const piste::Log&, const piste::RestOptions&)>(piste::detect_rest)},
    {"piste/condition/signal.h", address(piste::zero_phase)},
    {"piste/consistency/consistency.h", address(piste::consistency_verdict)},
    {"piste/consistency/disputes.h", address(piste::disputes_of)},
    {"piste/consistency/range_sums.h", address(piste::RangeSums::restore)},
    {"piste/outputs/folders.h", address(piste::write_consistency)},
    {"piste/outputs/evaluation_folder.h", address(piste::write_evaluation)},
    {"piste/trajectory/trajectory.h", address(piste::read_trajectory)},
    {"piste/evaluate/evaluation.h", address(piste::evaluate)},
    {"piste/descents/descents.h", address(piste::compare_descents)},
    {"piste/files/descents.h", address(piste::descents_json)},
    {"piste/outputs/descents_folder.h", address(piste::write_descents)},
    {"piste/report/descents_page.h", address(piste::descents_page)},
    {"piste/io/marks.h", address(piste::read_marks)},
    {"piste/exports/exports.h", address(piste::exported)},
    {"piste/files/evaluation.h", address(piste::evaluation_json)},
    {"piste/report/evaluation_page.h", address(piste::evaluation_page)},
    {"piste/outputs/replay_folder.h", address(piste::write_replay)},
    {"piste/trial/ensemble.h",
     address(+[](const piste::Scenario& scenario) { return piste::Ensemble(scenario).size(); })},
    {"piste/search/inspect.h",
     address<piste::Inspection(const std::vector<std::string>&, const piste::StageProgress&)>(piste::inspect)},
    {"piste/search/readings.h", address(piste::weigh_readings)},
    {"piste/search/rounds.h", address(piste::take_causes)},
    {"piste/search/tune.h", address(piste::tune)},
    {"piste/files/tuning.h", address(piste::tuning_text)},
    {"piste/tune/likeliest_noise.h", address(piste::likeliest_noise)},
    {"piste/tune/standing_heights.h", address(piste::is_of_heights_alone)},
    {"piste/consistency/verdict.h", address(piste::judge)},
    {"piste/consistency/warnings.h", address(piste::warnings_of)},
    {"piste/diagnosis/diagnose.h", address(piste::diagnose)},
    {"piste/diagnosis/run_warnings.h", address(piste::run_warnings)},
    {"piste/replay/replay.h", address(piste::replay_options)},
    {"piste/files/replay.h", address(piste::write_solutions)},
    {"piste/files/consistency.h", address(piste::consistency_json)},
    {"piste/files/summary.h", address(piste::summary_json)},
    {"piste/io/log_io.h", address(piste::read_gnss)},
    {"piste/configuration/replay_config.h", address(piste::read_recording)},
    {"piste/configuration/sensor_file.h", address(piste::sensor_text)},
    {"piste/io/solution_io.h", address<std::string(const piste::Solution&)>(piste::navigation_csv)},
    {"piste/report/consistency_page.h", address(piste::consistency_html)},
    {"piste/report/consistency_text.h", address(piste::consistency_text)},
    {"piste/report/html.h", address(piste::html_report)},
    {"piste/report/inspection_page.h", address(piste::inspection_page)},
    {"piste/report/inspection_text.h", address(piste::inspection_text)},
    {"piste/report/kml.h", address(piste::kml)},
    {"piste/report/tuning_page.h", address(piste::tuning_page)},
    {"piste/sim/campaign.h", address<piste::Campaign(const std::filesystem::path&)>(piste::read_campaign)},
    {"piste/sim/simulation.h", address(piste::simulate)},
    {"piste/start/attitude_noise.h", address(piste::with_white_part)},
    {"piste/filter/filter.h", address(+[](piste::Filter& filter) { return filter.finish(); })},
    {"piste/live/live.h", address(+[](const piste::Live& live) { return live.late(); })},
    {"piste/start/initial_stretch.h", address(piste::initial_stretch)},
    {"piste/filter/run.h", address(piste::run_filter)},
    {"piste/filter/update.h", address(piste::innovate)},
    {"piste/smoother/rts.h", address(piste::smooth_rts)},
    {"piste/start/start.h", address(piste::find_start)},
};

// Of piste/core/error.h, piste/core/log.h and piste/core/sensor.h, which hold values: a log of nothing is refused.
bool empty_log_is_refused() {
  const piste::Log log;
  const piste::ImuSensor sensor;
  try {
    piste::find_start(log, {.sensor = sensor}, {});
  } catch (const piste::Error&) {
    return true;
  }
  return false;
}

}  // namespace

int main() {
  const piste::World world({0.8, 0.1, 1500});
  piste::FullError error = piste::FullError::Zero();
  error[piste::full_offset(piste::Block::kAttitude)] = 0.01;
  const piste::Estimate estimate = boxplus(piste::Estimate{}, error);
  const double gravity = world.gravity(estimate.p_wb).value.norm();
  if (!(std::abs(gravity - 9.80) < 0.02 && boxminus(estimate, {}).isApprox(error))) return 1;
  if (!empty_log_is_refused()) return 1;
  return consumer::all_link(std::begin(kExported), std::end(kExported)) ? 0 : 1;
}
