#include "piste/files/output.h"

#include <fmt/format.h>

#include <set>
#include <system_error>
#include <utility>

#include "piste/core/error.h"

namespace piste {
namespace {

constexpr std::string_view kPartial = ".piste.partial";

void remove_partial_files(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file() && entry.path().filename().string().ends_with(kPartial)) left.push_back(entry.path());
  }
  for (const auto& file : left) std::filesystem::remove(file);
}

// All living folders, and the mutex that guards this list and their pending files.
struct Folders {
  std::mutex mutex;
  std::set<OutputFolder*> all;
};

Folders& folders() {
  static Folders folders;
  return folders;
}

}  // namespace

OutputFolder::OutputFolder(std::filesystem::path folder) : folder_(std::move(folder)) {
  const std::lock_guard lock(folders().mutex);
  make(folder_);
  folders().all.insert(this);
}

OutputFolder::~OutputFolder() {
  const std::lock_guard lock(folders().mutex);
  folders().all.erase(this);
  abandon();
}

std::unique_lock<std::mutex> OutputFolder::abandon_all() {
  std::unique_lock lock(folders().mutex);
  for (OutputFolder* folder : folders().all) folder->abandon();
  return lock;
}

void OutputFolder::abandon() {
  std::error_code ignored;
  for (const Pending& p : pending_) std::filesystem::remove(p.partial, ignored);
  // The innermost folder first; a folder that has other files stays.
  for (auto folder = made_.rbegin(); folder != made_.rend(); ++folder) std::filesystem::remove(*folder, ignored);
}

void OutputFolder::make(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> missing;
  for (auto f = std::filesystem::absolute(folder).lexically_normal(); !f.empty() && !std::filesystem::exists(f);
       f = f.parent_path()) {
    missing.insert(missing.begin(), f);
  }
  for (const auto& f : missing) {
    std::error_code error;
    if (std::filesystem::create_directory(f, error)) made_.push_back(f);
    if (error)
      throw ConfigError(folder.string(), fmt::format("cannot be made ({}); choose another --output", error.message()));
  }
  if (!std::filesystem::is_directory(folder))
    throw ConfigError(folder.string(), "is no folder; choose another --output");
}

void OutputFolder::write(const std::string& name, std::string_view content) {
  stream(name, [content](const TextSink& sink) { sink(content); });
}

OutputFile::OutputFile(std::filesystem::path place, const std::filesystem::path& partial)
    : place_(std::move(place)), file_(partial, std::ios::binary | std::ios::trunc) {}

void OutputFile::write(std::string_view piece) {
  file_.write(piece.data(), static_cast<std::streamsize>(piece.size()));
}

void OutputFile::close() {
  file_.close();
  if (!file_) throw Error(place_.string(), "cannot be written; is the disk full, or the folder read-only?");
}

OutputFile OutputFolder::open(const std::string& name) {
  const std::lock_guard lock(folders().mutex);
  const std::filesystem::path place = folder_ / name;
  make(place.parent_path());
  const std::filesystem::path unfinished = partial(name);
  // A file that is written again is one file.
  const bool again = std::any_of(pending_.begin(), pending_.end(), [&](const Pending& p) { return p.place == place; });
  if (!again) pending_.push_back({unfinished, place});
  return {place, unfinished};
}

void OutputFolder::stream(const std::string& name, const std::function<void(const TextSink&)>& pieces) {
  OutputFile file = open(name);
  pieces([&file](std::string_view piece) { file.write(piece); });
  file.close();
}

std::filesystem::path OutputFolder::partial(const std::string& name) const {
  const std::filesystem::path place = folder_ / name;
  return place.parent_path() / fmt::format(".{}{}", place.filename().string(), kPartial);
}

void OutputFolder::withdraw(const std::string& name) { withdrawn_.push_back(folder_ / name); }

void OutputFolder::commit() {
  const std::lock_guard lock(folders().mutex);
  for (const Pending& p : pending_) {
    if (std::filesystem::is_directory(p.place)) throw Error(p.place.string(), "is a folder; a file is to stand here");
  }
  if (pending_.size() > 1) std::filesystem::remove(pending_.back().place);
  for (const auto& file : withdrawn_) std::filesystem::remove(file);
  std::set<std::filesystem::path> written;
  for (const Pending& p : pending_) {
    std::filesystem::rename(p.partial, p.place);
    written.insert(p.place.parent_path());
  }
  for (const auto& folder : written) remove_partial_files(folder);
  pending_.clear();
  made_.clear();
}

}  // namespace piste
