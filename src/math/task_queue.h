#pragma once
/// Tasks that another thread does one after the other, while this one goes on.

#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <utility>

#include "math/joining_thread.h"

namespace piste {

/// A thread with a queue. Tasks run in the order in which they came. After the first exception no further task begins.
class TaskQueue {
 public:
  /// `most`: tasks that may wait; add() waits for room.
  explicit TaskQueue(std::size_t most) : most_(most), thread_([this] { work(); }) {}
  /// Leaves out the tasks that wait.
  ~TaskQueue() {
    const std::lock_guard lock(mutex_);
    stop_ = true;
    changed_.notify_all();
  }
  TaskQueue(const TaskQueue&) = delete;
  TaskQueue& operator=(const TaskQueue&) = delete;

  /// Throws the exception of an earlier task.
  void add(std::function<void()> task) {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return tasks_.size() < most_ || failed_; });
    rethrow();
    tasks_.push_back(std::move(task));
    changed_.notify_all();
  }
  /// Waits until all tasks are done. Throws as add().
  void finish() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return (tasks_.empty() && !busy_) || failed_; });
    rethrow();
  }

 private:
  void rethrow() {
    if (failed_) std::rethrow_exception(failed_);
  }

  void work() {
    std::unique_lock lock(mutex_);
    while (true) {
      changed_.wait(lock, [this] { return stop_ || (!tasks_.empty() && !failed_); });
      if (stop_) return;
      const std::function<void()> task = std::move(tasks_.front());
      tasks_.pop_front();
      busy_ = true;
      lock.unlock();
      std::exception_ptr thrown;
      try {
        task();
      } catch (...) {  // out of a thread it would end the program
        thrown = std::current_exception();
      }
      lock.lock();
      busy_ = false;
      failed_ = thrown;
      changed_.notify_all();
    }
  }

  std::size_t most_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<std::function<void()>> tasks_;
  bool busy_ = false, stop_ = false;
  std::exception_ptr failed_;
  JoiningThread thread_;  // last: it uses the others
};

}  // namespace piste
