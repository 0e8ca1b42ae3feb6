#pragma once
/// Runs a program as a user does, and keeps its output.

#include <fmt/format.h>
#include <sys/wait.h>

#include <cstdlib>
#include <string>
#include <vector>

#include "support/text_file.h"

namespace piste::test {

struct Said {
  int code = -1;  ///< exit code
  std::string out, err;
};

/// Runs `program` with the arguments `words`, started in `folder` by a shell after the command `first`, with redirected
/// outputs. A program that hangs is ended after `longest` seconds, with code 124.
inline Said run_program(const std::string& program, const std::vector<std::string>& words,
                        const TemporaryFolder& folder, const std::string& first = "true", int longest = 300) {
  std::string command =
      fmt::format("cd '{}' && {} && timeout {} '{}'", folder.path().string(), first, longest, program);
  for (const std::string& word : words) command += fmt::format(" '{}'", word);
  command += fmt::format(" > '{}' 2> '{}'", folder / ".out", folder / ".err");
  const int status = std::system(command.c_str());
  return {WIFEXITED(status) ? WEXITSTATUS(status) : -1, read_text(folder / ".out"), read_text(folder / ".err")};
}

}  // namespace piste::test
