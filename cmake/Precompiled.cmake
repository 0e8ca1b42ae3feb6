# The headers of others that most of our files include, compiled once a target. Nothing may lean on them: clang-tidy reads
# every file, and the header check every public header, without them.
set(PISTE_PRECOMPILED <Eigen/Core> <Eigen/Geometry> <fmt/format.h> <algorithm> <array> <cmath> <filesystem> <functional>
  <limits> <map> <numbers> <optional> <span> <string> <string_view> <utility> <variant> <vector>)
# A precompiled header does not hold the time it was made at, which ccache would have to compare. Clang's holds its folder,
# so that ccache finds nothing of another clone: the sanitized presets do without.
add_compile_options("$<$<CXX_COMPILER_ID:Clang>:SHELL:-Xclang -fno-pch-timestamp>")
