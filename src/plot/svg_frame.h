#pragma once
/// What every picture has: its first tag, its colours, and how long its texts are.

#include <cstddef>
#include <string>
#include <string_view>

namespace piste::svg {

/// The opening `<svg>` tag and the style. Colours are var(--c0) to var(--c6), and --ink, --soft, --grid.
std::string open(int width, int height, std::string_view description);

/// Colour 0 to 6 of any number.
int palette(int colour);

/// Letters of UTF-8 text, which are fewer than its bytes.
std::size_t letters(std::string_view text);

}  // namespace piste::svg
