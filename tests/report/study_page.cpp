#include "piste/report/study_page.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "report/well_formed.h"
#include "support/study_case.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;

TEST(StudyPage, TellsEverythingInOneFile) {
  const Study study = test::StudyCase{.failed = true}.study();
  const std::string page = study_html(study, "0.1.0", "runs: [<a>]");
  // PISTE_SHOW=FILE keeps the page to be looked at.
  if (const char* file = std::getenv("PISTE_SHOW")) std::ofstream(file) << page;
}

}  // namespace
}  // namespace piste
