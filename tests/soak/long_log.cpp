// A replay of a log that is far larger than a ride: PISTE_SOAK_GB says how many gigabytes, a hundredth unless stated.
// The text is not held in memory; a sample is.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <cstdio>
#include <fstream>

#include "soak/endless_ride.h"
#include "support/program.h"

namespace piste::test {
namespace {

struct Written {
  std::size_t rows = 0, bytes = 0;
};

// Logs of about so many bytes.
Written write_logs(const TemporaryFolder& folder, double bytes) {
  EndlessRide ride(1000, 18);
  std::ofstream imu(folder / "imu.csv"), gnss(folder / "gnss.csv");
  imu << "time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2,accel_y_m_s2,accel_z_m_s2\n";
  gnss << "time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m\n";
  Written written;
  while (static_cast<double>(written.bytes) < bytes) {
    const ImuRow r = ride.row();
    const std::string text = fmt::format("{:.6f},{:.9f},{:.9f},{:.9f},{:.8f},{:.8f},{:.8f}\n", r.time, r.gyro.x(),
                                         r.gyro.y(), r.gyro.z(), r.accel.x(), r.accel.y(), r.accel.z());
    imu << text;
    written.bytes += text.size();
    ++written.rows;
    if (const auto fix = ride.fix()) {
      gnss << fmt::format("{:.6f},{:.10f},{:.10f},{:.4f},{},{},{}\n", fix->time,
                          fix->position.latitude * kDegreesPerRadian, fix->position.longitude * kDegreesPerRadian,
                          fix->position.height, EndlessRide::kWhite, EndlessRide::kWhite, EndlessRide::kWhite);
    }
  }
  return written;
}

// The largest memory that a program of this test had, in bytes.
double largest_program() {
  rusage usage{};
  getrusage(RUSAGE_CHILDREN, &usage);
  return 1024 * static_cast<double>(usage.ru_maxrss);
}

TEST(Soak, ReplayOfALongLog) {
  constexpr double kGiga = 1e9, kBytesARow = 220, kAnyway = 300e6;  // 200 a row were measured on 1 GB
  const TemporaryFolder folder;
  const Written log = write_logs(folder, stated("PISTE_SOAK_GB", 0.01) * kGiga);
  folder.write("sensor.yaml", read_text(kSource / "config/sensors/xsens_mt9a.yaml"));
  folder.write("run.yaml",
               "imu: {file: imu.csv, sensor: sensor.yaml, sampling: instant}\n"
               "gnss: {file: gnss.csv, lever_arm: 0 0 -0.4 m}\n"
               "estimate: [gyro_bias, accel_bias, gyro_drift, accel_drift, gyro_scale, accel_scale]\n"
               "smoother: none\noutput: {rate: 1 Hz}\n");
  const auto begin = std::chrono::steady_clock::now();
  const Said said = run_program(program("replay"), {"run.yaml", "--output", "result", "--quiet"}, folder, "true", 7200);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_EQ(said.code, 0) << said.err;
  const auto rows = static_cast<double>(log.rows);
  fmt::print("figure: a log of {:.2f} GB, {:.0f} rows: {:.1f} GB of memory, {:.0f} s\n",
             static_cast<double>(log.bytes) / kGiga, rows, largest_program() / kGiga, took.count());
  EXPECT_LT(largest_program(), kAnyway + kBytesARow * rows);
  EXPECT_TRUE(contains(read_text(folder / "result/summary.json"), "\"verdict\": {\n    \"consistent\": true"));
}

}  // namespace
}  // namespace piste::test
