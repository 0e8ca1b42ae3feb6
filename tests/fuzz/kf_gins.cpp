// The kf_gins reader: the same bytes as an IMU and as a receiver.

#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  fuzz::both_ways(LogFormat::kKfGins, data, size, fuzz::imu);
  fuzz::both_ways(LogFormat::kKfGins, data, size, fuzz::gnss);
  return 0;
}
