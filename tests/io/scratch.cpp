// Blocks of values come back as they were put, from memory and from a file that leaves nothing behind.

#include "io/scratch.h"

#include <gtest/gtest.h>

#include <numeric>

#include "piste/core/error.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

std::size_t files_in(const std::filesystem::path& folder) {
  return static_cast<std::size_t>(std::distance(std::filesystem::directory_iterator(folder), {}));
}

TEST(Scratch, GivesBackWhatWasPut) {
  const TemporaryFolder folder;
  for (const std::filesystem::path& place : {std::filesystem::path(), folder.path()}) {
    Scratch scratch(place);
    std::vector<double> values(3000000);  // more than stays in memory
    std::iota(values.begin(), values.end(), 0.5);
    const std::vector<std::uint8_t> few{1, 2, 3};
    EXPECT_EQ(scratch.add(std::span<const double>(values)), 0U);
    EXPECT_EQ(scratch.add(std::span<const double>()), 1U);
    EXPECT_EQ(scratch.add(std::span<const std::uint8_t>(few)), 2U);

    std::vector<double> back;
    std::vector<std::uint8_t> few_back;
    scratch.read(2, few_back);
    EXPECT_EQ(few_back, few);
    scratch.read(0, back);
    EXPECT_EQ(back, values);
    scratch.read(1, back);
    EXPECT_TRUE(back.empty());

    // A copy shares what is there; what is added behind a reading is behind all else.
    const Scratch copy = scratch;
    scratch.add(std::span<const double>(values).first(2));
    copy.read(3, back);
    EXPECT_EQ(back, std::vector<double>({0.5, 1.5}));
  }
  EXPECT_EQ(files_in(folder.path()), 0U);
}

TEST(Scratch, SaysWhereItCannotWrite) {
  const TemporaryFolder folder;
  Scratch scratch(folder.path() / "not_there");
  const std::vector<double> values(3000000);
  EXPECT_THROW(scratch.add(std::span<const double>(values)), Error);
}

}  // namespace
}  // namespace piste::test
