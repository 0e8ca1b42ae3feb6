#include <gtest/gtest.h>

#include <limits>

#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/receiver_logs.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::imr_header;
using test::imr_record;
using test::kXsensHeader;
using test::message_of;
using test::xsens_row;
using Kind = RowFault::Kind;

ImuRecording imu_of(const std::string& text, LogFormat format, RowFaults* faults = nullptr,
                    const std::vector<std::string>& ignored = {}) {
  return read_imu({.file = "log", .format = format, .ignore_columns = ignored, .content = text}, faults);
}
std::string refused(const std::string& text, LogFormat format, const std::vector<std::string>& ignored = {}) {
  return message_of<DataError>([&] { imu_of(text, format, nullptr, ignored); });
}

// ---- xsens_ascii ----

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST(Xsens, CounterThatWrapsAndSkipsIsTheTime) {
  const auto imu =
      imu_of(kXsensHeader + xsens_row(65534) + xsens_row(65535) + xsens_row(0) + xsens_row(10), LogFormat::kXsensAscii);
  EXPECT_EQ(imu.time, (std::vector<double>{0, 0.02, 0.04, 0.24}));
  EXPECT_FALSE(imu.increments);
  EXPECT_EQ(imu.accel[3], Vector3d(0.1, -0.2, 9.8));
  EXPECT_EQ(imu.gyro[3], Vector3d(0.01, -0.02, 0.03));
  EXPECT_EQ(imu.magnetic[3], Vector3d(0.5, 0.1, -0.8));
  EXPECT_TRUE(imu.temperature.empty());
}

TEST(Xsens, OtherHeaders) {
  const auto imu = imu_of(
      "// Update Rate: 100.0Hz\r\nPacketCounter\tGyr_X\tGyr_Y\tGyr_Z\tAcc_X\tAcc_Y\tAcc_Z\tTemperature\tRoll\tMine\r\n"
      "7\t1\t2\t3\t0\t0\t9.8\t21.5\t\tx\r\n8\t1\t2\t3\t0\t0\t9.8\t21.5\t0\tx\r\n",
      LogFormat::kXsensAscii, nullptr, {"Mine"});
  EXPECT_EQ(imu.time, (std::vector<double>{0, 0.01}));
  EXPECT_EQ(imu.gyro[0], Vector3d(1, 2, 3));
  EXPECT_EQ(imu.temperature[1], 21.5);
  EXPECT_TRUE(imu.magnetic.empty());
}

TEST(Xsens, Refusals) {
  const std::string first = kXsensHeader + xsens_row(100);
  const std::pair<std::string, const char*> cases[] = {
      {"", "holds no line of column names"},
      {"// Sample rate: 50.0Hz\n", "holds no line of column names"},
      {replaced(kXsensHeader, "// Sample rate: 50.0Hz\n", ""), "log:4: no rate stands above the columns; add the line"},
      {replaced(kXsensHeader, "50.0Hz", "fast"), "log:2: `fast` is no rate"},
      {replaced(kXsensHeader, "50.0Hz", "0"), "log:2: `0` is no rate"},
      {replaced(kXsensHeader, "50.0Hz", "1e-308"), "log:2: `1e-308` is no rate"},
      {replaced(kXsensHeader, "50.0Hz", ""), "log:2: `` is no rate"},
      {replaced(kXsensHeader, "Counter", "Count"), "log:5: column Counter or PacketCounter is missing"},
      {replaced(kXsensHeader, "Gyr_Y", "Mat[1]"), "log:5: column Gyr_Y is missing"},
      {replaced(kXsensHeader, "Quat_w", "Mine"), "log:5: unknown column `Mine`; name it in `ignore_columns`"},
      {replaced(kXsensHeader, "Quat_x", "Quat_w"), "log:5: column `Quat_w` stands twice"},
      {first + xsens_row(100), "log:7: the counter stands still at 100"},
      {first + xsens_row(99), "log:7: the counter goes back from 100 to 99"},
      {first + xsens_row(65537), "log:7: counter `65537`"},
      {first + replaced(xsens_row(101), "00101", "101.5"), "log:7: counter `101.5`"},
      {first + "101\t0.1\t-0.2\n", "log:7: 3 fields, but 14 columns are named; is the line cut?"},
      {first + replaced(xsens_row(101), "0.03", "x"), "log:7: field 7, `x`, is no number"},
      {first + replaced(xsens_row(101), "0.03", ""), "log:7: field 7, ``, is no number"},
      {first + replaced(xsens_row(101), "0.03", "nan"), "log:7: field 7, `nan`, must be finite"},
      {first + replaced(xsens_row(101), "0.03", "120"), "log:7: an angular rate of 120 rad/s"},
      {first, "holds fewer than two IMU rows"},
  };
  for (const auto& [text, expected] : cases) {
    EXPECT_TRUE(contains(refused(text, LogFormat::kXsensAscii), expected)) << text;
  }
  EXPECT_TRUE(
      contains(refused(first, LogFormat::kXsensAscii, {"Other"}), "log:5: there is no column `Other` to ignore"));
}

TEST(Xsens, ListsWhatItRefusesWhereAsked) {
  RowFaults faults;
  const auto imu = imu_of(kXsensHeader + xsens_row(100) + xsens_row(100) + xsens_row(99) +
                              replaced(xsens_row(101), "0.03", "x") + xsens_row(102),
                          LogFormat::kXsensAscii, &faults);
  EXPECT_EQ(imu.time, (std::vector<double>{0, 0.04}));
  EXPECT_EQ(faults.count(Kind::kTimeRepeated), 1u);
  EXPECT_EQ(faults.count(Kind::kTimeBack), 1u);
  EXPECT_EQ(faults.count(Kind::kText), 1u);
  EXPECT_EQ(faults.total(), 3u);
}

// ---- imr ----

TEST(Imr, RatesOfBothByteOrders) {
  for (const std::endian order : {std::endian::little, std::endian::big}) {
    const auto imu = imu_of(imr_header(order).text() + imr_record(604799.995, 100000, -9800, order) +
                                imr_record(0.005, 200000, -9800, order),
                            LogFormat::kImr);
    EXPECT_FALSE(imu.increments);
    EXPECT_EQ(imu.time.at(0), 604799.995);
    EXPECT_NEAR(imu.time.at(1), 604800.005, 1e-9);
    EXPECT_TRUE(imu.gyro[1].isApprox(Vector3d(0, 0, 20 * kDegree)));
    EXPECT_TRUE(imu.accel[1].isApprox(Vector3d(0, 0, -9.8)));
  }
}

TEST(Imr, AxesStandInTheirOrder) {
  test::Bytes record(32);
  record.put<double>(0, 1);
  for (std::int32_t i = 0; i < 6; ++i) record.put<std::int32_t>(8 + 4 * static_cast<std::size_t>(i), 1000 * (i + 1));
  const std::string first = record.text(), second = record.put<double>(0, 1.01).text();
  const auto imu = imu_of(imr_header().text() + first + second, LogFormat::kImr);
  EXPECT_TRUE(imu.gyro[0].isApprox(Vector3d(0.1, 0.2, 0.3) * kDegree));
  EXPECT_TRUE(imu.accel[0].isApprox(Vector3d(4, 5, 6)));
}

TEST(Imr, IncrementsAndWhatIsHalfThem) {
  const auto read = [](std::int32_t theta, std::int32_t velocity, std::int32_t accel) {
    return imu_of(imr_header().put<std::int32_t>(17, theta).put<std::int32_t>(21, velocity).text() +
                      imr_record(1, 100, accel) + imr_record(1.01, 100, accel),
                  LogFormat::kImr);
  };
  const auto both = read(1, 1, -98);
  EXPECT_TRUE(both.increments);
  EXPECT_TRUE(both.gyro[1].isApprox(Vector3d(0, 0, 0.01 * kDegree)));
  EXPECT_TRUE(both.accel[1].isApprox(Vector3d(0, 0, -0.098)));
  const auto rotation = read(1, 0, -9800);
  EXPECT_FALSE(rotation.increments);
  EXPECT_TRUE(rotation.gyro[1].isApprox(Vector3d(0, 0, 1 * kDegree)));
  EXPECT_TRUE(rotation.accel[1].isApprox(Vector3d(0, 0, -9.8)));
  const auto velocity = read(0, 1, -98);
  EXPECT_FALSE(velocity.increments);
  EXPECT_TRUE(velocity.gyro[1].isApprox(Vector3d(0, 0, 0.01 * kDegree)));
  EXPECT_TRUE(velocity.accel[1].isApprox(Vector3d(0, 0, -9.8)));
}

TEST(Imr, Refusals) {
  const std::string header = imr_header().text(), first = imr_record(1, 0, -9800), second = imr_record(1.01, 0, -9800);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [&](std::size_t offset, auto value) {
    return imr_header().put(offset, value).text() + first + second;
  };
  const std::pair<std::string, const char*> cases[] = {
      {"time_s,gyro\n", "log: byte 0: the file does not begin with $IMURAW"},
      {"", "log: byte 0: the file does not begin"},
      {header.substr(0, 500), "log: byte 0: the header of 512 bytes is cut"},
      {header, "holds fewer than two IMU rows"},
      {with(8, std::int8_t{2}), "log: byte 8: 2 stands for byte order"},
      {with(17, std::int32_t{7}), "log: byte 17: 7 stands for bDeltaTheta"},
      {with(21, std::int32_t{-1}), "log: byte 21: -1 stands for bDeltaVelocity"},
      {with(25, 0.0), "log: byte 25: dDataRateHz"},
      {with(33, 0.0), "log: byte 33: dGyroScaleFactor is 0; a number above zero"},
      {with(41, nan), "log: byte 41: dAccelScaleFactor is nan"},
      {with(49, std::int32_t{1}), "log: byte 49: the time tags are UTC"},
      {with(49, std::int32_t{3}), "log: byte 49: 3 stands for iUtcOrGpsTime"},
      {with(57, 13.0), "log: byte 57: a time-tag bias of 13 s"},
      {header + first + second + second.substr(0, 31), "log: byte 576: the last record is cut: 31 of 32 bytes"},
      {header + first + first, "log: byte 544: time 1.000000 s does not increase"},
      {header + second + first, "log: byte 544: time 1.000000 s does not increase"},
      {header + imr_record(nan, 0, 0), "log: byte 512: the time is not finite"},
      {header + imr_record(1, 400000000, 0), "log: byte 512: an angular rate of 698.1 rad/s"},
      {with(33, 1e308) + imr_record(2, 1 << 30, 0), "log: byte 576: a value is not finite"},
      {with(25, 200.0) + imr_record(1.02, 0, -9800),
       "log: byte 25: the header says 200 Hz, but the records are 0.010000 s"},
  };
  for (const auto& [text, expected] : cases) EXPECT_TRUE(contains(refused(text, LogFormat::kImr), expected));
}

TEST(Imr, ListsWhatItRefusesWhereAsked) {
  const std::string record = imr_record(1, 0, -9800);
  RowFaults faults;
  const auto imu =
      imu_of(imr_header().text() + record + record + imr_record(1.01, 0, -9800) + "cut", LogFormat::kImr, &faults);
  EXPECT_EQ(imu.time, (std::vector<double>{1, 1.01}));
  EXPECT_EQ(faults.count(Kind::kTimeRepeated), 1u);
  EXPECT_EQ(faults.count(Kind::kFields), 1u);
  EXPECT_EQ(faults.first[1].place, 608u);
}

}  // namespace
}  // namespace piste
