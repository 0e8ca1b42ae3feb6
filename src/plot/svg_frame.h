#pragma once
/// Parts that all pictures share: the opening tag, the colours, and the length of texts.

#include <cstddef>
#include <string>
#include <string_view>

namespace piste::svg {

/// The opening `<svg>` tag and the style. Colours are var(--c0) to var(--c6), and --ink, --soft, --grid.
std::string open(int width, int height, std::string_view description);

/// As a colour: that of text and axes.
inline constexpr int kInk = -1;

/// A colour as a picture names it. Numbers beyond 0 to 6 begin again, but for `kInk`.
std::string paint(int colour);

/// Number of characters of UTF-8 text. It may be smaller than the number of bytes.
std::size_t letters(std::string_view text);

}  // namespace piste::svg
