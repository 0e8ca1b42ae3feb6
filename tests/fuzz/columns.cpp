// The reader of tables with names of their own: bytes as an IMU in one file, as a receiver or as attitudes, with
// several mappings, and with rows put in order.

#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  LogFile log = fuzz::log_of(LogFormat::kColumns, data, size);
  const unsigned choice = size == 0 ? 0 : data[size - 1];  // the last byte chooses
  constexpr TimeScale kScales[] = {TimeScale::kBoot, TimeScale::kGpsWeek, TimeScale::kGps, TimeScale::kUtc};
  ColumnMap map;
  map.time = {"t", choice % 5 == 4 ? "calendar" : "ms", kScales[choice % 4], "", ""};
  if (choice % 5 == 4) map.time.of = TimeScale::kUtc;
  log.repair = choice % 3 == 0;
  switch (choice % 4) {
    case 0:
      map.uses["gyro"] = {{"gx", "gy", "gz"}, "", {}, {}};
      map.uses["accel"] = {{"5", "6", "7"}, "m/s^2", {}, {}};
      break;
    case 1:
      map.uses["dtheta"] = {{"2", "3", "4"}, "rad", {}, {}};
      map.uses["dvel"] = {{"5", "6", "7"}, "m/s", {}, {}};
      map.uses["temperature"] = {{"8"}, "degC", {}, {}};
      break;
    case 2:
      map.uses["latitude"] = {{"lat"}, "deg", {}, {}};
      map.uses["longitude"] = {{"lon"}, "deg", {}, {}};
      map.uses["height"] = {{"h"}, "m", {}, {}};
      map.uses["horizontal_accuracy"] = {{"ha"}, "m", {}, {}};
      map.uses["vertical_accuracy"] = {{"va"}, "m", {}, {}};
      map.uses["speed"] = {{"v"}, "m/s", {}, {}};
      map.uses["course"] = {{"c"}, "deg", {}, {}};
      map.uses["speed_accuracy"] = {{"sa"}, "m/s", {}, {}};
      break;
    default:
      map.uses["angles"] = {{"2", "3", "4"}, "deg", {}, {}};
      log.sigma = Vector3d(1, 1, 1);
  }
  log.columns = map;
  if (choice % 4 < 2) {
    fuzz::both_ways(log, fuzz::imu);
  } else if (choice % 4 == 2) {
    fuzz::both_ways(log, fuzz::gnss);
  } else {
    fuzz::both_ways(log, fuzz::attitude);
  }
  return 0;
}
