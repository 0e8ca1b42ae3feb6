#include "io/exif.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <optional>
#include <string_view>

#include "io/byte_reader.h"
#include "io/text_reader.h"
#include "math/time.h"
#include "piste/core/error.h"

namespace piste {
namespace {

using log_formats::number_at;

// The TIFF structure of a JPEG's APP1 segment; empty if there is none.
std::string_view tiff_of(std::string_view jpeg) {
  constexpr std::string_view kExif("Exif\0\0", 6);
  std::size_t at = 2;
  while (at + 4 <= jpeg.size() && jpeg[at] == '\xff') {
    const auto kind = number_at<std::uint8_t>(jpeg, at + 1);
    const std::size_t length = number_at<std::uint16_t>(jpeg, at + 2, std::endian::big);
    if (length < 2 || at + 2 + length > jpeg.size()) break;
    const std::string_view content = jpeg.substr(at + 4, length - 2);
    if (kind == 0xe1 && content.starts_with(kExif)) return content.substr(kExif.size());
    if (kind == 0xda) break;  // the picture begins
    at += 2 + length;
  }
  return {};
}

// Reads tags of text and of offsets.
class Tiff {
 public:
  explicit Tiff(std::string_view bytes)
      : bytes_(bytes), order_(bytes.starts_with("MM") ? std::endian::big : std::endian::little) {}
  std::size_t first_directory() const { return offset(4); }
  // Where the value of a tag stands in a directory: nothing if it has none.
  std::optional<std::size_t> entry(std::size_t directory, std::uint16_t tag) const {
    if (!holds(directory, 2)) return std::nullopt;
    const std::size_t count = number_at<std::uint16_t>(bytes_, directory, order_);
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = directory + 2 + 12 * i;
      if (!holds(at, 12)) return std::nullopt;
      if (number_at<std::uint16_t>(bytes_, at, order_) == tag) return at;
    }
    return std::nullopt;
  }
  std::size_t offset(std::size_t at) const { return holds(at, 4) ? number_at<std::uint32_t>(bytes_, at, order_) : 0; }
  std::string text(std::size_t directory, std::uint16_t tag) const {
    const auto at = entry(directory, tag);
    if (!at) return {};
    const std::size_t length = offset(*at + 4), from = length <= 4 ? *at + 8 : offset(*at + 8);
    if (!holds(from, length)) return {};
    const std::string_view text = bytes_.substr(from, length);
    return std::string(text.substr(0, text.find('\0')));
  }

 private:
  bool holds(std::size_t at, std::size_t length) const { return at <= bytes_.size() && length <= bytes_.size() - at; }
  std::string_view bytes_;
  std::endian order_;
};

}  // namespace

GpsTime exif_time(const std::string& file) {
  constexpr std::uint16_t kExifDirectory = 0x8769, kDateTime = 0x9003, kSubSecond = 0x9291, kOffset = 0x9011;
  const MappedFile mapped(file);
  const std::string_view jpeg = mapped.text();
  if (!jpeg.starts_with("\xff\xd8")) throw DataError(file, "is no JPEG");
  const Tiff tiff(tiff_of(jpeg));
  const auto pointer = tiff.entry(tiff.first_directory(), kExifDirectory);
  const std::size_t directory = pointer ? tiff.offset(*pointer + 8) : 0;
  const std::string text = pointer ? tiff.text(directory, kDateTime) : "";
  const auto number = [](std::string_view part) {
    return number_in(part, TextReader::Separator::kComma).value_or(std::nan(""));
  };
  const auto part = [&](std::size_t from, std::size_t length) {
    return text.size() >= 19 ? number(std::string_view(text).substr(from, length)) : std::nan("");
  };
  const auto day = day_of(part(0, 4), part(5, 2), part(8, 2));
  double seconds = part(11, 2) * kHour + part(14, 2) * 60 + part(17, 2);
  if (!day || !std::isfinite(seconds)) {
    throw DataError(file, "has no DateTimeOriginal; give the times of the photographs as a csv of name,time_utc");
  }
  if (const std::string fraction = tiff.text(directory, kSubSecond); !fraction.empty()) {
    const double value = number("0." + fraction.substr(0, fraction.find(' ')));
    if (std::isfinite(value)) seconds += value;
  }
  if (const std::string zone = tiff.text(directory, kOffset); zone.size() >= 6) {  // such as +01:00
    const double ahead = number(zone.substr(1, 2)) * kHour + number(zone.substr(4, 2)) * 60;
    if (std::isfinite(ahead)) seconds -= zone[0] == '-' ? -ahead : ahead;
  }
  const double days_over = std::floor(seconds / kDay);
  return gps_time(*day + std::chrono::days(static_cast<int>(days_over)), seconds - days_over * kDay, TimeSystem::kUtc);
}

}  // namespace piste
