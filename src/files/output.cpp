#include "piste/files/output.h"

#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <set>
#include <system_error>
#include <utility>

#include "files/folder_lock.h"
#include "piste/core/error.h"

namespace piste {
namespace {

constexpr std::string_view kPartial = ".piste.partial";

// What no other object has, here or in another program or container. Without a dot.
std::string new_owner() {
  static std::atomic<unsigned> count = 0;
  const auto now = std::chrono::system_clock::now().time_since_epoch().count();
  return fmt::format("{}-{}-{}", getpid(), now, count++);
}

std::string partial_name(const std::string& name, const std::string& owner) {
  return fmt::format(".{}.{}{}", name, owner, kPartial);
}

// The lock that an owner holds in each folder where it has partial files.
std::string lock_name(const std::string& owner) { return partial_name("lock", owner); }

// A partial file whose owner no longer lives.
bool is_left_over(const std::filesystem::path& file) {
  std::string name = file.filename().string();
  if (!name.ends_with(kPartial)) return false;
  name.resize(name.size() - kPartial.size());
  return !FolderLock::is_held(file.parent_path() / lock_name(name.substr(name.rfind('.') + 1)));
}

void remove_left_over(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> left;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.is_regular_file() && is_left_over(entry.path())) left.push_back(entry.path());
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

OutputFolder::OutputFolder(std::filesystem::path folder) : folder_(std::move(folder)), owner_(new_owner()) {
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
  locks_.clear();
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
  if (auto& owned = locks_[place.parent_path()]; !owned) {
    const CommitLock alone(folder_);  // which might remove the lock's file before it is held
    owned = std::make_unique<FolderLock>(place.parent_path() / lock_name(owner_));
  }
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
  return place.parent_path() / partial_name(place.filename().string(), owner_);
}

void OutputFolder::withdraw(const std::string& name) { withdrawn_.push_back(folder_ / name); }

void OutputFolder::commit() {
  const std::lock_guard lock(folders().mutex);
  const CommitLock alone(folder_);
  for (const Pending& p : pending_) {
    if (std::filesystem::is_directory(p.place)) throw Error(p.place.string(), "is a folder; a file is to stand here");
  }
  if (pending_.size() > 1) std::filesystem::remove(pending_.back().place);
  for (const auto& file : withdrawn_) std::filesystem::remove(file);
  for (const Pending& p : pending_) std::filesystem::rename(p.partial, p.place);
  for (const auto& owned : locks_) remove_left_over(owned.first);
  pending_.clear();
  made_.clear();
}

}  // namespace piste
