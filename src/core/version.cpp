#include "piste/core/version.h"

namespace piste {

std::string version() { return PISTE_VERSION; }

}  // namespace piste
