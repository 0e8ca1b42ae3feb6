// What the printed numbers of the shipped article imply, against what a close reading of them found by hand; and that
// the same questions can be asked of a study.

#include "study/printed_tables.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/article.h"
#include "support/study_case.h"

namespace piste {
namespace {

const CampaignTables& tables() {
  static const CampaignTables printed = test::bonnaz_2008().article.tables;
  return printed;
}

double rounded(double value, int decimals) {
  return std::round(value * std::pow(10, decimals)) / std::pow(10, decimals);
}

TEST(Article, BiasAloneIsTheJointLineAtTheMeanSignal) {
  const ImpliedMeans found = implied_means(tables());
  // Axis; of each sensor value, low, high; what all three share.
  const auto expect = [&found](std::size_t axis, int decimals, const std::array<double, 3>& values,
                               std::array<double, 2> common) {
    for (std::size_t sensor = 0; sensor < 3; ++sensor) {
      EXPECT_NEAR(found.sensors[sensor][axis].value, values[sensor], 0.006) << kSignalNames[axis] << sensor;
    }
    ASSERT_TRUE(found.common[axis]) << kSignalNames[axis];
    EXPECT_EQ(rounded(found.common[axis]->low, decimals), common[0]) << kSignalNames[axis];
    EXPECT_EQ(rounded(found.common[axis]->high, decimals), common[1]) << kSignalNames[axis];
  };
  expect(0, 2, {-8.00, -6.65, -6.38}, {-6.93, -6.14});
  expect(1, 3, {-0.21, -0.16, -0.21}, {-0.187, -0.184});
  expect(2, 2, {-7.17, -7.17, -7.23}, {-7.55, -6.82});
  expect(3, 1, {1.5, 2, 0.67}, {0.8, 3.0});
  expect(4, 1, {4.9, 4, 5.375}, {4.4, 5.7});
  expect(5, 1, {11.5, 5, 3}, {1.0, 5.8});
  const auto bounds = [&found](std::size_t sensor) { return *found.sensors[sensor][0].bounds; };
  EXPECT_EQ(rounded(bounds(0).low, 1), -10.7);
  EXPECT_EQ(rounded(bounds(0).high, 1), -5.9);
  EXPECT_EQ(rounded(bounds(1).low, 1), -7.2);
  EXPECT_EQ(rounded(bounds(2).high, 1), -5.9);
  const auto middle = [&found](std::size_t axis) { return (found.common[axis]->low + found.common[axis]->high) / 2; };
  EXPECT_NEAR(std::hypot(middle(0), middle(1), middle(2)), 9.8, 0.1) << "gravity, as it must be";
}

TEST(Article, TheOtherSignOfTheBiasContradictsItself) {
  CampaignTables wrong = tables();
  for (PrintedRow& row : wrong.bias_only.sensors) {
    for (Printed& p : row) p.value = -p.value;
  }
  const ImpliedMeans found = implied_means(wrong);
  EXPECT_FALSE(found.common[0]);
  EXPECT_FALSE(found.common[3]);
}

TEST(Article, NoBoundsWhereTheScaleMayBeZero) {
  CampaignTables unclear = tables();
  unclear.joint_scale.sensors[0][5].value = 0.0004;
  const ImpliedMeans found = implied_means(unclear);
  EXPECT_FALSE(found.sensors[0][5].bounds);
  EXPECT_TRUE(found.common[5]) << "of the other two";
}

TEST(Article, CorrelationsImplyTheSpreadOfTheSignals) {
  EXPECT_NEAR(implied_spread(-6.535, 0.96).std, 1.9, 0.05);
  EXPECT_NEAR(implied_spread(-7.185, 0.98).std, 1.5, 0.05);
  EXPECT_NEAR(implied_spread(-0.1855, -0.33).rms, 0.56, 0.005);
  EXPECT_NEAR(implied_spread(-0.1855, -0.33).mean, -0.1855, 0);
}

TEST(Article, SignsOfTableFiveAreNotThoseOfTheModel) {
  const auto wrong = wrong_signs(tables(), implied_means(tables()));
  ASSERT_EQ(wrong.size(), 11U) << "two of the accelerometers, and every gyroscope";
  EXPECT_EQ(wrong[0], (std::pair<std::size_t, int>{0, 1}));
  EXPECT_EQ(wrong[4], (std::pair<std::size_t, int>{1, 0}));
}

TEST(Article, TenOfEighteenBiasesAreSignificantByItsRule) {
  const SignificantCount one = significant_count(tables().rest, 9);
  EXPECT_EQ(one.all, 18U);
  EXPECT_EQ(one.above_one_sigma, 10U);
  EXPECT_EQ(one.at_one_sigma, 1U);
  EXPECT_EQ(one.above_two_sigma, 7U);
  EXPECT_NEAR(one.expected_by_chance, 5.7, 0.05);
  EXPECT_EQ(significant_count(tables().bias_only, 9).above_one_sigma, 15U);
  EXPECT_EQ(one.holm_of_mean, 10U) << "were they means of nine runs";
  EXPECT_EQ(one.holm_of_one, 5U);
}

TEST(Article, SixteenOfEighteenScalesAreNegative) {
  const SignTest found = sign_test(tables().joint_scale);
  EXPECT_EQ(found.negative, 16U);
  EXPECT_EQ(found.all, 18U);
  EXPECT_NEAR(found.p_value, 172.0 / 262144, 1e-12);
  const SignTest rest = sign_test(tables().rest);
  EXPECT_EQ(rest.negative, 10U);
  EXPECT_NEAR(rest.p_value, 0.407, 0.001);
}

TEST(Article, AccelerometersShiftAlikeOnAllSensors) {
  const auto found = shifts(tables());
  const auto expect = [&found](std::size_t axis, const std::array<double, 3>& values) {
    for (std::size_t s = 0; s < 3; ++s) EXPECT_NEAR(found[axis].value[s], values[s], 1e-9) << kSignalNames[axis];
  };
  expect(0, {-0.112, -0.060, -0.101});
  expect(2, {0.063, 0.016, 0.070});
  EXPECT_TRUE(found[0].same_sign);
  EXPECT_FALSE(found[1].same_sign);
  EXPECT_TRUE(found[2].same_sign);
  const auto [least, most] = std::ranges::minmax(found[0].in_sigma);
  EXPECT_NEAR(least, 3.8, 0.05);
  EXPECT_NEAR(most, 5.5, 0.05);
  for (std::size_t axis = 3; axis < 6; ++axis) {
    for (const double s : found[axis].in_sigma) EXPECT_LT(s, 1.75) << kSignalNames[axis];
  }
  EXPECT_NEAR(table_correlation(tables().rest, tables().bias_only, true), 0.96, 0.005);
  EXPECT_NEAR(table_correlation(tables().rest, tables().bias_only, false), -0.48, 0.005);
}

TEST(Article, StandardDeviationsTellOfTheirOrigin) {
  EXPECT_EQ(equal_std(tables().rest), (std::vector<std::pair<int, int>>{{3, 4}})) << "wx and wy: copied";
  EXPECT_TRUE(equal_std(tables().bias_only).empty());
  const auto same = std_ratios(tables().joint_bias, tables().bias_only);
  for (const auto& sensor : same) {
    EXPECT_NEAR(sensor[3], 1, 0.03);
    EXPECT_NEAR(sensor[5], 1, 0.03);
    EXPECT_GT(sensor[4], 1.03);
    EXPECT_LT(sensor[4], 1.11);
  }
  const auto rms = std_ratios(tables().joint_bias, tables().joint_scale);
  EXPECT_NEAR(rms[0][1], 3.7, 0.05);
  EXPECT_NEAR(rms[1][1], 1.5, 0.05);
}

TEST(Article, TableTwoIsTheFirstSensorOfTableOne) {
  for (std::size_t axis = 0; axis < kSignals; ++axis) {
    const double before = tables().before.sensors[0][axis].value, after = tables().after.sensors[0][axis].value;
    EXPECT_EQ(before, tables().rest.sensors[0][axis].value);
    EXPECT_LE(std::abs(after - before), axis < 3 ? 0.0101 : 0.0031);
  }
}

TEST(Article, TablesThatItDoesNotHaveImplyNothing) {
  CampaignTables few = tables();
  for (PrintedTable* table : {&few.joint_scale, &few.correlation, &few.rest}) {
    for (PrintedRow& row : table->sensors) row.fill({});
  }
  const ImpliedMeans means = implied_means(few);
  for (const auto& common : means.common) EXPECT_FALSE(common);
  EXPECT_TRUE(wrong_signs(few, means).empty());
  EXPECT_EQ(significant_count(few.rest, 9).all, 0U);
  EXPECT_TRUE(equal_std(few.rest).empty());
  EXPECT_TRUE(std::isnan(axis_mean(few.joint_scale, 0)));
  EXPECT_NEAR(axis_mean(tables().joint_scale, 1), -0.040, 1e-12);
}

TEST(CampaignTables, OfAStudyAnswerTheSameQuestions) {
  constexpr double kMean = -6;
  Study study = test::StudyCase{.sensors = 2}.study();
  for (SensorRun& r : study.results) {
    auto& estimates = r.estimates;
    const auto of = [&estimates](Method m) { return std::ranges::find(estimates, m, &MethodEstimate::method); };
    for (std::size_t axis = 0; axis < kSignals; ++axis) {
      const BiasScale joint = correction(*of(Method::kJoint)->axes[axis].line);
      of(Method::kBiasOnly)->axes[axis].bias_alone->value = -(joint.value(0) + kMean * joint.value(1));
    }
  }
  const CampaignTables found = campaign_tables(study);
  const ImpliedMeans means = implied_means(found);
  ASSERT_EQ(means.sensors.size(), 2U);
  for (const auto& sensor : means.sensors) {
    EXPECT_NEAR(sensor[0].value, kMean, 1e-9);
    EXPECT_NEAR(sensor[4].value, kMean * kDegreesPerRadian, 1e-7) << "in deg/s";
    EXPECT_NEAR(sensor[0].bounds->low, kMean, 1e-9) << "nothing is rounded";
  }
  EXPECT_NEAR(implied_spread(-6.4, found.correlation.sensors[0][0].value).std, 1.9, 0.05);
  EXPECT_EQ(significant_count(found.rest, 9).all, 12U);
  std::erase_if(study.results, [](const SensorRun& r) { return r.sensor == 1; });
  EXPECT_EQ(significant_count(campaign_tables(study).rest, 9).all, 6U) << "a sensor without numbers does not count";
}

}  // namespace
}  // namespace piste
