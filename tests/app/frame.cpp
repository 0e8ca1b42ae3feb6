#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <stdexcept>

#include "app.h"
#include "piste/core/error.h"
#include "piste/files/output.h"
#include "support/text_file.h"

namespace piste {
namespace {

/// Runs an empty program on a command line; what the body saw is in `seen`.
int run(
    std::vector<std::string> words, AppArguments& seen, const std::function<void()>& body = [] {}) {
  words.insert(words.begin(), "demo");
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  const AppDescription demo{
      .name = "demo", .summary = "A demo.", .integers = {{.name = "seed", .help = "", .fallback = 1}}};
  return run_app(demo, static_cast<int>(argv.size()), argv.data(), [&](const AppArguments& arguments, Progress&) {
    seen = arguments;
    body();
  });
}

TEST(App, TakesItsArguments) {
  AppArguments seen;
  EXPECT_EQ(run({"folder/run.yaml"}, seen), 0);
  EXPECT_EQ(seen.input, "folder/run.yaml");
  EXPECT_EQ(seen.output, "out/run");
  EXPECT_EQ(seen.integers.at("seed"), 1);
  EXPECT_EQ(run({"run.yaml", "--output", "there", "--quiet", "--seed", "7"}, seen), 0);
  EXPECT_EQ(seen.output, "there");
  EXPECT_TRUE(seen.quiet);
  EXPECT_EQ(seen.integers.at("seed"), 7);
}

// It is built as `replay` and installed as `piste-replay`: its help says what the user has typed.
TEST(App, KnowsTheNameItIsCalledBy) {
  const auto help_of = [](std::string called) {
    std::string flag = "--help";
    std::vector<char*> argv{called.data(), flag.data()};
    testing::internal::CaptureStdout();
    run_app({.name = "demo", .summary = "A demo."}, 2, argv.data(), [](const AppArguments&, Progress&) {});
    return testing::internal::GetCapturedStdout();
  };
  EXPECT_NE(help_of("/usr/bin/piste-demo").find("Usage: piste-demo [OPTIONS] CONFIG"), std::string::npos);
  EXPECT_NE(help_of("demo").find("Usage: demo "), std::string::npos);
  EXPECT_NE(help_of("").find("Usage: demo "), std::string::npos);
  EXPECT_NE(help_of("demo").find("Exit status:"), std::string::npos);
}

TEST(App, ExitCodes) {
  AppArguments seen;
  EXPECT_EQ(run({"--help"}, seen), 0);
  EXPECT_EQ(run({"--version"}, seen), 0);
  EXPECT_EQ(run({}, seen), 2);
  EXPECT_EQ(run({"a", "b"}, seen), 2);
  EXPECT_EQ(run({"a", "--sed", "1"}, seen), 2);
  EXPECT_EQ(run({"a", "--seed", "-1"}, seen), 2);
  EXPECT_EQ(run({"a", "--seed", "18446744073709551615"}, seen), 2);  // not clipped
  EXPECT_EQ(run({"a"}, seen, [] { throw ConfigError("f:1", "wrong"); }), 2);
  EXPECT_EQ(run({"a"}, seen, [] { throw DataError("f:1", "wrong"); }), 1);
  EXPECT_EQ(run({"a"}, seen, [] { throw std::runtime_error("wrong"); }), 1);
}

// Asked to end, it removes what it has begun, and ends by the signal, as a shell expects.
TEST(AppDeathTest, EndsWithoutHalfWrittenFiles) {
  const test::TemporaryFolder place;
  const std::filesystem::path before = place.path() / "before", made = place.path() / "made" / "below";
  std::filesystem::create_directories(before / "others");
  const std::filesystem::path of_others = before / "others" / ".whole.csv.piste.partial";  // of another program
  std::ofstream(of_others) << "3\n";
  const auto asked = [](int signal, const std::filesystem::path& folder) {
    std::string name = "demo", input = "a", option = "--output", output = folder.string();
    std::vector<char*> argv{name.data(), input.data(), option.data(), output.data()};
    run_app({.name = "demo", .summary = "A demo."}, 4, argv.data(), [&](const AppArguments& arguments, Progress&) {
      OutputFolder files(arguments.output);
      files.write("whole.csv", "1\n");
      files.write("further/whole.csv", "2\n");
      kill(getpid(), signal);
      pause();
    });
  };
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    for (const auto& folder : {before, made}) {
      EXPECT_EXIT(asked(signal, folder), testing::KilledBySignal(signal), "") << signal;
    }
    EXPECT_TRUE(std::filesystem::exists(of_others));
    EXPECT_EQ(std::distance(std::filesystem::directory_iterator(before), {}), 1);
    EXPECT_FALSE(std::filesystem::exists(made.parent_path()));
  }
}

TEST(App, AfterItSignalsAreAsBefore) {
  AppArguments seen;
  sigset_t before, after;
  pthread_sigmask(SIG_BLOCK, nullptr, &before);
  EXPECT_EQ(run({"a"}, seen), 0);
  pthread_sigmask(SIG_BLOCK, nullptr, &after);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
    EXPECT_EQ(sigismember(&after, signal), sigismember(&before, signal));
  }
}

}  // namespace
}  // namespace piste
