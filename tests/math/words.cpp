#include "math/words.h"

#include <gtest/gtest.h>

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

}  // namespace
}  // namespace piste
