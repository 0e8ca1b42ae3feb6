#include "piste/core/recording.h"

namespace piste {

void scale_sigmas(GnssRecording& gnss, double position, double velocity) {
  for (GeodeticFix& fix : gnss.fixes) {
    fix.sigma_position *= position;
    if (fix.velocity) fix.velocity->sigma *= velocity;
  }
}

}  // namespace piste
