#include "math/words.h"

#include <gtest/gtest.h>

#include <limits>

namespace piste {
namespace {

TEST(Words, NumbersHaveNoExponent) {
  EXPECT_EQ(plain(350, 2), "350");
  EXPECT_EQ(plain(1234567, 2), "1200000");
  EXPECT_EQ(plain(0.00042), "0.00042");
  EXPECT_EQ(plain(-22.96, 3), "-23");
  EXPECT_EQ(plain(-0.0), "0");
}

TEST(Words, NoughtHasNoSign) {
  EXPECT_EQ(with_decimals(-0.004, 2), "0.00");
  EXPECT_EQ(with_decimals(-0.006, 2), "-0.01");
  EXPECT_EQ(with_decimals(-0.4, 0), "0");
  EXPECT_EQ(with_decimals(-30, 0), "-30");
  EXPECT_EQ(rounded(-0.0004, 0.05), "0.000");
}

TEST(Words, ANumberHasTheDigitsOfItsSigma) {
  EXPECT_EQ(measured(12.3456, 0.0123), "12.346 ± 0.012");
  EXPECT_EQ(measured(1234.5, 67), "1235 ± 67");
  EXPECT_EQ(rounded(12.3456, 0), "12.35") << "no sigma";
  const double infinity = std::numeric_limits<double>::infinity();
  EXPECT_EQ(rounded(12.3456, infinity), "12.35");
  EXPECT_EQ(rounded(infinity, 0.1), "inf");
}

TEST(Words, TimesHaveAUnitOfTheirSize) {
  EXPECT_EQ(time_text(0.0123), "12.3 ms");
  EXPECT_EQ(time_text(-12.5), "-12.500 s");
  EXPECT_EQ(time_text(5400), "1.50 h (5400.000 s)");
  EXPECT_EQ(time_text(216000), "2.50 days (216000.000 s)");
  EXPECT_EQ(delay_text(0.05), "50 ms late");
  EXPECT_EQ(delay_text(-2), "2.000 s early");
}

}  // namespace
}  // namespace piste
