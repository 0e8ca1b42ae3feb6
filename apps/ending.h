#pragma once
/// How a program ends where Ctrl-C or a scheduler asks it to.

#include <atomic>
#include <csignal>
#include <filesystem>
#include <thread>
#include <vector>

namespace piste {

/// While it lives, SIGINT, SIGTERM and SIGHUP remove what is half written below the output folder, and the folders that
/// did not stand before, then end the program as they would without it. One that the program's caller ignores stays
/// ignored. To be made before other threads are.
class EndOnSignal {
 public:
  explicit EndOnSignal(std::filesystem::path output);
  ~EndOnSignal();
  EndOnSignal(const EndOnSignal&) = delete;
  EndOnSignal& operator=(const EndOnSignal&) = delete;

 private:
  void wait();
  std::filesystem::path output_;
  std::vector<std::filesystem::path> missing_;  // folders, the innermost first
  sigset_t awaited_ = {}, before_ = {};
  int wake_ = 0;  // one of those that are awaited, if any is
  std::atomic<bool> over_ = false;
  std::thread waiter_;
};

}  // namespace piste
