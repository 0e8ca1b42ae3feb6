/// Are the sigmas true? NEES over many simulated runs against its chi-squared band.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>

#include "support/monte_carlo.h"

namespace piste::test {
namespace {

int env(const char* n, int d) {
  const char* v = std::getenv(n);
  return v ? std::atoi(v) : d;
}

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
    fmt::print("  {:20s} f {:6.3f}{} {:5.2f}%  s {:6.3f}{} {:5.2f}%  [{:.3f} {:.3f}]\n", g.name, f.mean,
               f.within() ? ' ' : '*', 100 * f.beyond, s.mean, s.within() ? ' ' : '*', 100 * s.beyond, f.low, f.high);
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
    e.find_heading = env("FIND", 0);
    const auto runs = replay_all(e, n);
    table(name + " " + receiver + " rest", runs, -rest + 4, -1);
    table(name + " " + receiver + " run", runs, 9, run);
    table(name + " " + receiver + " after", runs, run + 1, 1e9);
  }
}

}  // namespace
}  // namespace piste::test
