#include "ending.h"

#include <pthread.h>

#include "piste/files/output.h"

namespace piste {

EndOnSignal::EndOnSignal() {
  sigemptyset(&awaited_);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    struct sigaction now = {};
    if (sigaction(signal, nullptr, &now) != 0 || now.sa_handler != SIG_DFL) continue;
    sigaddset(&awaited_, signal);
    wake_ = signal;
  }
  if (wake_ == 0) return;
  // Threads that start after this inherit the mask, so that a signal waits for wait().
  pthread_sigmask(SIG_BLOCK, &awaited_, &before_);
  waiter_ = std::thread([this] { wait(); });
}

EndOnSignal::~EndOnSignal() {
  if (!waiter_.joinable()) return;
  over_ = true;
  pthread_kill(waiter_.native_handle(), wake_);
  waiter_.join();
  pthread_sigmask(SIG_SETMASK, &before_, nullptr);
}

void EndOnSignal::wait() {
  int signal = 0;
  if (sigwait(&awaited_, &signal) != 0 || over_) return;
  const auto lock = OutputFolder::abandon_all();
  pthread_sigmask(SIG_UNBLOCK, &awaited_, nullptr);
  std::raise(signal);
}

}  // namespace piste
