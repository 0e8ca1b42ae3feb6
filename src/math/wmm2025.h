#pragma once
// The coefficients of the World Magnetic Model, which CMake embeds from config/wmm2025.

#include <string_view>

namespace piste::assets {

std::string_view wmm2025();

}  // namespace piste::assets
