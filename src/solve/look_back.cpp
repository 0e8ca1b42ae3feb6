#include "piste/solve/look_back.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "piste/solve/fix_queue.h"
#include "piste/solve/rts.h"

namespace piste {
namespace {

constexpr int kMostPasses = 4;
// Sigmas: a trajectory that moves by less anywhere is linearised well enough, as the next pass moves it by much less.
constexpr double kStill = 0.5;

// The farthest that position, velocity or attitude has moved from one smoothed run to another, in its sigmas.
double farthest_moved(const Solution& from, const Solution& to) {
  constexpr std::size_t kEvery = 10;  // rows
  double farthest = 0;
  for (std::size_t i = 0; i < std::min(from.size(), to.size()); i += kEvery) {
    const Estimate x = from.estimate(i), y = to.estimate(i);
    const Sigmas sigmas = to.sigmas(i);
    const auto look = [&](const Vector3d& moved, const Vector3d& sigma) {
      if (sigma.minCoeff() > 0) farthest = std::max(farthest, moved.cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    };
    const Matrix3d R_nw = to.world().rotation_wn(y.p_wb).transpose();
    look(R_nw * (y.p_wb - x.p_wb), sigmas.position);
    look(R_nw * (y.v_wb - x.v_wb), sigmas.velocity);
    const Vector3d turned = to_euler(R_nw * y.R_wb()) - to_euler(R_nw * x.R_wb());
    look(turned.unaryExpr([](double angle) { return std::remainder(angle, 2 * std::numbers::pi); }), sigmas.euler);
  }
  return farthest;
}

}  // namespace

LookedBack looked_back(const Log& log, const FilterOptions& options, const FoundStart& found) {
  if (!found.aligned) return {};
  const double end = *found.aligned + kSameInstant;
  LookedBack back;
  back.run = run_filter(log, options, found.start, Keep::kHistory, {}, end);
  back.rows = smooth_rts(back.run);
  for (int pass = 0; pass < kMostPasses; ++pass) {
    back.about = std::make_shared<const Reference>(smoothed_trajectory(back.run));
    back.run = run_filter(log, options, without_alignment(log.world, found), Keep::kHistory, {}, end, back.about);
    Solution rows = smooth_rts(back.run);
    const double moved = farthest_moved(back.rows, rows);
    back.rows = std::move(rows);
    if (moved < kStill) break;
  }
  return back;
}

FilterRun filter_from(const LookedBack& back, const Log& log, const FilterOptions& options, const FoundStart& found,
                      Keep keep, const ProgressCallback& progress, double end_time, const RowTaker& rows,
                      const std::filesystem::path& scratch) {
  const double end = std::min(end_time, log.imu.empty() ? 0 : log.imu.back().time);
  const bool goes_on = back.about && back.about->size() > 0 && back.about->last_time() < end - kSameInstant;
  return goes_on ? run_filter(log, options, without_alignment(log.world, found), keep, progress, end_time, back.about,
                              rows, scratch)
                 : run_filter(log, options, found.start, keep, progress, end_time, nullptr, rows, scratch);
}

void put_rows(const Solution& known, std::size_t first, Solution& filtered) {
  for (std::size_t i = first; i < std::min(known.size(), first + filtered.size()); ++i) {
    filtered.set(i - first, known.time(i), known.estimate(i), known.sigmas(i));
  }
}

void put_rows(const Solution& known, FilterRun& filtered) {
  Solution& rows = filtered.solution;
  filtered.replaced = Solution(rows.layout(), rows.world());
  filtered.replaced.fixed = rows.fixed;
  filtered.replaced.append(rows.rows().first(std::min(known.size(), rows.size()) * rows.stride()));
  put_rows(known, 0, rows);
}

}  // namespace piste
