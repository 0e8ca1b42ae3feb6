/// NumPy's .npz: a ZIP archive, stored, of one .npy array a column (NEP 1; APPNOTE.TXT 4.3 of PKWARE).

#include <fmt/format.h>

#include <array>
#include <bit>
#include <boost/crc.hpp>
#include <cstdint>
#include <limits>

#include "exports/formats.h"
#include "piste/core/error.h"

namespace piste::export_formats {
namespace {

// An unsigned number, little-endian.
template <class T>
void append_number(std::string& bytes, T value) {
  for (std::size_t i = 0; i < sizeof(T); ++i) bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

std::string npy(const NumberTable& table, std::size_t column) {
  const std::size_t columns = table.names.size(), rows = table.values.size() / columns;
  constexpr std::size_t kAlign = 64, kBefore = 10;
  std::string header = fmt::format("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", rows);
  while ((kBefore + header.size() + 1) % kAlign != 0) header += ' ';
  header += '\n';
  std::string bytes("\x93NUMPY\x01\x00", 8);
  append_number(bytes, static_cast<std::uint16_t>(header.size()));
  bytes += header;
  for (std::size_t i = 0; i < rows; ++i) {
    append_number(bytes, std::bit_cast<std::uint64_t>(table.values[i * columns + column]));
  }
  return bytes;
}

// The fields that the two headers of an archive's file share.
std::string entry(const std::string& name, const std::string& content) {
  boost::crc_32_type crc;
  crc.process_bytes(content.data(), content.size());
  constexpr std::uint16_t kVersion = 20, kStored = 0, kTime = 0, kDate = (1 << 5) + 1;  // 1 January 1980
  std::string bytes;
  for (const std::uint16_t value : {kVersion, std::uint16_t{0}, kStored, kTime, kDate}) append_number(bytes, value);
  append_number(bytes, static_cast<std::uint32_t>(crc.checksum()));
  append_number(bytes, static_cast<std::uint32_t>(content.size()));
  append_number(bytes, static_cast<std::uint32_t>(content.size()));
  append_number(bytes, static_cast<std::uint16_t>(name.size()));
  append_number(bytes, std::uint16_t{0});
  return bytes;
}

}  // namespace

std::vector<ExportedFile> numpy(const ExportRun& run) {
  if (8 * run.table.values.size() > std::numeric_limits<std::uint32_t>::max() / 2) {
    throw DataError(run.track.file,
                    "more than 2 GB of numbers do not fit into one archive; write fewer rows: "
                    "`output: {rate: 100 Hz}`");
  }
  std::string archive, directory;
  for (std::size_t column = 0; column < run.table.names.size(); ++column) {
    const std::string name = run.table.names[column] + ".npy", content = npy(run.table, column),
                      shared = entry(name, content);
    const auto place = static_cast<std::uint32_t>(archive.size());
    archive.append("PK\x03\x04").append(shared).append(name).append(content);
    directory += "PK\x01\x02";
    append_number(directory, std::uint16_t{20});
    directory += shared;
    for (int i = 0; i < 3; ++i) append_number(directory, std::uint16_t{0});  // comment, disk, kind
    append_number(directory, std::uint32_t{0});
    append_number(directory, place);
    directory += name;
  }
  const auto files = static_cast<std::uint16_t>(run.table.names.size());
  const auto begin = static_cast<std::uint32_t>(archive.size());
  archive += directory + "PK\x05\x06";
  for (const std::uint16_t value : {std::uint16_t{0}, std::uint16_t{0}, files, files}) append_number(archive, value);
  append_number(archive, static_cast<std::uint32_t>(directory.size()));
  append_number(archive, begin);
  append_number(archive, std::uint16_t{0});
  return {{".npz", std::move(archive)}};
}

}  // namespace piste::export_formats
