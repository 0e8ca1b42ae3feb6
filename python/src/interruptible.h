#pragma once
/// Runs C++ in a thread next to the interpreter, so that Ctrl-C and progress work.

#include <Python.h>
#include <nanobind/nanobind.h>

#include <atomic>
#include <chrono>
#include <exception>
#include <functional>
#include <future>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "piste/math/interruption.h"

namespace piste::python {

namespace nb = nanobind;

/// Ends the work in its thread after the interpreter was interrupted.
struct Interrupted : std::exception {
  const char* what() const noexcept override { return "interrupted"; }
};

/// The progress of the work, written by its threads and read by the interpreter's thread.
class Told {
 public:
  /// Throws Interrupted if the work is to end.
  void check() const {
    if (stop_) throw Interrupted();
  }
  void operator()(std::string_view stage, double done) {
    check();
    const std::lock_guard lock(mutex_);
    stage_ = stage;
    done_ = done;
  }
  void stop() { stop_ = true; }
  std::pair<std::string, double> now() const {
    const std::lock_guard lock(mutex_);
    return {stage_, done_};
  }

 private:
  std::atomic<bool> stop_ = false;
  mutable std::mutex mutex_;
  std::string stage_;
  double done_ = 0;
};

/// Returns the result of `work(told)`. It runs in its own thread without the interpreter's lock. `progress`, if it is
/// not None, is called some times a second with the stage and the part of it that is done, 0 to 1. An exception of
/// `progress` or a signal ends the work at the next check_interruption(), which the loops of the library call.
template <class Work>
auto interruptible(const nb::object& progress, Work&& work) {
  constexpr std::chrono::milliseconds kPatience{50};
  Told told;
  const std::function<void()> check = [&told] { told.check(); };
  auto result = std::async(std::launch::async, [&] {
    const InterruptedBy interrupted(check);
    return work(told);
  });
  const auto wait = [&](auto... patience) {
    const nb::gil_scoped_release release;
    if constexpr (sizeof...(patience) == 0) {
      result.wait();
      return true;
    } else {
      return result.wait_for(patience...) == std::future_status::ready;
    }
  };
  try {
    std::pair<std::string, double> last;
    while (!wait(kPatience)) {
      if (PyErr_CheckSignals() != 0) throw nb::python_error();
      if (progress.is_none()) continue;
      auto now = told.now();
      if (now == last || now.first.empty()) continue;
      progress(now.first, now.second);
      last = std::move(now);
    }
  } catch (...) {
    told.stop();
    wait();
    throw;
  }
  return result.get();
}

}  // namespace piste::python
