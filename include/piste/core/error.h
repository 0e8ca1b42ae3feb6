#pragma once
/// The exceptions of the library. Each says what is wrong with the user's input, where, and what would be right.

#include <stdexcept>
#include <string>

namespace piste {

/// Base of every error that the library throws. `what()` reads `WHERE: what is wrong, and what would be
/// right`, where WHERE is `FILE:LINE`, a file, or a time of the run.
class Error : public std::runtime_error {
 public:
  Error(const std::string& where, const std::string& what);
  /// WHERE; empty if it is not known.
  const std::string& where() const { return where_; }

 private:
  std::string where_;
};

/// The configuration or the command line is wrong (exit code 2 of the apps).
class ConfigError : public Error {
 public:
  using Error::Error;
};

/// The data cannot be processed (exit code 1 of the apps).
class DataError : public Error {
 public:
  using Error::Error;
};

}  // namespace piste
