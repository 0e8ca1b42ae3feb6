#pragma once
/// A thread that is waited for where it ends. libc++ has no std::jthread.

#include <functional>
#include <optional>
#include <thread>
#include <utility>

#include "piste/math/interruption.h"

namespace piste {

/// Runs `work()` in a thread of its own; the destructor waits for its end. The interruption check of the creating
/// thread also holds in this one.
class JoiningThread {
 public:
  explicit JoiningThread(std::function<void()> work)
      : thread_([check = interruption(), work = std::move(work)] {
          std::optional<InterruptedBy> interrupted;
          if (check != nullptr) interrupted.emplace(*check);
          work();
        }) {}
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
