#include "app.h"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>

#include "ending.h"
#include "piste/core/error.h"
#include "piste/core/version.h"

namespace piste {
namespace {

constexpr int kBadData = 1, kBadUsage = 2;
constexpr const char* kExitCodes =
    "Exit status:\n"
    "  0  done\n"
    "  1  the data could not be processed; standard error says what is wrong, and where\n"
    "  2  wrong usage or configuration";

// The name by which the program was called: it is built as `replay` and installed as `piste-replay`.
std::string called_as(int argc, char** argv, const AppDescription& description) {
  const std::string name = argc > 0 ? std::filesystem::path(argv[0]).filename().string() : "";
  return name.empty() ? description.name : name;
}

AppArguments parse(int argc, char** argv, const AppDescription& description, CLI::App& command) {
  AppArguments arguments;
  std::string output;
  if (description.many_inputs) {
    command.add_option(description.input, arguments.inputs, description.input_help)->required()->type_name("");
  } else {
    command.add_option(description.input, arguments.input, description.input_help)->required()->type_name("");
  }
  if (description.has_output) {
    command
        .add_option("--output", output,
                    fmt::format("folder for the outputs; without it out/<stem of {}> below the current folder",
                                description.input))
        ->type_name("DIR");
  }
  command.add_flag("--quiet", arguments.quiet, "no progress bar, no summary on standard output");
  command.set_version_flag("--version", "piste " + version(), "print the version and exit");
  std::map<std::string, long> values;
  for (const IntegerOption& option : description.integers) {
    auto* o = command.add_option("--" + option.name, values[option.name], option.help)->type_name("N");
    // A number that overflows is read as the largest.
    o->check(CLI::Range(option.minimum, std::numeric_limits<long>::max() - 1).description(""));
    if (option.fallback) {
      const std::string said = option.fallback_said.empty() ? fmt::to_string(*option.fallback) : option.fallback_said;
      o->description(fmt::format("{} (default: {})", option.help, said));
    }
  }
  for (const FlagOption& option : description.flags) {
    command.add_flag("--" + option.name, arguments.flags[option.name], option.help);
  }
  std::map<std::string, std::string> files;
  for (const FileOption& option : description.files) {
    command.add_option("--" + option.name, files[option.name], option.help)->type_name("FILE");
  }
  std::map<std::string, std::string> single;
  for (const TextOption& option : description.texts) {
    const std::string name = "--" + option.name;
    std::vector<std::string>& all = arguments.texts[option.name];
    auto* o = option.many ? command.add_option(name, all, option.help)->allow_extra_args(false)
                          : command.add_option(name, single[option.name], option.help);
    o->type_name(option.type_name);
    if (!option.fallback.empty()) o->description(fmt::format("{} (default: {})", option.help, option.fallback));
  }
  command.parse(argc, argv);
  for (const TextOption& option : description.texts) {
    std::vector<std::string>& all = arguments.texts[option.name];
    if (!option.many && command.count("--" + option.name) > 0) all = {single[option.name]};
    if (all.empty() && !option.fallback.empty()) all = {option.fallback};
  }
  std::erase_if(files, [](const auto& file) { return file.second.empty(); });
  arguments.files = std::move(files);
  for (const IntegerOption& option : description.integers) {
    if (command.count("--" + option.name) > 0) {
      arguments.integers[option.name] = values[option.name];
    } else if (option.fallback) {
      arguments.integers[option.name] = *option.fallback;
    }
  }
  if (!description.many_inputs) arguments.inputs = {arguments.input};
  arguments.input = arguments.inputs.front();
  arguments.output = output;
  if (output.empty()) arguments.output = std::filesystem::path("out") / std::filesystem::path(arguments.input).stem();
  return arguments;
}

int report(const char* what, int code) {
  fmt::print(stderr, "{}\n", what);
  return code;
}

}  // namespace

void Progress::start(std::string stage, std::size_t total, std::string unit, std::size_t done) {
  stage_ = std::move(stage);
  unit_ = std::move(unit);
  total_ = total;
  done_before_ = done;
  started_ = last_ = Clock::now();
}

std::function<void(std::size_t, std::size_t)> Progress::counted(std::string stage, std::string unit) {
  return [this, stage = std::move(stage), unit = std::move(unit)](std::size_t done, std::size_t all) {
    if (done == 0) start(stage, all, unit);
    update(done);
  };
}

// Whether the bar may be drawn again, a tenth of a second after the last time.
bool Progress::is_due() {
  constexpr auto kRefresh = std::chrono::milliseconds(100);
  const Clock::time_point now = Clock::now();
  if (!enabled_ || now - last_ < kRefresh) return false;
  last_ = now;
  return true;
}

// `part` of the work is done; `rate` may be empty.
void Progress::draw(std::string_view stage, double part, const std::string& rate, double left) {
  constexpr std::size_t kWidth = 20;
  part = std::clamp(part, 0.0, 1.0);
  const auto filled = static_cast<std::size_t>(kWidth * part);
  fmt::print(stderr, "\r{:<19} [{:=<{}}{:{}}] {:3.0f} %  {}{} \x1b[K", stage, "", filled, "", kWidth - filled,
             std::floor(100 * part), rate, left > 0 ? fmt::format("{:.0f} s left", left) : "");
  std::fflush(stderr);
  drawn_ = true;
}

void Progress::update(std::size_t done) {
  if (total_ == 0 || !is_due()) return;
  const double rate = static_cast<double>(done - done_before_) / elapsed();
  draw(stage_, static_cast<double>(done) / static_cast<double>(total_),
       fmt::format("{:.{}f} {}/s  ", rate, rate < 10 ? 2 : 0, unit_),
       rate > 0 ? static_cast<double>(total_ - std::min(done, total_)) / rate : 0);
}

void Progress::start_work() { started_ = last_ = Clock::now(); }

void Progress::go_on(std::string_view stage, double part) {
  if (is_due()) draw(stage, part, "", part > 0 ? elapsed() * (1 / part - 1) : 0);
}

void Progress::clear() {
  if (drawn_) fmt::print(stderr, "\r\x1b[K");
  drawn_ = false;
}

int run_app(const AppDescription& description, int argc, char** argv,
            const std::function<void(const AppArguments&, Progress&)>& body) {
  CLI::App command{description.summary, called_as(argc, argv, description)};
  command.footer(kExitCodes);
  command.get_formatter()->label("REQUIRED", "");
  command.get_formatter()->label("Positionals", "Arguments");
  command.set_help_flag("-h,--help", "print this help and exit");
  AppArguments arguments;
  try {
    arguments = parse(argc, argv, description, command);
  } catch (const CLI::ParseError& e) {
    return command.exit(e) == 0 ? 0 : kBadUsage;
  }
  try {
    const EndOnSignal ending;
    Progress progress(!arguments.quiet && ::isatty(STDERR_FILENO) != 0);
    body(arguments, progress);
    return 0;
  } catch (const ConfigError& e) {
    return report(e.what(), kBadUsage);
  } catch (const std::exception& e) {
    return report(e.what(), kBadData);
  }
}

void say(const AppArguments& arguments, const std::string& line) {
  if (arguments.quiet) return;
  fmt::print("{}\n", line);
  std::fflush(stdout);  // a long program that writes into a file can be followed there
}

}  // namespace piste
