// docs/requirements.md: each promise names the tests that show it, and they stand in the sources. Names are read from
// the macros of GoogleTest, from add_test of tests/CMakeLists.txt and from `def test_` of the Python package, so that
// the page is judged without building a test. A parameter counts if its file has it in quotation marks.

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "support/ctest_list.h"
#include "support/places.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

namespace fs = std::filesystem;

/// A row of the page: a promise, and the tests in its last cell.
struct Promise {
  std::string text;
  std::vector<std::string> tests;
};

/// All tests of the sources, without parameters, each with the text in which a parameter would stand.
using KnownTests = std::map<std::string, std::string>;

std::vector<std::smatch> matches(const std::string& text, const std::regex& pattern) {
  return {std::sregex_iterator(text.begin(), text.end(), pattern), std::sregex_iterator()};
}

std::vector<Promise> promises_of(const std::string& page) {
  static const std::regex row(R"(^\| (.*) \|(.*)\|$)", std::regex::multiline), name("`([^`]+)`");
  std::vector<Promise> all;
  for (const std::smatch& match : matches(page, row)) {
    if (match[1] == "promise") continue;  // the head of a table
    const std::string cell = match[2];
    Promise promise{.text = match[1], .tests = {}};
    for (const std::smatch& test : matches(cell, name)) promise.tests.push_back(test[1]);
    all.push_back(promise);
  }
  return all;
}

/// Adds the tests of a source, as ctest calls them: FOLDER/FILE.Suite.Case.
void add_cases(const std::string& file, const std::string& source, KnownTests& known) {
  static const std::regex comment(R"(^\s*//.*$)", std::regex::multiline),
      test(R"(^TEST(_F|_P)?\(\s*(\w+),\s*(\w+)\))", std::regex::multiline),
      prefix(R"(^INSTANTIATE_TEST_SUITE_P\(\s*(\w+),\s*(\w+),)", std::regex::multiline);
  const std::string text = std::regex_replace(source, comment, "");
  std::multimap<std::string, std::string> prefixes;
  for (const std::smatch& match : matches(text, prefix)) prefixes.emplace(match[2], match[1]);
  for (const std::smatch& match : matches(text, test)) {
    const std::string suite = match[2], name = suite + "." + match[3].str();
    if (match[1] != "_P") known[file + "." + name] = text;
    const auto [begin, end] =
        match[1] == "_P" ? prefixes.equal_range(suite) : std::pair(prefixes.end(), prefixes.end());
    for (auto each = begin; each != end; ++each) known[file + "." + each->second + "/" + name] = text;
  }
}

KnownTests tests_of_sources() {
  KnownTests known;
  const std::string list = read_text(kSource / "tests/CMakeLists.txt");
  static const std::regex call(R"(piste_(?:batch_)?tests\((\w+) \w+ ([\w\s]+)\))"), word(R"(\w+)"),
      script(R"(add_test\(NAME ([\w./]+))"), python(R"(^def (test_\w+)\()", std::regex::multiline);
  for (const std::smatch& match : matches(list, call)) {
    const std::string folder = match[1], files = match[2];
    for (const std::smatch& name : matches(files, word)) {
      const std::string file = folder + "/" + name[0].str();
      add_cases(file, read_text(kSource / "tests" / (file + ".cpp")), known);
    }
  }
  for (const std::smatch& match : matches(list, script)) known[match[1]] = "";
  for (const auto& entry : fs::directory_iterator(kSource / "python/tests")) {
    const std::string text = read_text(entry.path());
    for (const std::smatch& match : matches(text, python)) {
      known["python/tests/" + entry.path().filename().string() + "::" + match[1].str()] = text;
    }
  }
  return known;
}

/// FOLDER/FILE.Prefix/Suite.Case/PARAMETER as the name without its parameter, and the parameter.
std::pair<std::string, std::string> parted(const std::string& name) {
  const auto slash = name.find('/', name.rfind('.'));
  if (slash == std::string::npos || name.starts_with("python/")) return {name, ""};
  return {name.substr(0, slash), name.substr(slash + 1)};
}

bool exists(const std::string& name, const KnownTests& known) {
  if (name.starts_with("scripts/")) return fs::exists(kSource / name);
  const auto [test, parameter] = parted(name);
  const auto found = known.find(test);
  return found != known.end() && (parameter.empty() || contains(found->second, "\"" + parameter + "\""));
}

/// What is wrong with a page: one line a row without a test, and one a test that does not exist.
std::vector<std::string> faults_of(const std::string& page, const KnownTests& known) {
  std::vector<std::string> faults;
  for (const Promise& promise : promises_of(page)) {
    if (promise.tests.empty()) faults.push_back("no test shows: " + promise.text);
    for (const std::string& test : promise.tests) {
      if (!exists(test, known)) faults.push_back("there is no test " + test + ", which is to show: " + promise.text);
    }
  }
  return faults;
}

TEST(Requirements, EachHasTestsThatExist) {
  const std::string page = read_text(kSource / "docs/requirements.md");
  EXPECT_GE(promises_of(page).size(), 100U);
  for (const std::string& fault : faults_of(page, tests_of_sources())) ADD_FAILURE() << fault;
}

// A program that nobody promises anything of is one whose contract was forgotten.
TEST(Requirements, NameEveryProgram) {
  const std::string page = read_text(kSource / "docs/requirements.md");
  const fs::path apps = kSource / "apps";
  int programs = 0;
  for (const auto& entry : fs::directory_iterator(apps)) {
    const std::string name = entry.path().stem().string();
    if (entry.path().extension() != ".cpp" || fs::exists(apps / (name + ".h"))) continue;
    ++programs;
    EXPECT_TRUE(contains(page, "| `" + name) || contains(page, "## " + name + "\n") || name == "replay") << name;
  }
  EXPECT_GE(programs, 10);
}

// What is read from the sources is what ctest runs.
TEST(Requirements, SeeTheTestsThatCtestSees) {
  const std::string list = ctest_list();
  if (contains(list, "_NOT_BUILT")) GTEST_SKIP() << "build every test first: ctest does not know them all";
  const KnownTests known = tests_of_sources();
  static const std::regex line(R"(Test +#\d+: ([a-z_]+/[a-z_0-9]+\.\S+))");
  std::set<std::string> listed;
  for (const std::smatch& match : matches(list, line)) listed.insert(parted(match[1]).first);
  EXPECT_GE(listed.size(), 500U);
  for (const std::string& test : listed) EXPECT_TRUE(known.contains(test)) << test;
}

TEST(Requirements, CatchWhatIsWrong) {
  KnownTests known;
  add_cases("app/a",
            "TEST(A, Holds) {}\nTEST_F(A, HoldsToo) {}\n// TEST(A, IsNoMore) {}\nTEST_P(B, Is) {}\n"
            "TEST_P(C, IsNever) {}\nINSTANTIATE_TEST_SUITE_P(\n    All, B, Values(\"Here\"));\n",
            known);
  const auto faults = [&](const std::string& cell) {
    return faults_of("| promise | shown by |\n|---|---|\n| it holds |" + cell + "|\n", known).size();
  };
  EXPECT_EQ(faults(" `app/a.A.Holds`, `app/a.A.HoldsToo`, `app/a.All/B.Is`, `app/a.All/B.Is/Here` "), 0U);
  EXPECT_EQ(faults(" "), 1U) << "no test";
  EXPECT_EQ(faults(" app/a.A.Holds "), 1U) << "no name";
  EXPECT_EQ(faults(" `app/a.A.IsNoMore` "), 1U) << "commented out";
  EXPECT_EQ(faults(" `app/a.B.Is` "), 1U) << "a parameterised test is run under its prefix";
  EXPECT_EQ(faults(" `app/a.All/B.Is/There` "), 1U) << "a parameter that is not there";
  EXPECT_EQ(faults(" `app/a.All/C.IsNever` "), 1U) << "never instantiated";
  EXPECT_EQ(faults(" `scripts/nothing` "), 1U) << "no script";
}

}  // namespace
}  // namespace piste::test
