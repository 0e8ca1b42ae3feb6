#pragma once
/// Recorded data outside the repository.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <string>

#include "support/places.h"

namespace piste::test {

/// Folder of the recorded data sets: $PISTE_DATASETS, else ../shared/datasets next to the sources, else empty.
inline std::filesystem::path datasets() {
  namespace fs = std::filesystem;
  if (const char* given = std::getenv("PISTE_DATASETS")) return given;
  const fs::path beside = fs::path(source_folder()).parent_path() / "shared" / "datasets";
  return fs::is_directory(beside) ? beside : fs::path();
}

}  // namespace piste::test

/// Skips the test without the data sets; fails it if $PISTE_DATASETS is set and they are missing.
#define PISTE_REQUIRE_DATASETS()                                                                      \
  if (!std::filesystem::is_directory(piste::test::datasets() / "drive")) {                            \
    if (std::getenv("PISTE_DATASETS") != nullptr) FAIL() << "$PISTE_DATASETS has no folder drive/";   \
    GTEST_SKIP() << "recorded data are not here: set PISTE_DATASETS to the folder that holds drive/"; \
  }
