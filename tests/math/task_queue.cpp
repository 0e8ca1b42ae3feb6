#include "math/task_queue.h"

#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <stdexcept>
#include <vector>

namespace piste {
namespace {

TEST(TaskQueue, DoesTasksInTheirOrderInAnotherThread) {
  std::vector<int> done;
  std::thread::id thread;
  TaskQueue queue(2);
  for (int i = 0; i < 100; ++i) {
    queue.add([&, i] {
      thread = std::this_thread::get_id();
      done.push_back(i);
    });
  }
  queue.finish();
  ASSERT_EQ(done.size(), 100u);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(done[static_cast<std::size_t>(i)], i);
  EXPECT_NE(thread, std::this_thread::get_id());
}

TEST(TaskQueue, PassesOnTheFirstExceptionAndDoesNoMore) {
  std::atomic<int> done{0};
  TaskQueue queue(10);
  queue.add([&] { ++done; });
  queue.add([] { throw std::runtime_error("disk full"); });
  EXPECT_THROW(queue.finish(), std::runtime_error);
  EXPECT_THROW(queue.add([&] { ++done; }), std::runtime_error);
  EXPECT_EQ(done, 1);
}

TEST(TaskQueue, LeavesOutWhatWaitsWhenItEnds) {
  std::atomic<bool> begun{false}, go_on{false};
  std::atomic<int> done{0};
  std::optional<JoiningThread> later;
  {
    TaskQueue queue(10);
    queue.add([&] {
      begun = true;
      begun.notify_all();
      go_on.wait(false);
    });
    queue.add([&] { ++done; });
    begun.wait(false);
    later.emplace([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(200));  // the queue ends meanwhile
      go_on = true;
      go_on.notify_all();
    });
  }
  EXPECT_EQ(done, 0);
}

}  // namespace
}  // namespace piste
