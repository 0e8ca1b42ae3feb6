// The reader of NovAtel's positions, velocities and raw counts.

#include "checksum.h"
#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  LogFile log = fuzz::log_of(LogFormat::kNovatel, data, size);
  if (size % 2 == 0) log.sigma_velocity = Vector3d(0.1, 0.1, 0.2);
  fuzz::both_ways(log, fuzz::gnss);
  fuzz::both_ways(log, fuzz::imu);
  return 0;
}

extern "C" std::size_t LLVMFuzzerCustomMutator(std::uint8_t* data, std::size_t size, std::size_t largest,
                                               unsigned seed) {
  using namespace piste;
  return fuzz::mutate(data, size, largest, seed,
                      [](char* text, std::size_t length) { fuzz::mend_lines(text, length, 8, fuzz::novatel_crc); });
}
