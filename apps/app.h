#pragma once
/// The frame of every program: command line, progress bar, errors and exit codes.

#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace piste {

/// A whole-number option, such as `--seed N`.
struct IntegerOption {
  std::string name, help;  ///< name without the dashes
  std::optional<long> fallback = std::nullopt;
  long minimum = 0;
  std::string fallback_said = {};  ///< the fallback's text in the help, if the fallback depends on the machine
};

/// An option without a value, such as `--robust`.
struct FlagOption {
  std::string name, help;
};

/// An option that names a file, such as `--sensor FILE`.
struct FileOption {
  std::string name, help;
};

/// An option with a text, such as `--align se3`.
struct TextOption {
  std::string name, help;
  std::string type_name = "TEXT";  ///< in the help
  std::string fallback = {};       ///< empty: none
  bool many = false;               ///< whether it may be repeated
};

/// Name, summary and options of a program, for its command line and its help. The help shows the name by which the user
/// called the program: an installed one is `piste-NAME`.
struct AppDescription {
  std::string name, summary;
  std::string input = "CONFIG";  ///< name of the positional argument
  std::string input_help = "configuration file (YAML)";
  bool many_inputs = false;  ///< whether there may be several
  bool has_output = true;    ///< whether it has --output DIR
  std::vector<IntegerOption> integers = {};
  std::vector<FlagOption> flags = {};
  std::vector<FileOption> files = {};
  std::vector<TextOption> texts = {};
};

/// The arguments on the command line.
struct AppArguments {
  std::string input;  ///< the first of `inputs`
  std::vector<std::string> inputs;
  std::filesystem::path output;  ///< --output, else out/<stem of the input>
  bool quiet = false;
  std::map<std::string, long> integers;  ///< the given ones and those with a fallback
  std::map<std::string, bool> flags;
  std::map<std::string, std::string> files;               ///< the given ones
  std::map<std::string, std::vector<std::string>> texts;  ///< of each option: the given ones, else its fallback

  /// The text of an option that is not repeated; empty without it.
  std::string text(const std::string& name) const { return texts.at(name).empty() ? "" : texts.at(name).back(); }
};

/// A progress bar with rate and time left. It is on standard error, and only if that is a terminal.
class Progress {
 public:
  explicit Progress(bool enabled) : enabled_(enabled) {}
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// Begins a stage of `total` steps, each called `unit`. `done` of them were done earlier, and do not count for the
  /// rate.
  void start(std::string stage, std::size_t total, std::string unit = "epochs", std::size_t done = 0);
  void update(std::size_t done);
  /// Begins work of several stages that share one bar. The bar shows the current stage and the part of the whole that
  /// is done.
  void start_work();
  void go_on(std::string_view stage, double part);
  /// A callback that gets the number of steps done, first 0, and of all steps, and shows them as one stage.
  std::function<void(std::size_t, std::size_t)> counted(std::string stage, std::string unit);
  /// Removes the bar from the terminal.
  void clear();

 private:
  using Clock = std::chrono::steady_clock;
  bool is_due();
  void draw(std::string_view stage, double part, const std::string& rate, double left);
  double elapsed() const { return std::chrono::duration<double>(last_ - started_).count(); }  ///< s
  bool enabled_, drawn_ = false;
  std::string stage_, unit_;
  std::size_t total_ = 0, done_before_ = 0;
  Clock::time_point started_, last_;
};

/// Reads the command line, runs `body`, and returns the exit code: 0 done; 1 the data could not be processed; 2 wrong
/// usage or configuration. Errors go to standard error. If Ctrl-C or a scheduler ends the program, no half-written
/// output remains (EndOnSignal).
int run_app(const AppDescription& description, int argc, char** argv,
            const std::function<void(const AppArguments&, Progress&)>& body);

/// Prints a line on standard output unless --quiet.
void say(const AppArguments& arguments, const std::string& line);

}  // namespace piste
