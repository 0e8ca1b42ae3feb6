#include "piste/solve/fix_queue.h"

#include <gtest/gtest.h>

#include <vector>

namespace piste {
namespace {

QueuedFix at(double time, int source, int sensor = 0) {
  return {time, source, sensor, MagneticSample{.time = time, .field = Vector3d::UnitX()}};
}

TEST(FixQueue, GivesByTimeThenBySourceThenAsTheyCame) {
  FixQueue queue;
  queue.add(at(2, 0));
  queue.add(at(1, 3));
  queue.add(at(1, 1, 7));
  queue.add(at(1, 1, 8));
  queue.add(at(0.5, 9));
  std::vector<std::pair<double, int>> seen;
  for (; const QueuedFix* fix = queue.next(10); queue.take())
    seen.emplace_back(fix->time, 10 * fix->source + fix->sensor);
  const std::vector<std::pair<double, int>> expected{{0.5, 90}, {1, 17}, {1, 18}, {1, 30}, {2, 0}};
  EXPECT_EQ(seen, expected);
}

TEST(FixQueue, HoldsBackWhatIsLater) {
  FixQueue queue;
  queue.add(at(1, 0));
  queue.add(at(2, 0));
  EXPECT_EQ(queue.next(0.9), nullptr);
  ASSERT_NE(queue.next(1 - 0.5 * kSameInstant), nullptr) << "the same instant";
  queue.take();
  EXPECT_EQ(queue.next(1.5), nullptr);
  queue.drop_taken();
  queue.add(at(1.2, 0));
  ASSERT_NE(queue.next(1.5), nullptr);
  EXPECT_EQ(queue.next(1.5)->time, 1.2);
}

}  // namespace
}  // namespace piste
