#include "piste/outputs/evaluation_folder.h"

#include "piste/core/version.h"
#include "piste/files/evaluation.h"
#include "piste/report/evaluation_page.h"

namespace piste {

void write_evaluation(OutputFolder& output, const Evaluation& found) {
  output.write("evaluation.csv", evaluation_csv(found));
  output.write("evaluation.html", evaluation_page(found, version()));
  output.write("evaluation.json", evaluation_json(found));
}

}  // namespace piste
