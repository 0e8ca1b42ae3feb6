// The per-epoch path asks for no memory, and a run for little.

#include <gtest/gtest.h>

#include <cstdlib>

#include "piste/solve/rts.h"
#include "support/synthetic_log.h"

#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__)

namespace {
std::size_t g_count = 0, g_bytes = 0;  // of every allocation by this program
}

extern "C" {
void* __libc_malloc(std::size_t size);  // NOLINT: glibc's own name
void* malloc(std::size_t size) {
  ++g_count;
  g_bytes += size;
  return __libc_malloc(size);
}
}

namespace piste {
namespace {

std::vector<Block> ski_blocks() {
  return {Block::kGyroBias,   Block::kAccelBias, Block::kGyroDrift,
          Block::kAccelDrift, Block::kGyroScale, Block::kAccelScale};
}

TEST(Allocations, AreCounted) {
  const std::size_t before = g_count;
  const std::vector<double> some(100);
  EXPECT_EQ(g_count, before + 1);
}

class PerEpoch : public testing::TestWithParam<std::vector<Block>> {};
INSTANTIATE_TEST_SUITE_P(Allocations, PerEpoch,
                         testing::Values(std::vector<Block>{}, ski_blocks(), test::all_blocks()));

TEST_P(PerEpoch, PathAllocatesNothing) {
  test::SyntheticRun s = test::synthetic_run(20, GetParam());
  Filter filter(s.options, s.log.world, s.start);
  std::size_t fix = 0, second = 0, attitude = 0, magnetic = 0, counted = 0, updates = 0;
  for (std::size_t i = 0; i < s.log.imu.size(); ++i) {
    const ImuSample& sample = s.log.imu[i];
    const std::size_t before = g_count;
    const auto due = [&](const auto& fixes, std::size_t k) { return k < fixes.size() && fixes[k].time <= sample.time; };
    while (due(s.log.gnss[0], fix)) filter.add(0, s.log.gnss[0][fix++]);
    while (due(s.log.gnss[1], second)) filter.add(1, s.log.gnss[1][second++]);
    while (due(s.log.attitude[0], attitude)) filter.add(0, s.log.attitude[0][attitude++]);
    while (due(s.log.magnetic, magnetic)) filter.add(s.log.magnetic[magnetic++]);
    filter.add(sample);
    if (i > 10) counted += g_count - before;
    updates += filter.innovations().size();
    filter.clear_innovations();
  }
  EXPECT_EQ(s.log.imu.size(), 2000U);
  EXPECT_GT(updates, 700U);
  EXPECT_EQ(counted, 0U);
}

// Everything that filter and smoother keep or ask for, over a run of 27 states: two solutions and the checkpoints.
TEST(Allocations, ARunNeedsLessThan1500BytesAnEpoch) {
  test::SyntheticRun s = test::synthetic_run(60, ski_blocks());
  s.log.gnss[1].clear();
  s.log.attitude[0].clear();
  s.log.magnetic.clear();
  const std::size_t before = g_bytes;
  const FilterRun run = run_filter(s.log, s.options, s.start, kCheckpointEvery);
  const Solution smoothed = smooth_rts(s.log, run);
  ASSERT_EQ(smoothed.layout().size(), 27);
  const double per_epoch = static_cast<double>(g_bytes - before) / static_cast<double>(smoothed.size());
  EXPECT_LT(per_epoch, 1500);
  RecordProperty("bytes_per_epoch", std::to_string(per_epoch));
}

}  // namespace
}  // namespace piste

#endif
