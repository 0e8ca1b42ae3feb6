// The reader of NovAtel's attitudes, with sigmas of their own or with stated ones.

#include "checksum.h"
#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  LogFile log = fuzz::log_of(LogFormat::kInspva, data, size);
  if (size % 2 == 0) log.sigma = Vector3d(0.001, 0.001, 0.002);
  fuzz::both_ways(log, fuzz::attitude);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t largest,
                                               unsigned seed) {
  using namespace piste;
  return fuzz::mutate(data, size, largest, seed,
                      [](char* text, std::size_t length) { fuzz::mend_lines(text, length, 8, fuzz::novatel_crc); });
}
