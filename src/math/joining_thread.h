#pragma once
/// A thread that is waited for where it ends. libc++ has no std::jthread.

#include <functional>
#include <thread>
#include <utility>

namespace piste {

/// Runs `work()` in a thread of its own; the destructor waits for its end.
class JoiningThread {
 public:
  explicit JoiningThread(std::function<void()> work) : thread_(std::move(work)) {}
  ~JoiningThread() {
    if (thread_.joinable()) thread_.join();
  }
  JoiningThread(JoiningThread&&) = default;
  JoiningThread& operator=(JoiningThread&&) = delete;
  JoiningThread(const JoiningThread&) = delete;
  JoiningThread& operator=(const JoiningThread&) = delete;

 private:
  std::thread thread_;
};

}  // namespace piste
