#include "walker/fix_queue.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/time_search.h"

namespace piste {
namespace {

QueuedFix at(double time, int source, int sensor = 0) {
  return {time, source, sensor, 0, MagneticSample{.time = time, .field = Vector3d::UnitX()}};
}

const std::vector<double> kOnTime(10, 0.0);

TEST(FixQueue, GivesByTimeThenBySourceThenAsTheyCame) {
  FixQueue queue;
  queue.add(at(2, 0));
  queue.add(at(1, 3));
  queue.add(at(1, 1, 7));
  queue.add(at(1, 1, 8));
  queue.add(at(0.5, 9));
  std::vector<std::pair<double, int>> seen;
  while (const auto fix = queue.take(10, kOnTime)) seen.emplace_back(fix->time, 10 * fix->source + fix->sensor);
  const std::vector<std::pair<double, int>> expected{{0.5, 90}, {1, 17}, {1, 18}, {1, 30}, {2, 0}};
  EXPECT_EQ(seen, expected);
}

TEST(FixQueue, HoldsBackWhatIsLater) {
  FixQueue queue;
  queue.add(at(1, 0));
  queue.add(at(2, 0));
  EXPECT_FALSE(queue.take(0.9, kOnTime));
  EXPECT_TRUE(queue.take(1 - 0.5 * kSameInstant, kOnTime)) << "the same instant";
  EXPECT_FALSE(queue.take(1.5, kOnTime));
  queue.add(at(1.2, 0));
  const auto fix = queue.take(1.5, kOnTime);
  ASSERT_TRUE(fix);
  EXPECT_EQ(fix->time, 1.2);
}

// What comes late is given when the time is reached where it belongs, by the delays as they are then.
TEST(FixQueue, OrdersByWhereAFixBelongs) {
  FixQueue queue;
  for (const double time : {1.0, 2.0}) {
    queue.add(at(time, 0));
    queue.add(at(time, 1));
  }
  EXPECT_FALSE(queue.take(0.6, std::vector{0.0, 0.3}));
  const auto first = queue.take(0.6, std::vector{0.0, 0.5});
  ASSERT_TRUE(first);
  EXPECT_EQ(first->source, 1);
  std::vector<double> order;
  while (const auto fix = queue.take(3, std::vector{-0.1, 0.95})) order.push_back(10 * fix->source + fix->time);
  EXPECT_EQ(order, (std::vector<double>{12, 1, 2})) << "1.05 of the late one, then 1.1 and 2.1 of the early one";
}

}  // namespace
}  // namespace piste
