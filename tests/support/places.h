#pragma once
/// Folders and programs that tests use, wherever the tests are started.

#include <filesystem>
#include <string>

namespace piste::test {

/// The repository's folder, without a `/` behind.
std::string source_folder();
/// The repository's folder as a path.
inline const std::filesystem::path kSource = source_folder();

/// The folder of the build to which the test belongs.
std::string build_folder();

/// The ctest of that build's CMake.
std::string ctest_program();

/// A program, such as `replay`, as it was built with the tests.
std::string program(const std::string& name);

/// A folder for drawn or written results that somebody may inspect; not below the repository's own folders.
std::string rendered_folder();

}  // namespace piste::test
