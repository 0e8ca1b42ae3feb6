// The reader of u-blox frames.

#include "checksum.h"
#include "reader.h"

namespace {

// Of each frame that is not cut: two sums over its class, id, length and payload.
void mend_frames(char* text, std::size_t size) {
  constexpr std::size_t kHead = 6, kChecksum = 2;
  const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
  for (std::size_t i = 0; i + kHead + kChecksum <= size; ++i) {
    if (byte(i) != 0xB5 || byte(i + 1) != 0x62) continue;
    const std::size_t end = i + kHead + byte(i + 4) + 256U * byte(i + 5);
    if (end + kChecksum > size) continue;
    unsigned a = 0, b = 0;
    for (std::size_t k = i + 2; k < end; ++k) {
      a += byte(k);
      b += a;
    }
    text[end] = static_cast<char>(a & 0xFF);
    text[end + 1] = static_cast<char>(b & 0xFF);
    i = end + 1;
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  fuzz::both_ways(fuzz::log_of(LogFormat::kUbx, data, size), fuzz::gnss);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t largest,
                                               unsigned seed) {
  return piste::fuzz::mutate(data, size, largest, seed, mend_frames);
}
