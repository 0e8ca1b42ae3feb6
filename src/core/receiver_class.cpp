#include "core/receiver_class.h"

namespace piste {

const ReceiverClass& receiver_class(const std::vector<GeodeticFix>& fixes) {
  constexpr std::size_t kTenth = 10;
  std::array<std::size_t, kReceiverClasses.size()> counts{};
  for (const GeodeticFix& fix : fixes) ++counts[static_cast<std::size_t>(fix.quality)];
  const ReceiverClass* worst = nullptr;
  for (const ReceiverClass& row : kReceiverClasses) {
    const bool often = kTenth * counts[static_cast<std::size_t>(row.quality)] >= fixes.size() && !fixes.empty();
    if (often && (worst == nullptr || row.axes[0] > worst->axes[0])) worst = &row;
  }
  return worst != nullptr ? *worst : receiver_class(FixQuality::kUnknown);
}

}  // namespace piste
