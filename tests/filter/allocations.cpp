// The per-epoch path asks for no memory, and a run for little.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include <algorithm>
#include <cstdlib>
#include <memory>

#include "piste/condition/signal.h"
#include "piste/smoother/rts.h"
#include "support/synthetic_log.h"

#ifdef __GLIBC__

#include <malloc.h>

namespace {
std::size_t g_count = 0;                // allocations by this program
std::ptrdiff_t g_live = 0, g_peak = 0;  // bytes held now, and at most
}  // namespace

extern "C" {
void* __libc_malloc(std::size_t size);  // NOLINT: glibc's own names
void __libc_free(void* block);          // NOLINT
void* malloc(std::size_t size) {
  void* block = __libc_malloc(size);
  ++g_count;
  g_live += static_cast<std::ptrdiff_t>(malloc_usable_size(block));
  g_peak = std::max(g_peak, g_live);
  return block;
}
void free(void* block) {
  g_live -= static_cast<std::ptrdiff_t>(malloc_usable_size(block));
  __libc_free(block);
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
  s.options.adapt = AdaptationOptions{};
  Filter filter(s.options, s.log.world, s.start);
  std::size_t fix = 0, second = 0, attitude = 0, magnetic = 0, counted = 0, updates = 0;
  for (std::size_t i = 0; i < s.log.imu.size(); ++i) {
    const ImuSample& sample = s.log.imu[i];
    const std::size_t before = g_count;
    const auto due = [&](const auto& fixes, std::size_t k) { return k < fixes.size() && fixes[k].time <= sample.time; };
    while (due(s.log.gnss[0], fix)) filter.add(0, s.log.gnss[0][fix++]);
    while (due(s.log.gnss[1], second)) filter.add(1, s.log.gnss[1][second++]);
    while (due(s.log.attitude[0], attitude)) filter.add(0, s.log.attitude[0][attitude++]);
    while (due(s.log.magnetic, magnetic)) filter.add(0, s.log.magnetic[magnetic++]);
    filter.add(sample);
    if (i > 10) counted += g_count - before;
    updates += filter.innovations().size();
    filter.clear_innovations();
  }
  EXPECT_EQ(s.log.imu.size(), 2000U);
  EXPECT_GT(updates, 700U);
  EXPECT_EQ(counted, 0U);
}

// Bytes of a filter, and what its epochs have on the stack of a thread that was filled with a mark.
struct Needs {
  std::size_t object = sizeof(Filter), heap = 0, stack = 0;
};

struct Session {
  const test::SyntheticRun* run;
  Filter* filter;
};

void* run_session(void* argument) {
  const Session& session = *static_cast<const Session*>(argument);
  const Log& log = session.run->log;
  std::size_t fix = 0;
  for (const ImuSample& sample : log.imu) {
    for (; fix < log.gnss[0].size() && log.gnss[0][fix].time <= sample.time; ++fix) {
      session.filter->add(0, log.gnss[0][fix]);
    }
    session.filter->add(sample);
    session.filter->clear_innovations();
  }
  return nullptr;
}

Needs needs_of(const std::vector<Block>& blocks) {
  constexpr std::size_t kStack = std::size_t{8} << 20U;
  constexpr unsigned char kMark = 0xA5;
  const test::SyntheticRun run = test::synthetic_run(20, blocks);
  std::vector<unsigned char> stack(kStack, kMark);
  const std::ptrdiff_t before = g_live;
  const auto filter = std::make_unique<Filter>(run.options, run.log.world, run.start);
  Needs needs;
  needs.heap = static_cast<std::size_t>(g_live - before);  // without the object, which is of aligned memory
  Session session{&run, filter.get()};
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  EXPECT_EQ(pthread_attr_setstack(&attributes, stack.data(), stack.size()), 0);
  pthread_t thread{};
  EXPECT_EQ(pthread_create(&thread, &attributes, run_session, &session), 0);
  pthread_join(thread, nullptr);
  pthread_attr_destroy(&attributes);
  const auto touched = std::find_if(stack.begin(), stack.end(), [](unsigned char c) { return c != kMark; });
  needs.stack = static_cast<std::size_t>(stack.end() - touched);
  return needs;
}

TEST(Allocations, AFilterNeedsLittleStackAndHeap) {
  for (const auto& blocks : {ski_blocks(), test::all_blocks()}) {
    const Needs needs = needs_of(blocks);
    constexpr double kKibi = 1024;
    fmt::print("{} blocks: an object of {:.0f} KiB, {:.0f} KiB of heap from its constructor, {:.0f} KiB of stack\n",
               blocks.size(), static_cast<double>(needs.object) / kKibi, static_cast<double>(needs.heap) / kKibi,
               static_cast<double>(needs.stack) / kKibi);
    EXPECT_GT(needs.stack, 4U << 10U) << "the mark was not seen";
    EXPECT_LT(needs.stack, 256U << 10U);
    EXPECT_LT(needs.object, 256U << 10U);
    EXPECT_LT(needs.heap, 128U << 10U);
  }
}

TEST(Allocations, LiveLowPassAsksForNothing) {
  const std::size_t before = g_count;
  CausalLowPass filter(LowPass(12, 100, LowPass::kMaxOrder - 1));
  Vector3d last = Vector3d::Zero();
  for (int k = 0; k < 1000; ++k) last = filter.add({1, 0.1 * k, -9.81});
  EXPECT_EQ(g_count, before);
  EXPECT_GT(last.y(), 90);
}

// Most that filter and smoother hold at once over a run of 27 states.
double peak_bytes(double duration, std::size_t& epochs) {
  test::SyntheticRun s = test::synthetic_run(duration, ski_blocks());
  s.log.gnss[1].clear();
  s.log.attitude[0].clear();
  s.log.magnetic.clear();
  const std::ptrdiff_t before = g_live;
  g_peak = before;
  const FilterRun run = run_filter(s.log, s.options, s.start, Keep::kHistory);
  const Solution smoothed = smooth_rts(run);
  EXPECT_EQ(smoothed.layout().size(), 27);
  epochs = smoothed.size();
  return static_cast<double>(g_peak - before);
}

TEST(Allocations, SmoothingNeedsLessThan1500BytesAnEpoch) {
  // What the smoother holds of one chunk does not grow with the run.
  std::size_t few = 0, many = 0;
  const double small = peak_bytes(20, few), large = peak_bytes(120, many);
  const double per_epoch = (large - small) / static_cast<double>(many - few);
  RecordProperty("bytes_per_epoch", std::to_string(per_epoch));
  EXPECT_LT(per_epoch, 1500);
  EXPECT_GT(per_epoch, 900) << "two solutions are kept";
  EXPECT_LT(small - per_epoch * static_cast<double>(few), 16e6) << "and one chunk";
}

}  // namespace
}  // namespace piste

#endif
