// Marks of every format.

#include "piste/io/marks.h"

#include <gtest/gtest.h>

#include <cmath>

#include "piste/core/error.h"
#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/receiver_logs.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

class Marks : public testing::Test {
 protected:
  std::vector<Mark> read(const std::string& name, const std::string& text, MarkFormat format,
                         std::optional<int> week = 2200) const {
    folder_.write(name, text);
    return read_marks({folder_ / name, format}, week, 302400);
  }
  TemporaryFolder folder_;
};

TEST_F(Marks, Csv) {
  const auto marks = read("a.csv", "name,time_s\nfirst,302400.25\n\"a, b\",302401\n", MarkFormat::kCsv);
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_EQ(marks[1].name, "a, b");
  EXPECT_EQ(marks[0].time, 302400.25);
  const auto dated = read("b.csv", "time_utc\n2022-03-09T11:59:42.25Z\n", MarkFormat::kCsv);
  EXPECT_EQ(dated[0].name, "mark_1");
  EXPECT_NEAR(dated[0].time, 302400.25, 1e-9);
  EXPECT_THROW(read("b.csv", "time_utc\n2022-03-09T11:59:42.25Z\n", MarkFormat::kCsv, {}), DataError);
  EXPECT_THROW(read("c.csv", "name\nfirst\n", MarkFormat::kCsv), DataError);
  EXPECT_THROW(read("d.csv", "time_s\nsoon\n", MarkFormat::kCsv), DataError);
  EXPECT_THROW(read("e.csv", "time_s\n", MarkFormat::kCsv), DataError);
}

TEST_F(Marks, Rtklib) {
  const auto marks =
      read("run_events.pos",
           "%  GPST          latitude(deg) longitude(deg)  height(m)   Q  ns   sdn(m)   sde(m)   sdu(m)\n"
           "2022/03/09 12:00:00.250   46.5 7.25 1500 1 12 0.01 0.01 0.02\n",
           MarkFormat::kRtklibPos);
  EXPECT_NEAR(marks.at(0).time, 302400.25, 1e-9);
}

TEST_F(Marks, Ubx) {
  const auto mark = [](std::uint8_t flags, std::uint16_t week) {
    Bytes payload(28);
    payload.put<std::uint8_t>(1, flags).put<std::uint16_t>(4, week);
    payload.put<std::uint32_t>(8, 302400250).put<std::uint32_t>(12, 250000);
    return ubx(0x0d, 0x03, payload.text());
  };
  // A rising edge; a falling one; one without a valid time; a rising one in UTC.
  const std::string log = mark(0xc8, 2200) + mark(0x4c, 2200) + mark(0x88, 2200) + mark(0xd0, 2200);
  const auto marks = read("a.ubx", log, MarkFormat::kUbx);
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_NEAR(marks[0].time, 302400.25025, 1e-9);
  EXPECT_NEAR(marks[1].time, 302418.25025, 1e-9);
  EXPECT_NEAR(read("a.ubx", log, MarkFormat::kUbx, {}).at(0).time, 302400.25025, 1e-9);
  EXPECT_NEAR(read("b.ubx", mark(0xc8, 2201), MarkFormat::kUbx).at(0).time, 604800 + 302400.25025, 1e-9);
}

TEST_F(Marks, Novatel) {
  const std::string head = ",COM1,0,83.5,FINESTEERING,2200,302400.300,02000000,0000,0;";
  const auto marks = read("a.log",
                          novatel("#MARKTIMEA" + head + "2200,302400.250000000,0.0,0.0,-18.0,VALID") +
                              novatel("#MARKPOSA" + head + "SOL_COMPUTED,NARROW_INT,46.5,7.25,1450.0"),
                          MarkFormat::kNovatel);
  ASSERT_EQ(marks.size(), 2u);
  EXPECT_NEAR(marks[0].time, 302400.25, 1e-9);
  EXPECT_NEAR(marks[1].time, 302400.3, 1e-9);
}

// A JPEG of an Exif segment alone, little-endian: DateTimeOriginal, SubSecTimeOriginal, OffsetTimeOriginal.
TEST_F(Marks, Exif) {
  const auto number = [](std::uint32_t value, int bytes) {
    std::string text;
    for (int i = 0; i < bytes; ++i) text += static_cast<char>(value >> (8 * i) & 0xff);
    return text;
  };
  const auto entry = [&](std::uint16_t tag, std::uint32_t count, const std::string& value) {
    return number(tag, 2) + number(2, 2) + number(count, 4) + value;
  };
  const std::string date = std::string("2022:03:09 12:59:42") + '\0', zone = std::string("+01:00") + '\0';
  std::string tiff = "II" + number(42, 2) + number(8, 4);
  tiff += number(1, 2) + number(0x8769, 2) + number(4, 2) + number(1, 4) + number(26, 4) + number(0, 4);
  tiff += number(3, 2);
  const std::uint32_t values = 26 + 2 + 3 * 12 + 4;
  tiff += entry(0x9003, 20, number(values, 4));
  tiff += entry(0x9011, 7, number(values + 20, 4));
  tiff += entry(0x9291, 3, std::string("25\0\0", 4));
  tiff += number(0, 4) + date + zone;
  const std::string segment = std::string("Exif\0\0", 6) + tiff;
  std::string jpeg = "\xff\xd8\xff\xe1";
  jpeg += static_cast<char>((segment.size() + 2) >> 8);
  jpeg += static_cast<char>((segment.size() + 2) & 0xff);
  jpeg += segment + "\xff\xd9";
  const auto marks = read("shot.jpg", jpeg, MarkFormat::kExif);
  EXPECT_EQ(marks.at(0).name, "shot.jpg");
  EXPECT_NEAR(marks[0].time, 302400.25, 1e-9);
  EXPECT_EQ(read_marks({folder_.path().string(), MarkFormat::kExif}, 2200, 0).size(), 1u);
  EXPECT_THROW(read("cut.jpg", jpeg.substr(0, 60), MarkFormat::kExif), DataError);
  EXPECT_THROW(read("none.jpg", "hello", MarkFormat::kExif), DataError);
}

TEST(ReceiverHeading, Ubx) {
  const TemporaryFolder folder;
  const auto baseline = [](std::uint32_t ms, std::uint32_t flags) {
    Bytes payload(64);
    payload.put<std::uint8_t>(0, 1).put<std::uint32_t>(4, ms).put<std::uint32_t>(60, flags);
    payload.put<std::int32_t>(8, 0).put<std::int32_t>(12, 100).put<std::int32_t>(16, -100);  // east and up
    payload.put<std::int32_t>(24, 9000000).put<std::uint32_t>(52, 50000).put<std::uint32_t>(44, 100);
    return ubx(0x01, 0x3c, payload.text());
  };
  folder.write("a.ubx", baseline(302400000, 0x101) + baseline(302400200, 0x1) + baseline(302400400, 0x101));
  const auto heading = read_heading({.file = folder / "a.ubx", .format = LogFormat::kUbx}, 0.01);
  ASSERT_EQ(heading.fixes.size(), 2u);
  EXPECT_DOUBLE_EQ(heading.fixes[1].time, 302400.4);
  EXPECT_NEAR(heading.fixes[0].heading, 90 * kDegree, 1e-12);
  EXPECT_NEAR(heading.fixes[0].sigma, 0.5 * kDegree, 1e-12);
  EXPECT_NEAR(*heading.fixes[0].pitch, 45 * kDegree, 1e-12);
  EXPECT_NEAR(heading.fixes[0].sigma_pitch, 0.01 / std::sqrt(2.0), 1e-12);
}

TEST(ReceiverHeading, Novatel) {
  const TemporaryFolder folder;
  const std::string head = "#HEADING2A,COM1,0,83.5,FINESTEERING,2200,302400.300,02000000,0000,0;";
  folder.write(
      "a.log",
      novatel(head + "SOL_COMPUTED,NARROW_INT,1.5,123.4,-2.5,0.0,0.4,0.8,\"AAAA\",\"BBBB\",12,12,12,0,3,01,0,33"));
  const auto heading = read_heading({.file = folder / "a.log", .format = LogFormat::kNovatel}, 0.01);
  ASSERT_EQ(heading.fixes.size(), 1u);
  EXPECT_DOUBLE_EQ(heading.fixes[0].time, 302400.3);
  EXPECT_NEAR(heading.fixes[0].heading, 123.4 * kDegree, 1e-12);
  EXPECT_NEAR(heading.fixes[0].sigma_pitch, 0.8 * kDegree, 1e-12);
}

TEST(ReceiverHeading, Nmea) {
  const TemporaryFolder folder;
  folder.write("a.nmea", nmea("GPRMC,115942.50,A,4630.0000,N,00715.0000,E,9.7,53.1,090322,,,R") +
                             nmea("GPHDT,123.4,T") +
                             nmea("GPRMC,115943.50,A,4630.0000,N,00715.0000,E,9.7,53.1,090322,,,R") +
                             nmea("GNTHS,124.4,A") + nmea("GNTHS,125.4,A") +
                             nmea("GPRMC,115944.50,A,4630.0000,N,00715.0000,E,9.7,53.1,090322,,,R") + nmea("GNTHS,,V"));
  const auto heading = read_heading({.file = folder / "a.nmea", .format = LogFormat::kNmea}, 0.01);
  ASSERT_EQ(heading.fixes.size(), 2u);
  EXPECT_DOUBLE_EQ(heading.fixes[1].time, 302401.5);
  EXPECT_NEAR(heading.fixes[1].heading, 124.4 * kDegree, 1e-12);
  EXPECT_DOUBLE_EQ(heading.fixes[0].sigma, 0.01);
  folder.write("b.nmea", nmea("GPRMC,115942.50,A,4630.0000,N,00715.0000,E,9.7,53.1,090322,,,R"));
  EXPECT_THROW(read_heading({.file = folder / "b.nmea", .format = LogFormat::kNmea}, 0.01), DataError);
}

}  // namespace
}  // namespace piste::test
