// Sensor files: one that is taken can be written, and what is written is taken.

#include <string>

#include "piste/configuration/sensor_file.h"
#include "reader.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace piste;
  const auto sensor_of = [](const std::string& text) { return read_sensor(Config::parse(text, "sensor.yaml")); };
  ImuSensor sensor;
  try {
    sensor = sensor_of(std::string(fuzz::text_of(data, size)));
  } catch (const ConfigError&) {
    return 0;
  }
  const ImuSensor again = sensor_of(sensor_text(sensor));
  const auto alike = [](double a, double b) { return std::abs(a - b) <= 1e-15 * std::abs(a); };
  for (const auto triad : {&ImuSensor::gyro, &ImuSensor::accel}) {
    const TriadErrors &written = sensor.*triad, &read = again.*triad;
    fuzz::require(alike(written.noise, read.noise) && alike(written.bias, read.bias));
    fuzz::require(alike(written.scale, read.scale) && alike(written.range, read.range));
    fuzz::require(written.drift.kind == read.drift.kind);
  }
  fuzz::require(again.name == sensor.name);
  return 0;
}
