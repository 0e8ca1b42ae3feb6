// The reader of RTKLIB's solutions.

#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  piste::fuzz::both_ways(piste::LogFormat::kRtklibPos, data, size, piste::fuzz::gnss);
  return 0;
}
