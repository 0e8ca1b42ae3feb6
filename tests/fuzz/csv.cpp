// The csv reader: the same bytes as an IMU, as a receiver and as attitudes.

#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  const LogFile log = fuzz::log_of(LogFormat::kCsv, data, size);
  fuzz::both_ways(log, fuzz::imu);
  fuzz::both_ways(log, fuzz::gnss);
  fuzz::both_ways(log, fuzz::attitude);
  return 0;
}
