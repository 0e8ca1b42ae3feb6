#pragma once
/// Mutations that leave checksums right: behind a wrong one, nothing of a record would be tried.

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <string>
#include <string_view>

extern "C" std::size_t LLVMFuzzerMutate(std::uint8_t* data, std::size_t size, std::size_t largest);

namespace piste::fuzz {

/// Mutates as the fuzzer does; then `mend(char*, size)` writes what checksums should be, but for one time in eight.
template <class Mend>
std::size_t mutate(std::uint8_t* data, std::size_t size, std::size_t largest, unsigned seed, Mend&& mend) {
  const std::size_t mutated = LLVMFuzzerMutate(data, size, largest);
  if (seed % 8 != 0) mend(reinterpret_cast<char*>(data), mutated);
  return mutated;
}

/// Of each line `$body*…` that has room for them, the hexadecimal digits of `sum(body)` behind the star.
template <class Sum>
void mend_lines(char* text, std::size_t size, int digits, Sum&& sum) {
  for (char *line = text, *const end = text + size; line < end;) {
    char* const next = std::find(line, end, '\n');
    char* const star = std::find(std::min(line + 1, next), next, '*');
    if (next - star > digits) {
      char hex[9];
      std::snprintf(hex, sizeof hex, "%0*X", digits,
                    sum(std::string_view(line + 1, static_cast<std::size_t>(star - line - 1))));
      std::copy_n(hex, digits, star + 1);
    }
    line = next == end ? end : next + 1;
  }
}

/// CRC-32 as NovAtel has it: from 0, not inverted.
inline unsigned novatel_crc(std::string_view body) {
  unsigned value = 0;
  for (const char c : body) {
    value ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1) ^ ((value & 1) != 0 ? 0xEDB88320U : 0U);
  }
  return value;
}

}  // namespace piste::fuzz
