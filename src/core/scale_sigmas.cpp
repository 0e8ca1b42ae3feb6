#include <type_traits>

#include "core/recording.h"

namespace piste {
namespace {

template <typename Fix>
void scale(std::vector<Fix>& fixes, const SigmaScales& by) {
  for (Fix& fix : fixes) {
    fix.sigma_position *= by.position;
    if constexpr (std::is_same_v<Fix, GeodeticFix>) fix.sigma_position *= by.of(fix.quality);
    fix.sigma_position.z() *= by.height;
    if (fix.velocity) fix.velocity->sigma *= by.velocity;
  }
}

}  // namespace

void scale_sigmas(std::vector<GeodeticFix>& fixes, const SigmaScales& by) { scale(fixes, by); }
void scale_sigmas(std::vector<GnssFix>& fixes, const SigmaScales& by) { scale(fixes, by); }

}  // namespace piste
