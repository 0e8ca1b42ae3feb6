#pragma once
/// Reads numbers from bytes of either byte order.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <string_view>

namespace piste::log_formats {

/// The number at `offset`. @pre `offset` + sizeof(T) is within `bytes`
template <class T>
T number_at(std::string_view bytes, std::size_t offset, std::endian order = std::endian::little) {
  std::array<char, sizeof(T)> copy;
  std::copy_n(bytes.begin() + static_cast<std::ptrdiff_t>(offset), sizeof(T), copy.begin());
  if (order != std::endian::native) std::reverse(copy.begin(), copy.end());
  return std::bit_cast<T>(copy);
}

}  // namespace piste::log_formats
