// Prints the numbers of the shipped run with all their digits: `numbers CHECKOUT`. scripts/same_numbers builds it in
// many ways and compares. A line is either a value, `KIND TIME NAME VALUE SIGMA`, or something that is chosen, `= KIND
// WHAT`.

#include <fmt/format.h>

#include <cmath>
#include <exception>
#include <filesystem>
#include <string>

#include "piste/configuration/replay_config.h"
#include "piste/core/solution.h"
#include "piste/math/earth.h"
#include "piste/replay/replay.h"
#ifdef PISTE_NUMBERS_BATCH
#include "piste/batch/batch.h"
#endif

namespace piste {
namespace {

constexpr double kInterval = 1;  // s between the rows that are printed

void print_values(const char* kind, double time, const char* name, const Eigen::Ref<const Eigen::VectorXd>& values,
                  const Eigen::Ref<const Eigen::VectorXd>& sigmas) {
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (sigmas(i) > 0) fmt::print("{} {:.6f} {}_{} {:.17g} {:.17g}\n", kind, time, name, i, values(i), sigmas(i));
  }
}

void print_rows(const char* kind, const Solution& solution) {
  const World world(solution.navigation(0).position);
  double next = solution.time(0);
  for (std::size_t i = 0; i < solution.size(); ++i) {
    if (solution.time(i) < next) continue;
    next += kInterval;
    const Navigation n = solution.navigation(i);
    const Sigmas sigmas = solution.sigmas(i);
    const double time = solution.time(i);
    print_values(kind, time, "position", world.from_geodetic(n.position), sigmas.position);
    print_values(kind, time, "velocity", n.velocity, sigmas.velocity);
    print_values(kind, time, "euler", n.euler, sigmas.euler);
    print_values(kind, time, "block", boxminus(solution.estimate(i), Estimate{}), sigmas.blocks);
  }
}

void print_outcomes(const Solution& solution) {
  for (const Innovation& v : solution.innovations) {
    fmt::print("= innovation {:.6f} {} {}\n", v.time, v.source, static_cast<int>(v.outcome));
  }
}

void print_run(const std::filesystem::path& checkout) {
  ReplayConfig config = read_replay_config((checkout / "config/ski_run.yaml").string());
  const Replay run = replay(config);
  print_outcomes(run.filtered.solution);
  print_rows("filter", run.filtered.solution);
  print_rows("smoother", *run.smoothed);
#ifdef PISTE_NUMBERS_BATCH
  config.smoother = SmootherKind::kBatch;
  print_rows("batch", *replay(config, {}, batch_solver(config.batch, 1)).smoothed);
#endif
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  if (argc != 2) {
    fmt::print(stderr, "usage: numbers CHECKOUT\n");
    return 2;
  }
  try {
    piste::print_run(argv[1]);
  } catch (const std::exception& e) {
    fmt::print(stderr, "{}\n", e.what());
    return 1;
  }
  return 0;
}
