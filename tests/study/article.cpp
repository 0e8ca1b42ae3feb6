// The file of an article: what it may say, and what is refused.

#include "piste/study/article.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "piste/core/error.h"
#include "support/article.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::TemporaryFolder;

const std::string kArticle =
    "title: A. Author, A journal 2020\n"
    "sensors: [left, right]\n"
    "runs: 4\n"
    "tables:\n"
    "  rest:\n"
    "    name: Table II\n"
    "    significant_digits: 2\n"
    "    rows:\n"
    "      - {sensor: right, accel: 34.0 -120 0 mg, accel_std: 1 2 3 mg, gyro: 0.5 -0.10 12.5 deg/h}\n"
    "  joint_scale:\n"
    "    name: Table III\n"
    "    rows:\n"
    "      - {sensor: left, accel: 1200 -40 3e2 ppm, gyro: -0.001 0.0125 0.1}\n"
    "remarks: {significance: Its rule is its own.}\n";

struct ArticleFile : ::testing::Test {
  TemporaryFolder folder;
  Article read(const std::string& text) { return read_article(folder.write("article.yaml", text)); }
  std::string refused(const std::string& text) {
    return message_of<ConfigError>([&] { read(text); });
  }
  static std::string with(const std::string& part, const std::string& by) {
    std::string text = kArticle;
    const auto place = text.find(part);
    EXPECT_NE(place, std::string::npos) << part;
    return text.replace(place, part.size(), by);
  }
};

TEST_F(ArticleFile, NumbersAreShownInOneUnitAndKnowTheirRounding) {
  const Article article = read(kArticle);
  EXPECT_EQ(article.title, "A. Author, A journal 2020");
  EXPECT_EQ(article.sensors, (std::vector<std::string>{"left", "right"}));
  EXPECT_EQ(article.runs, 4U);
  const PrintedTable& rest = article.tables.rest;
  EXPECT_EQ(rest.name, "Table II");
  ASSERT_EQ(rest.sensors.size(), 2U);
  for (const Printed& p : rest.sensors[0]) EXPECT_TRUE(std::isnan(p.value)) << "the table does not have that sensor";
  const PrintedRow& row = rest.sensors[1];
  constexpr double kMilliG = 9.80665e-3, kDegreePerHour = 1 / 3600.0;
  EXPECT_NEAR(row[0].value, 34 * kMilliG, 1e-12);
  EXPECT_NEAR(row[0].rounding, 0.5 * kMilliG, 1e-12) << "two digits of 34.0";
  EXPECT_NEAR(row[1].rounding, 5 * kMilliG, 1e-12) << "two digits of 120";
  EXPECT_NEAR(row[2].rounding, 0.5 * kMilliG, 1e-12) << "the last digit of 0";
  EXPECT_NEAR(row[2].std, 3 * kMilliG, 1e-12);
  EXPECT_NEAR(row[3].value, 0.5 * kDegreePerHour, 1e-15) << "in deg/s";
  EXPECT_NEAR(row[4].rounding, 0.005 * kDegreePerHour, 1e-15);
  EXPECT_TRUE(std::isnan(row[4].std));
  const PrintedRow& scale = article.tables.joint_scale.sensors[0];
  EXPECT_NEAR(scale[0].value, 1.2e-3, 1e-15);
  EXPECT_NEAR(scale[0].rounding, 0.5e-6, 1e-18);
  EXPECT_NEAR(scale[2].rounding, 50e-6, 1e-18) << "the last digit of 3e2";
  EXPECT_NEAR(scale[4].rounding, 0.00005, 1e-18);
  EXPECT_TRUE(article.tables.bias_only.empty());
  EXPECT_FALSE(article.tables.joint_scale.empty());
  EXPECT_EQ(article.remarks.significance, "Its rule is its own.");
  EXPECT_EQ(article.remarks.correlation, "");
}

TEST_F(ArticleFile, MistakesAreNamedWithTheirLine) {
  EXPECT_TRUE(contains(refused("sensors: [a]\n"), "article.yaml:1: key `title` is missing"));
  EXPECT_TRUE(contains(refused("title: x\n"), "sensors"));
  EXPECT_TRUE(contains(refused(with("[left, right]", "[left, left]")), "article.yaml:2: sensors: `left` stands twice"));
  EXPECT_TRUE(contains(refused(with("runs: 4", "runs: 0")), "article.yaml:3"));
  EXPECT_TRUE(contains(refused(with("  rest:", "  restt:")), "article.yaml:5: unknown key `restt`, perhaps `rest`"));
  EXPECT_TRUE(contains(refused(with("name: Table II\n    sig", "sig")), "article.yaml:6: key `name` is missing"));
  EXPECT_TRUE(contains(refused(with("significant_digits: 2", "significant_digits: 0")), "article.yaml:7"));
  EXPECT_TRUE(contains(refused(with("sensor: right", "sensor: rigth")), "article.yaml:9: sensor: `rigth` is none of"));
  EXPECT_TRUE(contains(refused(with("12.5 deg/h", "12.5 m/s^2")), "article.yaml:9: gyro"));
  EXPECT_TRUE(contains(refused(with("-120 0 mg", "-120 mg")), "article.yaml:9: accel"));
  EXPECT_TRUE(contains(refused(with("accel: 34.0 -120 0 mg, ", "")), "article.yaml:9: key `accel` is missing"));
  EXPECT_TRUE(contains(refused(with("1 2 3 mg", "1 -2 3 mg")), "article.yaml:9: accel_std"));
  EXPECT_TRUE(contains(refused(with("      - {sensor: left",
                                    "      - {sensor: left, accel: 1 2 3, gyro: 1 2 3}\n"
                                    "      - {sensor: left")),
                       "article.yaml:14: sensor: `left` stands twice"));
  EXPECT_TRUE(contains(refused(with("significance:", "signifcance:")), "article.yaml:14: unknown key"));
}

TEST(ArticleBeside, GivesItsNumbersToCounterpartsOnly) {
  const ArticleBeside beside = test::bonnaz_2008();
  const PrintedTable& rest = beside.article.tables.rest;
  ASSERT_NE(beside.row(rest, "MT-9A 2"), nullptr);
  EXPECT_NEAR((*beside.row(rest, "MT-9A 2"))[3].value, -0.460, 1e-12);
  EXPECT_EQ(beside.row(rest, "sensor 2"), nullptr) << "the article's own name is not the campaign's";
}

}  // namespace
}  // namespace piste
