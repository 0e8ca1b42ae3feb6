// The kf_gins reader: the same bytes as an IMU and as a receiver.

#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  const LogFile log = fuzz::log_of(LogFormat::kKfGins, data, size);
  fuzz::both_ways(log, fuzz::imu);
  fuzz::both_ways(log, fuzz::gnss);
  return 0;
}
