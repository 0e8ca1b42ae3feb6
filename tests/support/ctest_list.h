#pragma once
/// The tests of this build, by their names.

#include <array>
#include <cstdio>
#include <memory>
#include <string>

#include "support/places.h"

namespace piste::test {

/// What `ctest -N` writes: a line for each test. Programs of tests that are not built stand there as NAME_NOT_BUILT.
inline std::string ctest_list() {
  const std::string command = "'" + ctest_program() + "' --test-dir '" + build_folder() + "' -N";
  const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
  std::string text;
  std::array<char, 4096> part{};
  while (std::fgets(part.data(), part.size(), pipe.get()) != nullptr) text += part.data();
  return text;
}

}  // namespace piste::test
