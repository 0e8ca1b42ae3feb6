// The csv reader: the same bytes as an IMU, as a receiver and as attitudes.

#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  fuzz::both_ways(LogFormat::kCsv, data, size, fuzz::imu);
  fuzz::both_ways(LogFormat::kCsv, data, size, fuzz::gnss);
  fuzz::both_ways(LogFormat::kCsv, data, size, fuzz::attitude);
  return 0;
}
