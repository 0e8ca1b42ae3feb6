#pragma once
/// Temporary storage of a run for data that does not fit in memory: blocks of values, each written once and read as
/// often as needed.

#include <cstddef>
#include <filesystem>
#include <memory>
#include <span>
#include <type_traits>
#include <vector>

namespace piste {

/// Blocks in memory, or in a file. A copy shares the same blocks. One thread at a time.
class Scratch {
 public:
  /// In memory; with a `folder`, beyond 16 MB in a file in it. The file is removed with the last copy, or when the
  /// program ends.
  explicit Scratch(std::filesystem::path folder);

  /// Adds a block and returns its number, counted from 0. Throws Error if the file cannot be made or written.
  template <class T>
  std::size_t add(std::span<const T> values) {
    static_assert(std::is_trivially_copyable_v<T>);
    return add_bytes(std::as_bytes(values));
  }
  /// Reads a block into `values`, which gets its size. Throws Error if the file cannot be read.
  template <class T>
  void read(std::size_t block, std::vector<T>& values) const {
    values.resize(bytes(block) / sizeof(T));
    read_bytes(block, std::as_writable_bytes(std::span(values)));
  }

 private:
  struct Store;
  std::size_t add_bytes(std::span<const std::byte> bytes);
  std::size_t bytes(std::size_t block) const;
  void read_bytes(std::size_t block, std::span<std::byte> out) const;
  std::shared_ptr<Store> store_;
};

}  // namespace piste
