#pragma once
/// Least squares by Ceres that can be interrupted.

#include <ceres/ceres.h>

#include <exception>

#include "piste/math/interruption.h"

namespace piste {

/// As ceres::Solve(). An interruption is thrown here, and not through the solver, which may have threads of its own.
inline void solve_least_squares(ceres::Solver::Options options, ceres::Problem& problem,
                                ceres::Solver::Summary& summary) {
  struct Check final : ceres::IterationCallback {
    ceres::CallbackReturnType operator()(const ceres::IterationSummary&) override {
      try {
        check_interruption();
        return ceres::SOLVER_CONTINUE;
      } catch (...) {
        thrown = std::current_exception();
        return ceres::SOLVER_ABORT;
      }
    }
    std::exception_ptr thrown;
  } check;
  options.callbacks.push_back(&check);
  ceres::Solve(options, &problem, &summary);
  if (check.thrown) std::rethrow_exception(check.thrown);
}

}  // namespace piste
