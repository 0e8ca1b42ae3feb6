#pragma once
/// How a program ends where Ctrl-C or a scheduler asks it to.

#include <atomic>
#include <csignal>
#include <thread>

namespace piste {

/// While it lives, SIGINT, SIGTERM and SIGHUP remove what this program has half written, then end it as they would
/// without it. One that the program's caller ignores stays ignored. To be made before other threads are.
class EndOnSignal {
 public:
  EndOnSignal();
  ~EndOnSignal();
  EndOnSignal(const EndOnSignal&) = delete;
  EndOnSignal& operator=(const EndOnSignal&) = delete;

 private:
  void wait();
  sigset_t awaited_ = {}, before_ = {};
  int wake_ = 0;  // one of those that are awaited, if any is
  std::atomic<bool> over_ = false;
  std::thread waiter_;
};

}  // namespace piste
