// The program `inspect` as its user meets it.

#include <gtest/gtest.h>

#include "report/well_formed.h"
#include "support/navigation.h"
#include "support/places.h"
#include "support/ski_run.h"

namespace piste::test {
namespace {

const std::string kData = (kSource / "data/ski_run/").string();

struct InspectApp : ::testing::Test {
  TemporaryFolder folder;
  Said inspect(std::vector<std::string> words) const { return run_program(program("inspect"), words, folder); }
};

TEST_F(InspectApp, EndsWithAConfigurationThatReplays) {
  const Said said =
      inspect({kData + "mt9a_1.csv", kData + "gnss.csv", kData + "ln200_attitude.csv", "--output", "found"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_EQ(said.err, "");
  EXPECT_TRUE(contains(said.out, "mt9a_1.csv: IMU"));
  EXPECT_TRUE(contains(said.out, "100 Hz"));
  EXPECT_TRUE(contains(said.out, "A configuration for replay"));
  EXPECT_TRUE(contains(said.out, read_text(folder / "found/replay.yaml")));
  const Said replayed =
      run_program(program("replay"), {"found/replay.yaml", "--output", "replayed", "--quiet"}, folder);
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(replayed.err, "");
  const Accuracy a = accuracy(read_table(folder / "replayed/smoothed.csv"),
                              read_table(kSource / "data/ski_run/truth.csv"), {302480, 302580});
  EXPECT_GT(a.epochs, 1000u);
  EXPECT_LT(a.horizontal, 0.1) << text_of(a);
  EXPECT_LT(std::max(a.roll, a.pitch), 1) << text_of(a);
}

TEST_F(InspectApp, PageStandsAlone) {
  ASSERT_EQ(inspect({kData + "mt9a_1.csv", kData + "gnss.csv", "--output", "found", "--quiet"}).code, 0);
  const std::string page = read_text(folder / "found/inspection.html");
  EXPECT_TRUE(contains(page, "What looks wrong"));
  EXPECT_TRUE(contains(page, "Track"));
  EXPECT_EQ(page.find("http://"), page.find("http://www.w3.org"));  // no network
  EXPECT_EQ(page.find("nan"), std::string::npos);
}

TEST_F(InspectApp, SaysWhatItCannotRead) {
  folder.write("letter.txt", "Dear Sir,\nthe receiver that you sold me\n");
  folder.write("empty.csv", "");
  const Said letter = inspect({"letter.txt", kData + "gnss.csv", "--output", "found"});
  EXPECT_EQ(letter.code, 1);
  EXPECT_TRUE(contains(letter.err, "letter.txt:1: is none of the logs that piste reads; it begins with `Dear Sir,`"));
  EXPECT_TRUE(contains(letter.out, "gnss.csv: GNSS"));
  const Said empty = inspect({"empty.csv", "--output", "found"});
  EXPECT_EQ(empty.code, 1);
  EXPECT_TRUE(contains(empty.err, "empty.csv:1: the file is empty"));
  EXPECT_FALSE(std::filesystem::exists(folder / "found/replay.yaml"));
}

TEST_F(InspectApp, NamesAFaultWithItsLine) {
  const SkiRun run;
  run.edit_line(SkiRun::kImu, 1000,
                [](std::string& line) { line.replace(line.rfind(',') + 1, std::string::npos, "nan"); });
  const Said said = inspect({run.folder / SkiRun::kImu, run.folder / SkiRun::kGnss, "--output", "found"});
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(contains(said.out, "  1. "));
  EXPECT_TRUE(contains(said.out, "the first at 1000: field 7, `nan`"));
}

TEST_F(InspectApp, WrongUsage) {
  EXPECT_EQ(inspect({}).code, 2);
  const Said said = inspect({"nowhere.csv"});
  EXPECT_EQ(said.code, 2);
  EXPECT_TRUE(contains(said.err, "nowhere.csv: there is no such file"));
  EXPECT_EQ(inspect({"--help"}).code, 0);
}

}  // namespace
}  // namespace piste::test
