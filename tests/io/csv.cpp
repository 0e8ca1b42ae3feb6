#include "io/csv.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "piste/files/output.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::TemporaryFolder;

std::vector<std::array<double, 2>> read(const std::string& file, const std::vector<std::string>& ignored = {}) {
  CsvReader reader(file, ignored);
  const auto time = reader.column("time_s"), x = reader.column("x_m");
  reader.finish_header();
  IncreasingTime increasing;
  std::vector<std::array<double, 2>> rows;
  while (reader.next()) rows.push_back({increasing.next(reader[time], reader.text()), reader[x]});
  return rows;
}

TEST(Csv, ReadsColumnsInAnyOrderWithSpacesSignsAndCrlf) {
  const TemporaryFolder folder;
  const auto rows = read(folder.write("a.csv", "\xEF\xBB\xBFx_m, time_s\r\n +1.5 ,2\r\n-2e-3,3\r\n\r\n+4,4.5"));
  EXPECT_EQ(rows, (std::vector<std::array<double, 2>>{{2, 1.5}, {3, -2e-3}, {4.5, 4}}));
}

TEST(Csv, IgnoresOnlyTheColumnsThatAreNamed) {
  const TemporaryFolder folder;
  const std::string file = folder.write("a.csv", "time_s,x_m,comment\n1,2,good\n");
  EXPECT_EQ(read(file, {"comment"}).size(), 1u);
  const std::string message = message_of<DataError>([&] { read(file); });
  EXPECT_TRUE(contains(message, file + ":1: unknown column `comment`"));
  EXPECT_TRUE(contains(message, "ignore_columns"));
  EXPECT_TRUE(contains(message_of<DataError>([&] { read(file, {"other"}); }), "no column `other` to ignore"));
}

TEST(Csv, RefusesMalformedRowsWithTheirLine) {
  const TemporaryFolder folder;
  const std::pair<const char*, const char*> cases[] = {
      {"3,oops\n", ":3: field 2, `oops`, is no number; column `x_m` needs one"},
      {"3,1.2.3\n", "is no number"},
      {"3,\n", "is no number"},
      {"3,+-1\n", "is no number"},
      {"3,nan\n", ":3: field 2, `nan`, must be finite"},
      {"3,inf\n", "must be finite"},
      {"3,1e999\n", "is no number"},
      {"3,1,2\n", ":3: 3 fields, but the header names 2 columns"},
      {"3", ":3: 1 fields, but the header names 2 columns; is the line cut?"},
      {"1,5\n", ":3: time 1.000000 s does not increase"},
      {"0.5,5\n", "does not increase"},
  };
  for (const auto& [row, expected] : cases) {
    const std::string file = folder.write("a.csv", std::string("time_s,x_m\n1,2\n") + row);
    EXPECT_TRUE(contains(message_of<DataError>([&] { read(file); }), expected)) << row;
    EXPECT_TRUE(contains(message_of<DataError>([&] { read(file); }), file + ":3: ")) << row;
  }
}

TEST(Csv, RefusesAMissingFileOrHeader) {
  const TemporaryFolder folder;
  EXPECT_TRUE(contains(message_of<DataError>([&] { read(folder / "none.csv"); }), "none.csv: cannot be read"));
  EXPECT_TRUE(contains(message_of<DataError>([&] { read(folder.path().string()); }), "cannot be read"));
  EXPECT_TRUE(contains(message_of<DataError>([&] { read(folder.write("e.csv", "")); }), "e.csv:1: the file is empty"));
  EXPECT_TRUE(contains(message_of<DataError>([&] { read(folder.write("t.csv", "time_s,time_s\n")); }), "stands twice"));
  EXPECT_TRUE(
      contains(message_of<DataError>([&] { read(folder.write("m.csv", "time_s,y_m\n")); }), "column `x_m` is missing"));
}

TEST(Csv, AWeekThatRollsOverContinues) {
  const TemporaryFolder folder;
  const auto rows = read(folder.write("a.csv", "time_s,x_m\n604799.5,1\n0.5,2\n1.5,3\n"));
  EXPECT_EQ(rows[1][0], 604800.5);
  EXPECT_EQ(rows[2][0], 604801.5);
}

TEST(Csv, WritesFixedDigits) {
  CsvWriter writer({{"time_s", 3}, {"x_m", 0}, {"y", 7}});
  writer.row(std::array{243258.4994, -2.5, -1e-9});
  writer.row(std::array{0.0, 1e17, 0.1234567});
  EXPECT_EQ(writer.text(), "time_s,x_m,y\n243258.499,-3,0.0000000\n0.000,100000000000000000,0.1234567\n");
  std::string text;
  append_fixed(text, std::nan(""), 2);
  EXPECT_EQ(text, "nan");
}

TEST(Csv, RoundTripsToHalfALastDigit) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(-1e4, 1e4);
  const TemporaryFolder folder;
  CsvWriter writer({{"time_s", 6}, {"x_m", 9}});
  std::vector<double> values(1000);
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = uniform(random);
    writer.row(std::array{static_cast<double>(i) * 0.01, values[i]});
  }
  const auto rows = read(folder.write("a.csv", writer.text()));
  ASSERT_EQ(rows.size(), values.size());
  for (std::size_t i = 0; i < values.size(); ++i) EXPECT_NEAR(rows[i][1], values[i], 0.6e-9);
}

TEST(Output, AppearsWholeOrNotAtAll) {
  const TemporaryFolder temporary;
  const auto folder = temporary.path() / "out" / "run";
  {
    OutputFolder output(folder);
    output.write("a.csv", "1\n");
    output.write("figures/b.svg", "<svg/>");
    EXPECT_FALSE(std::filesystem::exists(folder / "a.csv"));
  }
  EXPECT_FALSE(std::filesystem::exists(temporary.path() / "out"));
  {
    OutputFolder output(folder);
    output.write("a.csv", "1\n");
    output.write("figures/b.svg", "<svg/>");
    output.commit();
  }
  EXPECT_EQ(test::read_text(folder / "a.csv"), "1\n");
  EXPECT_EQ(test::read_text(folder / "figures" / "b.svg"), "<svg/>");
  {
    OutputFolder output(folder);
    output.write("a.csv", "2\n");
  }
  EXPECT_EQ(test::read_text(folder / "a.csv"), "1\n");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 2);
}

TEST(Output, RefusesAFolderThatCannotBe) {
  const TemporaryFolder temporary;
  const std::string file = temporary.write("a", "");
  EXPECT_TRUE(contains(message_of<ConfigError>([&] { OutputFolder output(file); }), "--output"));
}

// ---- Tables in memory ----

/// Two columns, row by row in one block, as numpy has them.
LogFile table_in(const std::vector<double>& block) {
  NumberColumns table{.columns = {{"time_s", block.data(), 2}, {"x_m", block.data() + 1, 2}}, .rows = block.size() / 2};
  return {.file = "imu", .table = std::move(table)};
}

TEST(Csv, ReadsATableInMemoryWhereItStands) {
  const std::vector<double> block{1, 1.5, 2, -3, 4, 0.25};
  CsvReader reader(table_in(block));
  const auto x = reader.column("x_m"), time = reader.column("time_s");
  reader.finish_header();
  std::vector<double> read;
  while (reader.next()) read.insert(read.end(), {reader[time], reader[x]});
  EXPECT_EQ(read, block);
}

TEST(Csv, NamesTheRowOfATableThatIsWrong) {
  const std::vector<double> block{1, 1.5, 2, std::nan("")};
  CsvReader reader(table_in(block));
  reader.column("x_m");
  EXPECT_TRUE(contains(message_of<DataError>([&] { reader.finish_header(); }), "imu: unknown column `time_s`"));
  ASSERT_TRUE(reader.next());
  EXPECT_TRUE(contains(message_of<RowError>([&] { reader.next(); }), "imu: row 1: column `x_m`, nan, must be finite"));
}

}  // namespace
}  // namespace piste
