#pragma once
/// Where tests find what they read and run, wherever they are started.

#include <filesystem>
#include <string>

namespace piste::test {

/// The repository's folder, without a `/` behind.
std::string source_folder();
/// The same as a path.
inline const std::filesystem::path kSource = source_folder();

/// The folder of the build that the test is of.
std::string build_folder();

/// The ctest of that build's CMake.
std::string ctest_program();

/// A program, such as `replay`, as it was built with the tests.
std::string program(const std::string& name);

/// A folder for what a test draws or writes and somebody may want to look at; not below the repository's own folders.
std::string rendered_folder();

}  // namespace piste::test
