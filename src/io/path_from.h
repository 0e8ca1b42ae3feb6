#pragma once
/// Paths in configurations that programs write.

#include <filesystem>
#include <string>

namespace piste {

/// `file` as seen from `folder`. Both may be relative to the current folder.
inline std::string path_from(const std::filesystem::path& folder, const std::filesystem::path& file) {
  const auto whole = [](const std::filesystem::path& path) {
    return std::filesystem::absolute(path).lexically_normal();
  };
  return whole(file).lexically_proximate(whole(folder)).generic_string();
}

}  // namespace piste
