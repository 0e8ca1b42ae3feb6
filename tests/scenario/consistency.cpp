/// Are the sigmas true? NEES over many simulated runs against its chi-squared band.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/monte_carlo.h"

namespace piste::test {
namespace {

int env(const char* n, int d) { const char* v = std::getenv(n); return v ? std::atoi(v) : d; }

struct Group {
  std::string name;
  std::vector<Block> blocks;
};
std::vector<Group> groups(const StateLayout& layout) {
  std::vector<Group> g{{"whole", layout.blocks()}};
  for (const Block b : layout.blocks()) g.push_back({std::string(info(b).name), {b}});
  return g;
}

void table(const std::string& name, const std::vector<ReplayedRun>& runs, double from, double to) {
  fmt::print("{} [{:.0f},{:.0f}] {} runs\n", name, from, to, runs.size());
  for (const Group& g : groups(runs.front().layout)) {
    const Consistency f = consistency(runs, false, g.blocks, from, to), s = consistency(runs, true, g.blocks, from, to);
    fmt::print("  {:20s} f {:6.3f}{} {:5.2f}%  s {:6.3f}{} {:5.2f}%  [{:.3f} {:.3f}]\n", g.name, f.mean, f.within() ? ' ' : '*',
               100 * f.beyond, s.mean, s.within() ? ' ' : '*', 100 * s.beyond, f.low, f.high);
  }
  if (env("RMSE", 0)) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      double w = 0, t = 0, claimed = 0; 
      for (const auto& x : runs[i].filtered) { const double a = x.error.segment<3>(6).norm() * kDegreesPerRadian; if (x.time >= 0 && a > 1.5 && t == 0) { t = x.time; claimed = std::sqrt(x.P.diagonal().segment<3>(6).sum()) * kDegreesPerRadian; } if (x.time > 5) w = std::max(w, a); }
      if (w > 1.5) fmt::print("  seed {} worst {:.1f} deg, above 1.5 from {:.0f} s, claimed {:.2f}; start error {:.2f}\n", i + 1, w, t, claimed, runs[i].filtered.front().error.segment<3>(6).norm() * kDegreesPerRadian);
    }
    for (const bool smoothed : {false, true}) {
      Vector3d sum = Vector3d::Zero(); double n = 0;
      for (const auto& r : runs) for (const auto& x : smoothed ? r.smoothed : r.filtered) if (x.time >= from && x.time <= to) { sum += x.error.segment<3>(6).cwiseAbs2(); ++n; }
      const Vector3d rms = (sum / n).cwiseSqrt() * kDegreesPerRadian;
      fmt::print("  RMSE deg N E D {} {:.4f} {:.4f} {:.4f}\n", smoothed ? "smoothed" : "filtered", rms.x(), rms.y(), rms.z());
    }
  }
  if (env("PAIRS", 0)) {
    const auto& bs = runs.front().layout.blocks();
    for (const Block a : bs) {
      for (const Block b : bs) {
        const Block two[2] = {a, b};
        if (a < b) fmt::print(" {:>8.8s}-{:8.8s} f {:6.3f} s {:6.3f}\n", info(a).name, info(b).name, consistency(runs, false, two, from, to).mean, consistency(runs, true, two, from, to).mean);
      }
    }
  }
  std::fflush(stdout);
}

TEST(Consistency, Table) {
  const char* only = std::getenv("ONLY");
  const int n = env("RUNS", 50);
  const double rest = env("REST", 25), run = env("RUN", 35);
  for (const auto& [name, receiver] : std::vector<std::pair<std::string, std::string>>{
           {"ski", "gnss_l1l2"}, {"giant_slalom", "gnss_l1l2"}, {"bicycle", "gnss_l1l2"}, {"ski", "gnss_l1"}}) {
    if (only && (name + receiver).find(only) == std::string::npos) continue;
    Experiment e = experiment(name, receiver, rest, run, env("AFTER", 10));
    if (env("STILL", 0)) e.scenario.motion.turning_rate = 0;
    if (env("STILL", 0) > 1) e.scenario.motion.sway_rate.setZero();
    if (env("STILL", 0) > 2) e.scenario.motion.sway_velocity.setZero();
    e.find_heading = env("FIND", 0);
    const auto runs = replay_all(e, n);
    table(name + " " + receiver + " rest", runs, -rest + 4, -1);
    table(name + " " + receiver + " run", runs, 9, run);
    table(name + " " + receiver + " after", runs, run + 1, 1e9);
  }
}

}  // namespace
}  // namespace piste::test
