#include "piste/core/error.h"

namespace piste {

Error::Error(const std::string& where, const std::string& what)
    : std::runtime_error(where.empty() ? what : where + ": " + what), where_(where) {}

}  // namespace piste
