#include "piste/analyse/study_files.h"

#include <gtest/gtest.h>
#include <cstdio>
#include "support/study_case.h"
namespace piste {
TEST(X, Y) {
  const Study study = test::StudyCase{.failed = true}.study();
  fputs(study_text(study).c_str(), stdout);
  fputs(study_json(study).substr(0, 9000).c_str(), stdout);
  for (auto& f : study_csv(study)) printf("\n%s\n%s", f.name.c_str(), f.content.substr(0, 900).c_str());
}
}
