#include "math/numbers.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <system_error>

#include "support/random.h"

namespace piste {
namespace {

struct Read {
  double value = -99;
  std::ptrdiff_t length = 0;
  std::errc error{};
};

template <class Function>
Read read(Function&& function, const std::string& text) {
  Read read;
  const auto [end, error] = function(text.data(), text.data() + text.size(), read.value);
  read.length = end - text.data();
  read.error = error;
  return read;
}

// Both ways to the same double, of all its bits, and to the same end.
void expect_same(const std::string& text) {
  const Read one = read(read_number, text), other = read(read_number_by_strtod, text);
  EXPECT_EQ(one.error, other.error) << text;
  if (one.error != std::errc::invalid_argument) {
    EXPECT_EQ(one.length, other.length) << text;
  }
  EXPECT_EQ(std::bit_cast<std::uint64_t>(one.value), std::bit_cast<std::uint64_t>(other.value)) << text;
}

TEST(Numbers, EndWhereTheNumberEnds) {
  const Read found = read(read_number, "-12.5e1 m");
  EXPECT_EQ(found.value, -125);
  EXPECT_EQ(found.length, 7);
  EXPECT_EQ(found.error, std::errc{});
}

TEST(Numbers, AreReadAlikeByStrtod) {
  for (const char* text : {"",
                           " 1",
                           "+1",
                           "-",
                           "-+1",
                           ".",
                           ".5",
                           "5.",
                           "-.5e",
                           "1e",
                           "1e+",
                           "1e+2x",
                           "1e-2,3",
                           "0x1p3",
                           "-0x10",
                           "x",
                           "1,5",
                           "1.2.3",
                           "12:30:00",
                           "inf",
                           "-infinity",
                           "nan",
                           "none",
                           "e5",
                           "1 2",
                           "1e400",
                           "-1e400",
                           "1e-400",
                           "4.9e-324",
                           "2.2250738585072011e-308",
                           "1797693134862315708145274237317043567980705675258449965989174768031572607800285387605895586"
                           "32766878171540458953514"
                           "3824642343213268894641827684675467035375169860499105765512820762454900903893289440758685084"
                           "55133942304583236903222"
                           "948165808559332123347747979",
                           "0.1000000000000000055511151231257827021181583404541015625",
                           "9007199254740993"}) {
    expect_same(text);
  }
}

TEST(Numbers, OfAnyBitsAreReadAlike) {
  test::Random random(1);
  for (int i = 0; i < 20000; ++i) {
    const double value = random.gaussian() * std::pow(10, 600 * (random.uniform() - 0.5));
    expect_same(fmt::format("{}", value));
    expect_same(fmt::format("{:.{}g}", value, 1 + i % 25));
  }
}

}  // namespace
}  // namespace piste
