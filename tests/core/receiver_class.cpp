#include "core/receiver_class.h"

#include <gtest/gtest.h>

namespace piste {
namespace {

TEST(ReceiverClass, EveryQualityHasItsRow) {
  for (std::size_t i = 0; i < kReceiverClasses.size(); ++i) {
    const ReceiverClass& row = kReceiverClasses[i];
    EXPECT_EQ(static_cast<std::size_t>(row.quality), i);
    EXPECT_GT(row.sigma().minCoeff(), 0) << row.name;
    EXPECT_GT(row.share, 0) << row.name;
    EXPECT_LT(row.share, 1) << row.name;
  }
  EXPECT_EQ(receiver_class(FixQuality::kDeadReckoned).quality, kReceiverClasses.back().quality);
}

// A log counts as what a tenth of its fixes are at worst; a few bad ones are outliers.
TEST(ReceiverClass, OfALogIsTheLeastCertainThatIsCommon) {
  std::vector<GeodeticFix> fixes(100);
  for (GeodeticFix& fix : fixes) fix.quality = FixQuality::kFixed;
  EXPECT_EQ(receiver_class(fixes).quality, FixQuality::kFixed);
  for (std::size_t i = 0; i < 5; ++i) fixes[i].quality = FixQuality::kSingle;
  EXPECT_EQ(receiver_class(fixes).quality, FixQuality::kFixed);
  for (std::size_t i = 5; i < 20; ++i) fixes[i].quality = FixQuality::kFloat;
  EXPECT_EQ(receiver_class(fixes).quality, FixQuality::kFloat);
  EXPECT_EQ(receiver_class(std::vector<GeodeticFix>(10)).sigma(), Vector3d(3, 3, 6)) << "nothing is known";
  EXPECT_EQ(receiver_class(std::vector<GeodeticFix>()).sigma(), Vector3d(3, 3, 6));
}

}  // namespace
}  // namespace piste
