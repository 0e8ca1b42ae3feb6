#include "files/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

namespace piste {
namespace {

// A descriptor, or a negative number.
int opened(const std::filesystem::path& file, int flags) {
  constexpr int kReadableByAll = 0666;                             // less the umask
  return ::open(file.c_str(), flags | O_CLOEXEC, kReadableByAll);  // NOLINT: open takes its mode as `...`
}

}  // namespace

FolderLock::FolderLock(std::filesystem::path file)
    : file_(std::move(file)), descriptor_(opened(file_, O_RDWR | O_CREAT)) {
  if (descriptor_ >= 0) flock(descriptor_, LOCK_EX | LOCK_NB);
}

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  std::error_code ignored;
  std::filesystem::remove(file_, ignored);
  close(descriptor_);
}

bool FolderLock::is_held(const std::filesystem::path& file) {
  const int descriptor = opened(file, O_RDONLY);
  if (descriptor < 0) return false;
  const bool held = flock(descriptor, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK;
  close(descriptor);
  return held;
}

CommitLock::CommitLock(const std::filesystem::path& folder) : descriptor_(opened(folder, O_RDONLY | O_DIRECTORY)) {
  while (descriptor_ >= 0 && flock(descriptor_, LOCK_EX) != 0 && errno == EINTR) {
  }
}

CommitLock::~CommitLock() {
  if (descriptor_ >= 0) close(descriptor_);
}

}  // namespace piste
