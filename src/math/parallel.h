#pragma once
/// Runs independent tasks on several threads.

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <vector>

#include "math/joining_thread.h"
#include "piste/math/interruption.h"

namespace piste {

/// Calls task(0) … task(count − 1), `jobs` at a time; each thread takes them in ascending order. After the first
/// exception no further task begins, and that exception is thrown again.
template <class Task>
void for_each_parallel(std::size_t count, std::size_t jobs, Task&& task) {
  std::atomic<std::size_t> next{0};
  std::exception_ptr stopped;
  std::mutex mutex;
  const auto work = [&] {
    for (std::size_t i = next++; i < count; i = next++) {
      try {
        check_interruption();
        task(i);
      } catch (...) {  // out of a thread it would end the program
        const std::lock_guard lock(mutex);
        if (!stopped) stopped = std::current_exception();
        next = count;
      }
    }
  };
  {
    std::vector<JoiningThread> others;
    for (std::size_t i = 1; i < jobs && i < count; ++i) others.emplace_back(work);
    work();
  }
  if (stopped) std::rethrow_exception(stopped);
}

/// The same for stretches of `length` tasks: task(first, end). Their bounds do not depend on the number of threads.
template <class Task>
void for_each_stretch(std::size_t count, std::size_t length, std::size_t jobs, Task&& task) {
  for_each_parallel((count + length - 1) / length, jobs, [&](std::size_t i) {
    const std::size_t first = i * length;
    task(first, std::min(first + length, count));
  });
}

}  // namespace piste
