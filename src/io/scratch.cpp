#include "piste/io/scratch.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <fstream>
#include <optional>
#include <system_error>
#include <utility>

#include "piste/core/error.h"

namespace piste {
namespace {

// A name that no other object has, here or in another program. Its end is that of the partial files of an output
// folder, which the next run removes where a program was killed.
std::filesystem::path new_place(const std::filesystem::path& folder) {
  static std::atomic<unsigned> count = 0;
  const auto now = std::chrono::high_resolution_clock::now().time_since_epoch().count();
  return folder / fmt::format(".scratch-{}-{}.piste.partial", now, count++);
}

}  // namespace

struct Scratch::Store {
  struct Extent {
    std::streamoff begin;
    std::size_t size;
  };
  std::filesystem::path place;                 // empty: in memory
  std::optional<std::fstream> file;            // opened with the first block
  std::vector<Extent> extents;                 // in the file
  std::vector<std::vector<std::byte>> blocks;  // in memory
  std::streamoff end = 0;

  explicit Store(std::filesystem::path folder) : place(std::move(folder)) {}
  Store(const Store&) = delete;
  Store& operator=(const Store&) = delete;
  ~Store() {
    if (!file) return;
    file->close();
    std::error_code ignored;  // its name may be gone already
    std::filesystem::remove(place, ignored);
  }

  // Where a file that is open can lose its name, it does, and no killed program leaves it behind.
  void open() {
    place = new_place(place);
    file.emplace(place, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
    if (!*file) throw Error(place.string(), "cannot be made: room is needed there for what a smoother keeps");
    std::error_code ignored;
    std::filesystem::remove(place, ignored);
  }
};

Scratch::Scratch(std::filesystem::path folder) : store_(std::make_shared<Store>(std::move(folder))) {}

std::size_t Scratch::add_bytes(std::span<const std::byte> bytes) {
  Store& s = *store_;
  if (s.place.empty()) {
    s.blocks.emplace_back(bytes.begin(), bytes.end());
    return s.blocks.size() - 1;
  }
  if (!s.file) s.open();
  s.file->seekp(s.end);
  s.file->write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  if (!*s.file) throw Error(s.place.parent_path().string(), "cannot hold what a smoother keeps: the disk may be full");
  s.extents.push_back({s.end, bytes.size()});
  s.end += static_cast<std::streamoff>(bytes.size());
  return s.extents.size() - 1;
}

std::size_t Scratch::bytes(std::size_t block) const {
  return store_->place.empty() ? store_->blocks[block].size() : store_->extents[block].size;
}

void Scratch::read_bytes(std::size_t block, std::span<std::byte> out) const {
  Store& s = *store_;
  if (s.place.empty()) {
    std::copy(s.blocks[block].begin(), s.blocks[block].end(), out.begin());
    return;
  }
  s.file->seekg(s.extents[block].begin);
  s.file->read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
  if (!*s.file) throw Error(s.place.parent_path().string(), "what a smoother kept there cannot be read");
}

}  // namespace piste
