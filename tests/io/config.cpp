#include "piste/io/config.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;

Config parse(const std::string& text) { return Config::parse(text, "folder/run.yaml"); }

template <class F>
std::string refusal(const std::string& text, F&& read) {
  return message_of<ConfigError>([&] { read(parse(text)); });
}

TEST(Config, ReadsTypedValues) {
  const Config config = parse(
      "noise: 0.05 deg/s\nlever: -0.06 0.03 -0.42 m\ngate: 0.999\nflag: true\nblocks: [a, b]\nuse: position velocity\n"
      "as_prose: a, b c\n"
      "file: ../data/imu.csv\noutages: [[100, 15], [200 s, 1 min]]\nnested: {key: 3}\nlist:\n  - {key: 1}\n  - {key: "
      "2}\n");
  EXPECT_NEAR(config.quantity("noise", dimension::kAngularRate), 0.05 / 57.29577951308232, 1e-15);
  EXPECT_EQ(config.vector("lever", dimension::kLength), Vector3d(-0.06, 0.03, -0.42));
  EXPECT_EQ(config.number("gate"), 0.999);
  EXPECT_TRUE(config.flag("flag"));
  EXPECT_EQ(config.words("blocks"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(config.words("use"), (std::vector<std::string>{"position", "velocity"}));
  EXPECT_EQ(config.words("as_prose"), (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(config.path("file"), "data/imu.csv");
  const auto outages = config.pairs("outages", dimension::kTime);
  ASSERT_EQ(outages.size(), 2u);
  EXPECT_EQ(outages[1], (std::pair<double, double>{200, 60}));
  EXPECT_EQ(config.map("nested").integer("key"), 3);
  const auto list = config.maps("list");
  EXPECT_EQ(list.at(0).integer("key") + 10 * list.at(1).integer("key"), 21);
  EXPECT_EQ(config.maps("nested").size(), 1u);
  EXPECT_TRUE(config.maps("absent").empty());
  EXPECT_EQ(config.quantity("absent", dimension::kTime, 7), 7);
  config.finish();
}

TEST(Config, RefusesARepeatedKey) {
  const std::string message = refusal("a: 1\nb:\n  c: 1\n  c: 2\n", [](const Config&) {});
  EXPECT_TRUE(contains(message, "folder/run.yaml:4: key `c`"));
  EXPECT_TRUE(contains(message, "line 3"));
}

TEST(Config, RefusesAnUnknownKeyWithTheNearestSpelling) {
  const std::string message = refusal("smother: rts\n", [](const Config& c) {
    c.text("smoother", "rts");
    c.finish();
  });
  EXPECT_TRUE(contains(message, "folder/run.yaml:1: unknown key `smother`, perhaps `smoother`"));
  const std::string inner = refusal("imu:\n  file: x\n  colour: red\n", [](const Config& c) {
    c.map("imu").text("file");
    c.finish();
  });
  EXPECT_TRUE(contains(inner, "folder/run.yaml:3: unknown key `colour`; known here are: file"));
}

TEST(Config, RefusesWhatIsMissingOrMisshapen) {
  EXPECT_TRUE(contains(refusal("imu:\n  fil: x\n", [](const Config& c) { c.map("imu").text("file"); }),
                       "folder/run.yaml:2: key `file` is missing (`fil`?)"));
  EXPECT_TRUE(contains(refusal("a:\n", [](const Config& c) { c.text("a"); }), "folder/run.yaml:1: a: has no value"));
  EXPECT_TRUE(contains(refusal("a: 1\nb: [1]\n", [](const Config& c) { c.text("b"); }), "folder/run.yaml:2: b"));
  EXPECT_TRUE(contains(refusal("a: 3\n", [](const Config& c) { c.map("a"); }), "must be a map"));
  EXPECT_TRUE(contains(refusal("a: 3.5\n", [](const Config& c) { c.integer("a"); }), "no whole number"));
  EXPECT_TRUE(contains(refusal("a: [1]\n", [](const Config& c) { c.pair("a", dimension::kTime); }), "[100 s, 15 s]"));
  EXPECT_TRUE(
      contains(refusal("a: [[1 s, 2 m]]\n", [](const Config& c) { c.pairs("a", dimension::kTime); }), "run.yaml:1"));
}

TEST(Config, RefusesAWrongUnit) {
  EXPECT_TRUE(contains(
      refusal("x: 1\nnoise: 0.05 deg/s\n", [](const Config& c) { c.quantity("noise", dimension::kGyroNoise); }),
      "folder/run.yaml:2: noise: unit `deg/s` does not measure an angular-rate noise density; right would be such as "
      "`0.05 deg/s/sqrt(Hz)`"));
  EXPECT_TRUE(contains(refusal("time: 60\n", [](const Config& c) { c.quantity("time", dimension::kTime); }),
                       "`60` has no unit; a time is expected, such as `60 s`"));
  EXPECT_TRUE(contains(refusal("time: -60 s\n", [](const Config& c) { c.magnitude("time", dimension::kTime); }),
                       "must not be negative"));
}

TEST(Config, RefusesAWordThatIsNoChoice) {
  const auto read = [](const Config& c) { return c.choice<int>("smoother", {{"none", 0}, {"rts", 1}}); };
  EXPECT_EQ(read(parse("smoother: rts\n")), 1);
  EXPECT_TRUE(
      contains(refusal("smoother: kalman\n", read), "folder/run.yaml:1: smoother: `kalman` is none of: none, rts"));
}

TEST(Config, AxesAreARightHandedSignedPermutation) {
  Matrix3d expected;
  expected << 0, 1, 0, -1, 0, 0, 0, 0, 1;
  EXPECT_EQ(parse("axes: +y -x +z\n").axes("axes"), expected);
  EXPECT_EQ(parse("axes: x y z\n").axes("axes"), Matrix3d::Identity());
  EXPECT_EQ(parse("a: 1\n").axes("axes"), Matrix3d::Identity());
  const auto read = [](const Config& c) { c.axes("axes"); };
  for (const char* bad : {"+x +y -z", "+x +x +z", "+x +y", "+a +b +c", "x y z z"}) {
    EXPECT_TRUE(contains(refusal(std::string("axes: ") + bad + "\n", read), "folder/run.yaml:1: axes")) << bad;
  }
}

TEST(Config, RefusesWhatIsNoYaml) {
  EXPECT_TRUE(contains(refusal("a: 1\nb: [1, 2\n", [](const Config&) {}), "folder/run.yaml:"));
  EXPECT_TRUE(contains(refusal("", [](const Config&) {}), "folder/run.yaml:1"));
  EXPECT_TRUE(contains(refusal(",a: 1\n", [](const Config&) {}), "one map"));
  EXPECT_TRUE(contains(refusal("a: 1\n}\nb: 2\n", [](const Config&) {}), "run.yaml:"));
  EXPECT_TRUE(contains(refusal("- 1\n", [](const Config&) {}), "one map"));
  EXPECT_TRUE(contains(refusal("a: 1\n---\nb: 2\n", [](const Config&) {}), "one map"));
}

TEST(Config, RefusesWhatWouldBurstIt) {
  const auto nothing = [](const Config&) {};
  const auto repeated = [](const std::string& text, int times) {
    std::string all;
    for (int i = 0; i < times; ++i) all += text;
    return all;
  };
  std::string multiplied = "a0: &a0 [x]\n";
  for (int i = 1; i < 30; ++i) {
    multiplied += fmt::format("a{}: &a{} [{}]\n", i, i, repeated(fmt::format("*a{}, ", i - 1), 9));
  }
  std::string keys;
  for (int i = 0; i < 30000; ++i) keys += fmt::format("k{}: 1\n", i);
  for (const std::string& text : {std::string("a: &a [*a]\n"), std::string("&a {b: *a}\n"), multiplied, keys,
                                  "a: " + repeated("[", 60) + repeated("]", 60) + "\n"}) {
    EXPECT_TRUE(contains(refusal(text, nothing), "within each other, or 20000 values in all")) << text.substr(0, 40);
  }
  EXPECT_TRUE(contains(refusal("a: " + repeated("[", 100000), nothing), "folder/run.yaml:1: no YAML"));
  EXPECT_TRUE(contains(refusal("a: " + std::string(2000000, 'x'), nothing), "run.yaml: is longer than 1000000 bytes"));
  EXPECT_TRUE(contains(message_of<ConfigError>([] { Config::load("/dev/zero"); }), "/dev/zero: is longer than"));
  EXPECT_EQ(parse("a: &a {b: 1}\nc: *a\n").map("c").integer("b"), 1) << "an alias that does not multiply";
}

TEST(Config, RefusesAMissingFile) {
  EXPECT_TRUE(
      contains(message_of<ConfigError>([] { Config::load("nowhere/run.yaml"); }), "nowhere/run.yaml: cannot be read"));
  EXPECT_TRUE(contains(refusal("a: 1\nfile: imu.csv\n", [](const Config& c) { c.existing_file("file"); }),
                       "folder/run.yaml:2: file: there is no file `folder/imu.csv`"));
}

// ---- Bases ----

class ConfigBase : public testing::Test {
 protected:
  Config load(const std::string& text) { return Config::load(folder_.write("top.yaml", text)); }
  template <class F>
  std::string refusal_of(const std::string& text, F&& read) {
    return message_of<ConfigError>([&] { read(load(text)); });
  }

  test::TemporaryFolder folder_;
};

TEST_F(ConfigBase, MapsMergeAndListsAreReplaced) {
  folder_.write("under/ground.yaml", "a: 1\nm: {x: 1, y: 1, z: {p: 1, q: 1}}\nl: [a, b]\nk: {inner: 1}\n");
  folder_.write("under/base.yaml", "base: ground.yaml\na: 2\nm: {y: 2, z: {q: 2}}\nb: 2\nk: whole\n");
  const Config config = load("base: under/base.yaml\nm:\n  z: {p: 3}\nl: [c]\nb: 3\nk: {outer: 3}\n");
  EXPECT_EQ(config.integer("a"), 2);
  EXPECT_EQ(config.integer("b"), 3);
  EXPECT_EQ(config.words("l"), std::vector<std::string>{"c"});
  const Config m = config.map("m");
  EXPECT_EQ(m.integer("x"), 1);
  EXPECT_EQ(m.integer("y"), 2);
  EXPECT_EQ(m.map("z").integer("p"), 3);
  EXPECT_EQ(m.map("z").integer("q"), 2);
  EXPECT_EQ(config.map("k").integer("outer"), 3);
  EXPECT_FALSE(config.map("k").has("inner")) << "a scalar between them";
  config.finish();
  EXPECT_TRUE(config.source().starts_with("base: under/base.yaml\nm:"));
  EXPECT_EQ(config.file().filename(), "top.yaml");
}

TEST_F(ConfigBase, ErrorsNameTheFileInWhichTheValueStands) {
  folder_.write("base.yaml", "x: 1\nimu:\n  rate: 5\n  noise: 3\nunread: 1\n");
  const std::string top = "base: base.yaml\nimu:\n\n  rate: 6\n";
  const auto number = [](const std::string& key) {
    return [key](const Config& c) { c.map("imu").quantity(key, dimension::kTime); };
  };
  EXPECT_TRUE(contains(refusal_of(top, number("rate")), "top.yaml:4: rate: `6` has no unit"));
  EXPECT_TRUE(contains(refusal_of(top, number("noise")), "base.yaml:4: noise: `3` has no unit"));
  EXPECT_TRUE(contains(refusal_of(top, number("scale")), "top.yaml:4: key `scale` is missing"));
  EXPECT_TRUE(contains(refusal_of(top,
                                  [](const Config& c) {
                                    c.number("x");
                                    c.map("imu").number("rate");
                                    c.map("imu").number("noise");
                                    c.finish();
                                  }),
                       "base.yaml:5: unknown key `unread`"));
}

TEST_F(ConfigBase, PathsStartFromTheFileInWhichTheyStand) {
  folder_.write("under/base.yaml", "near: here.csv\nfar: none.csv\nmine: here.csv\n");
  folder_.write("under/here.csv", "");
  const Config config = load("base: under/base.yaml\nmine: other.csv\n");
  EXPECT_EQ(config.existing_file("near"), folder_ / "under/here.csv");
  EXPECT_EQ(config.path("mine"), folder_ / "other.csv");
  const std::string message = message_of<ConfigError>([&] { config.existing_file("far"); });
  EXPECT_TRUE(contains(message, "under/base.yaml:2: far: there is no file"));
  EXPECT_TRUE(contains(message, "relative to the folder of " + (folder_ / "under/base.yaml")));
}

TEST_F(ConfigBase, RefusesACircleAndWhatIsNoFile) {
  const auto nothing = [](const Config&) {};
  folder_.write("under/a.yaml", "x: 1\nbase: ../top.yaml\n");
  EXPECT_TRUE(contains(refusal_of("base: under/a.yaml\n", nothing), "under/a.yaml:2: base: "));
  EXPECT_TRUE(contains(refusal_of("base: under/a.yaml\n", nothing), "builds on this file itself"));
  EXPECT_TRUE(contains(refusal_of("x: 1\nbase: top.yaml\n", nothing), "top.yaml:2: base: "));
  EXPECT_TRUE(contains(refusal_of("x: 1\nbase: none.yaml\n", nothing), "top.yaml:2: base: there is no file"));
  EXPECT_TRUE(contains(refusal_of("base: [a.yaml]\n", nothing), "top.yaml:1: base: must be a single value"));
  folder_.write("bad.yaml", "x: [1\n");
  EXPECT_TRUE(contains(refusal_of("base: bad.yaml\n", nothing), "bad.yaml:"));
  EXPECT_TRUE(contains(refusal_of("bse: bad.yaml\n", [](const Config& c) { c.finish(); }),
                       "unknown key `bse`, perhaps `base`"));
}

// Text that was made of a program's arguments: its lines say nothing to who has not written it.
TEST_F(ConfigBase, KeysMayHaveNamesInsteadOfLines) {
  folder_.write("base.yaml", "far: {x: 1}\nown: 1 s\n");
  const auto name = [](const std::string& path) { return path.empty() ? "all" : "<" + path + ">"; };
  const auto refused = [&](const std::string& text, const auto& read) {
    const Config config = Config::parse(text, folder_ / "words", {}, name);
    return message_of<ConfigError>([&] { read(config); });
  };
  const auto quantity = [](const Config& c) { c.quantity("time", dimension::kTime); };
  EXPECT_TRUE(refused("time: 1 m\n", quantity).starts_with("<time>: unit `m`")) << refused("time: 1 m\n", quantity);
  EXPECT_TRUE(refused("x: 1\n", quantity).starts_with("all: key `time` is missing"));
  EXPECT_TRUE(refused("imu: {clock: {time: 1 m}}\n", [&](const Config& c) {
                quantity(c.map("imu").map("clock"));
              }).starts_with("<imu.clock.time>: "));
  EXPECT_TRUE(refused("gnss: [{file: a}, {file: b}]\n", [](const Config& c) {
                c.maps("gnss")[1].existing_file("file");
              }).starts_with("<gnss[1].file>: there is no file"));
  EXPECT_TRUE(refused("smother: 1\n", [](const Config& c) { c.finish(); }).starts_with("<smother>: unknown key"));
  // What stands in a file keeps its place there.
  const std::string base = "base: " + yaml_text(folder_ / "base.yaml") + "\n";
  EXPECT_TRUE(
      contains(refused(base, [](const Config& c) { c.quantity("own", dimension::kLength); }), "base.yaml:2: own: "));
}

TEST(ConfigText, ReadsBackAsItIs) {
  using namespace std::string_literals;
  for (const std::string& text :
       {""s, "plain"s, "it's: {odd} # \\ \"quoted\""s, "two\nlines\n\n'and' a \"third\" \\ \t"s, " ends with spaces  "s,
        "\x01\x7F"s, "é"s}) {
    EXPECT_EQ(Config::parse("key: " + yaml_text(text) + "\n", "a.yaml").text("key"), text);
  }
}

}  // namespace
}  // namespace piste
