// The reader of Inertial Explorer's generic IMU format.

#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  fuzz::both_ways(fuzz::log_of(LogFormat::kImr, data, size), fuzz::imu);
  return 0;
}
