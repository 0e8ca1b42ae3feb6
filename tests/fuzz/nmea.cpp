// The reader of NMEA sentences, with sigmas of their own or with stated ones.

#include "checksum.h"
#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  LogFile log = fuzz::log_of(LogFormat::kNmea, data, size);
  if (size % 2 == 0) log.sigma = Vector3d(2, 2, 4);
  fuzz::both_ways(log, fuzz::gnss);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t largest,
                                               unsigned seed) {
  const auto sum = [](std::string_view body) {
    unsigned value = 0;
    for (const char c : body) value ^= static_cast<unsigned char>(c);
    return value;
  };
  return piste::fuzz::mutate(data, size, largest, seed,
                             [&](char* text, std::size_t length) { piste::fuzz::mend_lines(text, length, 2, sum); });
}
