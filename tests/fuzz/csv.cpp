// The csv reader: bytes as an IMU, as a receiver or as attitudes, by the columns that they name.

#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  const LogFile log = fuzz::log_of(LogFormat::kCsv, data, size);
  const auto names = [&](std::string_view column) { return log.content->find(column) != std::string_view::npos; };
  if (names("gyro")) {
    fuzz::both_ways(log, fuzz::imu);
  } else if (names("latitude")) {
    fuzz::both_ways(log, fuzz::gnss);
  } else {
    fuzz::both_ways(log, fuzz::attitude);
  }
  return 0;
}
