#include "piste/math/interruption.h"

#include <gtest/gtest.h>

#include <atomic>
#include <functional>
#include <thread>

#include "math/joining_thread.h"
#include "math/parallel.h"

namespace piste {
namespace {

struct Ended {};

TEST(Interruption, HoldsWhileItLives) {
  EXPECT_NO_THROW(check_interruption());
  int asked = 0;
  const std::function<void()> count = [&] { ++asked; }, end = [] { throw Ended(); };
  {
    const InterruptedBy outer(count);
    check_interruption();
    {
      const InterruptedBy inner(end);
      EXPECT_THROW(check_interruption(), Ended);
    }
    check_interruption();
  }
  check_interruption();
  EXPECT_EQ(asked, 2);
}

TEST(Interruption, IsOfOneThreadAndOfThoseThatItMakes) {
  const std::function<void()> end = [] { throw Ended(); };
  const InterruptedBy interrupted(end);
  bool own = false, other = false;
  {
    const JoiningThread made([&] {
      try {
        check_interruption();
      } catch (const Ended&) {
        own = true;
      }
    });
  }
  std::thread([&] { other = interruption() != nullptr; }).join();
  EXPECT_TRUE(own);
  EXPECT_FALSE(other);
}

// Tasks that ask nothing themselves are not begun any more.
TEST(Interruption, EndsParallelWork) {
  std::atomic<bool> over = false;
  std::atomic<int> done = 0;
  const std::function<void()> check = [&] {
    if (over) throw Ended();
  };
  const InterruptedBy interrupted(check);
  const auto work = [&] {
    for_each_parallel(1000, 3, [&](std::size_t) {
      if (++done == 10) over = true;
    });
  };
  EXPECT_THROW(work(), Ended);
  EXPECT_LT(done, 20);
}

}  // namespace
}  // namespace piste
