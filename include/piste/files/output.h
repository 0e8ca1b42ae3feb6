#pragma once
/// Writes output files so that each appears whole or not at all.

#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "piste/io/text_sink.h"

namespace piste {

class FolderLock;

/// A file of an OutputFolder that is being written.
class OutputFile {
 public:
  void write(std::string_view piece);
  /// Throws Error if something could not be written.
  void close();

 private:
  friend class OutputFolder;
  OutputFile(std::filesystem::path place, const std::filesystem::path& partial);
  std::filesystem::path place_;
  std::ofstream file_;
};

/// The output folder of one run. Each file is first written as `.NAME.OWNER.piste.partial`; `commit()` gives all files
/// their names. Without `commit()` nothing remains, not even the folder if this object made it.
///
/// If the program is killed before `commit()`, the files of an earlier run are untouched, and the next run removes the
/// partial files. If it is killed within `commit()`, all files are whole, but some may be of the earlier run, and the
/// file that was written last is missing. So if that file exists, all files are of one run. If the machine itself
/// fails, more may be lost: nothing is forced to the disk.
///
/// Several programs may write into one folder at the same time. Where they write the same files, all of them are of the
/// program that commits last.
class OutputFolder {
 public:
  /// Makes the folder. Throws ConfigError if that is not possible.
  explicit OutputFolder(std::filesystem::path folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Writes a partial file. `name` is relative to the folder and may be in a subfolder. Throws Error if the file cannot
  /// be written.
  void write(const std::string& name, std::string_view content);
  /// The same for a file whose text comes piece by piece from `pieces`.
  void stream(const std::string& name, const std::function<void(const TextSink&)>& pieces);
  /// Opens a partial file that is written during a run; it is whole after close(). Throws as write().
  OutputFile open(const std::string& name);
  /// Path of a file of this run until commit() gives it its name.
  std::filesystem::path partial(const std::string& name) const;
  /// Names a file that an earlier run may have left and this run does not write: `commit()` removes it.
  void withdraw(const std::string& name);
  /// Renames all partial files in the order in which they were written, and removes those that killed runs left.
  void commit();

  /// Removes the partial files of all folders of this program, as their destructors would, before the program ends.
  /// While the returned lock lives, no folder can open a file, commit or be destroyed. A commit in progress is waited
  /// for.
  static std::unique_lock<std::mutex> abandon_all();

  const std::filesystem::path& folder() const { return folder_; }

 private:
  struct Pending {
    std::filesystem::path partial, place;
  };
  void make(const std::filesystem::path& folder);
  void abandon();
  std::filesystem::path folder_;
  std::string owner_;                                                   // in the names of its partial files
  std::map<std::filesystem::path, std::unique_ptr<FolderLock>> locks_;  // of folders in which it has opened files
  std::vector<std::filesystem::path> made_;
  std::vector<Pending> pending_;
  std::vector<std::filesystem::path> withdrawn_;
};

}  // namespace piste
