// What each format says of one row. read_back.py reads whole runs back with other programs.

#include "piste/exports/exports.h"

#include <gtest/gtest.h>

#include "exports/formats.h"
#include "piste/core/error.h"
#include "piste/math/units.h"

namespace piste {
namespace {

// One row at the end of GPS week 2200; 18 leap seconds.
ExportRun one_row(double latitude = 46.5, double longitude = -7.25) {
  ExportRun run;
  run.track.file = "smoothed.csv";
  run.track.time = {302400.5};
  run.track.place = {{latitude * kDegree, longitude * kDegree, 1500}};
  run.track.velocity = {{3, 4, -1}};
  run.track.attitude = {from_euler({0, 0, kDegree * 90})};
  run.track.sigma_position = run.track.sigma_velocity = {{0.1, 0.2, 0.3}};
  run.track.sigma_euler = {kDegree * Vector3d(0.1, 0.2, 0.5)};
  run.table = {.names = {"time_s"}, .values = {302400.5}};
  run.week = 2200;
  return run;
}

std::string text_of(const ExportRun& run, ExportFormat format) { return exported(run, format).front().content; }

void expect_says(const std::string& text, const std::string& what) {
  EXPECT_NE(text.find(what), std::string::npos) << text;
}

TEST(Exports, GpxIsAboveTheSea) {
  const std::string text = text_of(one_row(), ExportFormat::kGpx);
  expect_says(text, "lat=\"46.5000000000\" lon=\"-7.2500000000\"");
  expect_says(text, "<time>2022-03-09T11:59:42.500000Z</time>");
  expect_says(text, "<geoidheight>4");  // 48 m in Galicia
  EXPECT_EQ(text.find("<ele>1500"), std::string::npos);
}

TEST(Exports, GeojsonIsOneLine) {
  const std::string text = text_of(one_row(), ExportFormat::kGeojson);
  expect_says(text, "[-7.2500000000,46.5000000000,1500.0000]");
  expect_says(text, "\"coordTimes\": [\n\"2022-03-09T11:59:42.500000Z\"]");
}

TEST(Exports, NmeaHasMinutes) {
  const std::string text = text_of(one_row(-46.5, 179.99999999999), ExportFormat::kNmea);
  expect_says(text, "$GPGGA,115942.500000,4630.0000000,S,18000.0000000,E,1,,,");
  expect_says(text, "$GPRMC,115942.500000,A,");
  expect_says(text, ",9.7192,53.1301,090322,,,A*");
}

// Heading east: forward is along x, right is south, down is down.
TEST(Exports, PosesAreInEastNorthUp) {
  expect_says(text_of(one_row(), ExportFormat::kKitti),
              "1.000000000000 0.000000000000 0.000000000000 0.000000 0.000000000000 -1.000000000000");
  expect_says(text_of(one_row(), ExportFormat::kEuroc), "\n302400500000000,0.000000,");
  EXPECT_EQ(exported(one_row(), ExportFormat::kKitti)[1].content, "302400.500000\n");
}

TEST(Exports, RtklibIsInGpsTime) {
  const std::string text = text_of(one_row(), ExportFormat::kRtklib);
  expect_says(text, "2022/03/09 12:00:00.500000   46.5000000000   -7.2500000000  1500.00000");
}

TEST(Exports, SbetHas17Doubles) {
  const auto files = exported(one_row(), ExportFormat::kSbet);
  ASSERT_EQ(files.size(), 2u);
  EXPECT_EQ(files[0].content.size(), 17u * 8);
  EXPECT_EQ(files[1].content.size(), 10u * 8);
  EXPECT_EQ(files[1].ending, "_smrmsg.out");
  EXPECT_EQ(losses_of(one_row(), ExportFormat::kSbet).size(), 2u);
}

TEST(Exports, DatesNeedAWeek) {
  ExportRun run = one_row();
  run.week.reset();
  for (const ExportFormat format :
       {ExportFormat::kGpx, ExportFormat::kGeojson, ExportFormat::kNmea, ExportFormat::kRtklib}) {
    try {
      exported(run, format);
      ADD_FAILURE() << name_of(format);
    } catch (const DataError& e) {
      expect_says(e.what(), "--week");
    }
  }
  EXPECT_NO_THROW(exported(run, ExportFormat::kTum));
  EXPECT_THROW(export_format("shapefile"), ConfigError);
  try {
    export_format("parquet");
  } catch (const ConfigError& e) {
    expect_says(e.what(), "from Python");
  }
}

}  // namespace
}  // namespace piste
