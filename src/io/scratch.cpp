#include "io/scratch.h"

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

// Bytes that stay in memory before there is a file: a run of some minutes needs none.
constexpr std::size_t kInMemory = std::size_t{16} << 20U;

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
  std::filesystem::path folder, place;         // empty: in memory
  std::vector<std::vector<std::byte>> blocks;  // in memory: the first ones
  std::size_t in_memory = 0;
  std::optional<std::fstream> file;
  std::vector<Extent> extents;  // in the file: the others
  std::streamoff end = 0;

  explicit Store(std::filesystem::path where) : folder(std::move(where)) {}
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
    place = new_place(folder);
    file.emplace(place, std::ios::binary | std::ios::in | std::ios::out | std::ios::trunc);
    if (!*file) throw Error(place.string(), "cannot be written; a smoother needs room there");
    std::error_code ignored;
    std::filesystem::remove(place, ignored);
  }
};

Scratch::Scratch(std::filesystem::path folder) : store_(std::make_shared<Store>(std::move(folder))) {}

std::size_t Scratch::add_bytes(std::span<const std::byte> bytes) {
  Store& s = *store_;
  if (s.folder.empty() || (!s.file && s.in_memory + bytes.size() <= kInMemory)) {
    s.blocks.emplace_back(bytes.begin(), bytes.end());
    s.in_memory += bytes.size();
    return s.blocks.size() - 1;
  }
  if (!s.file) s.open();
  s.file->seekp(s.end);
  s.file->write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  s.file->flush();
  if (!*s.file) throw Error(s.folder.string(), "what a smoother needs cannot be written there; is the disk full?");
  s.extents.push_back({s.end, bytes.size()});
  s.end += static_cast<std::streamoff>(bytes.size());
  return s.blocks.size() + s.extents.size() - 1;
}

std::size_t Scratch::bytes(std::size_t block) const {
  const Store& s = *store_;
  return block < s.blocks.size() ? s.blocks[block].size() : s.extents[block - s.blocks.size()].size;
}

void Scratch::read_bytes(std::size_t block, std::span<std::byte> out) const {
  Store& s = *store_;
  if (block < s.blocks.size()) {
    std::copy(s.blocks[block].begin(), s.blocks[block].end(), out.begin());
    return;
  }
  s.file->seekg(s.extents[block - s.blocks.size()].begin);
  s.file->read(reinterpret_cast<char*>(out.data()), static_cast<std::streamsize>(out.size()));
  if (!*s.file) throw Error(s.folder.string(), "what a smoother has written there cannot be read");
}

}  // namespace piste
