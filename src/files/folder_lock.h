#pragma once
/// A file that stands in a folder, locked, as long as a program writes there. The lock ends with the program, however
/// it ends.

#include <filesystem>
#include <string>

namespace piste {

/// Held from construction to destruction, which removes the file. Where a file system has no locks, or the folder
/// cannot be written, it holds nothing.
class FolderLock {
 public:
  explicit FolderLock(std::filesystem::path file);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  /// Whether any program, this one or another, holds the lock of this file.
  static bool is_held(const std::filesystem::path& file);

 private:
  std::filesystem::path file_;
  int descriptor_;
};

/// Waits until no other CommitLock of this folder exists, in any program, and holds it.
class CommitLock {
 public:
  explicit CommitLock(const std::filesystem::path& folder);
  ~CommitLock();
  CommitLock(const CommitLock&) = delete;
  CommitLock& operator=(const CommitLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace piste
