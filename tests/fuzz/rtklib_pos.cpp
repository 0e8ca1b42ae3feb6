// The reader of RTKLIB's solutions.

#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  fuzz::both_ways(fuzz::log_of(LogFormat::kRtklibPos, data, size), fuzz::gnss);
  return 0;
}
