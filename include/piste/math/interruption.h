#pragma once
/// Lets whoever began some work end it before it is done, as Ctrl-C does in Python.

#include <functional>

namespace piste {

/// While it lives, check_interruption() calls `check` in this thread, and in the threads to which the library hands
/// parts of the work. To end the work, `check` throws an exception that is no piste::Error: the library would take that
/// for a finding about the data. Several threads call it concurrently, some hundred times a second or more.
///
/// @code
///   std::atomic<bool> stop = false;  // set by a signal handler or another thread
///   const std::function<void()> check = [&] { if (stop) throw std::runtime_error("stopped"); };
///   const InterruptedBy interrupted(check);
///   const Inspection found = inspect({"imu.csv", "gnss.csv"});  // ends within a second once `stop` is true
/// @endcode
class InterruptedBy {
 public:
  /// @pre `check` outlives it, and is not empty
  explicit InterruptedBy(const std::function<void()>& check);
  ~InterruptedBy();
  InterruptedBy(const InterruptedBy&) = delete;
  InterruptedBy& operator=(const InterruptedBy&) = delete;

 private:
  const std::function<void()>* before_;
};

/// What check_interruption() calls in this thread; null if nothing may end the work.
const std::function<void()>* interruption();

/// Throws if the work of this thread is to end. Long loops call it; it costs a nanosecond where nothing is asked.
void check_interruption();

}  // namespace piste
