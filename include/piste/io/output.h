#pragma once
/// Output files that appear whole or not at all.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace piste {

/// A folder that the outputs of one run go to. Each file is written beside its place, as `.NAME.piste.partial`;
/// `commit()` puts all there. Without it nothing remains, not even the folder where this object made it.
///
/// A program that is killed leaves what stood there before, and partial files, which the next run removes. Killed
/// within `commit()` it leaves whole files, some of them of the run before, and not the one that was written last:
/// where that one stands, all are of one run. A machine that goes down may lose more: nothing is forced to the disk.
class OutputFolder {
 public:
  /// Makes the folder. Throws ConfigError where that cannot be.
  explicit OutputFolder(std::filesystem::path folder);
  ~OutputFolder();
  OutputFolder(const OutputFolder&) = delete;
  OutputFolder& operator=(const OutputFolder&) = delete;

  /// Writes the file whole, still beside its place. `name` is relative to the folder and may lie in a subfolder.
  /// Throws Error where the disk refuses.
  void write(const std::string& name, std::string_view content);
  /// A file that an earlier run may have left here, and that this one does not give: `commit()` removes it.
  void withdraw(const std::string& name);
  /// Renames everything to its place, what was written last at last, and removes what killed runs left beside.
  void commit();

  const std::filesystem::path& folder() const { return folder_; }

 private:
  struct Pending {
    std::filesystem::path beside, place;
  };
  void make(const std::filesystem::path& folder);
  std::filesystem::path folder_;
  std::vector<std::filesystem::path> made_;
  std::vector<Pending> pending_;
  std::vector<std::filesystem::path> withdrawn_;
};

}  // namespace piste
