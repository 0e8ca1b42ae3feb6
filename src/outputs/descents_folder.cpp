#include "piste/outputs/descents_folder.h"

#include "piste/core/version.h"
#include "piste/files/descents.h"
#include "piste/report/descents_page.h"

namespace piste {

void write_descents(OutputFolder& output, const DescentReport& report) {
  output.write("gained.csv", gained_csv(report));
  output.write("sections.csv", sections_csv(report));
  output.write("descents.html", descents_page(report, version()));
  output.write("descents.json", descents_json(report));
}

}  // namespace piste
