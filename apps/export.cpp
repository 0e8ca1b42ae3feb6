/// export RUN --to FORMAT: the trajectory of a replay for other programs.

#include <fmt/format.h>

#include "app.h"
#include "piste/core/error.h"
#include "piste/exports/exports.h"
#include "piste/files/output.h"

namespace piste {
namespace {

void run(const AppArguments& arguments, Progress&) {
  const std::string name = arguments.text("to"), given = arguments.text("output");
  if (name.empty()) throw ConfigError("--to", "is missing; one of: " + export_format_names());
  const ExportFormat format = export_format(name);
  const auto week = arguments.integers.find("week");
  const ExportRun source = read_export_run(
      arguments.input, week == arguments.integers.end() ? std::nullopt : std::optional(static_cast<int>(week->second)));
  std::filesystem::path file(given);
  if (given.empty()) file = std::filesystem::path(arguments.input) / fmt::format("trajectory{}", extension_of(format));
  if (file.filename().empty() || std::filesystem::is_directory(file)) {
    throw ConfigError("--output", file.string() + " is a folder; name a file");
  }
  const std::vector<ExportedFile> files = exported(source, format);
  OutputFolder output(file.has_parent_path() ? file.parent_path() : ".");
  for (std::size_t i = files.size(); i-- > 0;) {  // the main one last
    output.write(i == 0 ? file.filename().string() : file.stem().string() + files[i].ending, files[i].content);
  }
  output.commit();
  for (const std::string& line : losses_of(source, format)) say(arguments, line);
  say(arguments, fmt::format("{} rows written to {}", source.track.size(), file.string()));
}

}  // namespace
}  // namespace piste

int main(int argc, char** argv) {
  return piste::run_app(
      {.name = "export",
       .summary = "Writes the trajectory of a replay for other programs. Says what the format cannot hold.",
       .input = "RUN",
       .input_help = "folder of a replay; its smoothed rows, or else the filtered ones",
       .has_output = false,
       .integers = {{"week", "GPS week of the run, if its logs do not state it", {}, 1}},
       .texts = {{"to", "one of: " + piste::export_format_names(), "FORMAT"},
                 {"output", "file to write (default: trajectory with the format's extension, in RUN)", "FILE"}}},
      argc, argv, piste::run);
}
