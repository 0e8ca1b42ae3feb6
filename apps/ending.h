#pragma once
/// Ends a program cleanly when Ctrl-C or a scheduler asks it to.

#include <atomic>
#include <csignal>
#include <thread>

namespace piste {

/// While it lives, SIGINT, SIGTERM and SIGHUP remove the half-written outputs of this program, then end it as they
/// would without it. A signal that the program's caller ignores stays ignored. Construct it before any thread.
class EndOnSignal {
 public:
  EndOnSignal();
  ~EndOnSignal();
  EndOnSignal(const EndOnSignal&) = delete;
  EndOnSignal& operator=(const EndOnSignal&) = delete;

 private:
  void wait();
  sigset_t awaited_ = {}, before_ = {};
  int wake_ = 0;  // one of the awaited signals, if there is any
  std::atomic<bool> over_ = false;
  std::thread waiter_;
};

}  // namespace piste
