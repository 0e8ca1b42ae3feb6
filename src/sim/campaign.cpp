#include "piste/sim/campaign.h"

#include <fmt/format.h>

#include <set>

#include "io/json.h"
#include "piste/configuration/sensor_file.h"
#include "piste/io/config.h"
#include "piste/math/units.h"
#include "piste/sim/random.h"
#include "piste/sim/simulation.h"
#include "sim/names.h"

namespace piste {
namespace {

constexpr const char* kSensorFolder = "sensors";
constexpr const char* kArticleFolder = "articles";

// The path of an IMU's sensor file, relative to the campaign file.
std::string sensor_path(const ImuSetup& imu) {
  return fmt::format("{}/{}", kSensorFolder, imu.sensor_file.filename().string());
}

// The text of a sensor file. A file that builds on another is written anew, as that other file is not copied.
std::string standing_alone(const ImuSetup& imu) {
  const Config file = Config::load(imu.sensor_file);
  return file.has("base") ? sensor_text(imu.sensor) : file.source();
}

// Keeps the sensor file of an IMU. Two different files must not have the same name.
void keep_sensor(std::map<std::string, std::string>& sensors, const Config& run, const ImuSetup& imu) {
  const std::string text = standing_alone(imu);
  const auto [kept, is_new] = sensors.emplace(sensor_path(imu), text);
  if (!is_new && kept->second != text) {
    run.fail("scenario", fmt::format("`{}` has another content than the sensor file of that name in a run above; "
                                     "both go to one folder, so rename one",
                                     imu.sensor_file.string()));
  }
}

// Reads a name for a table and for a folder of the study.
std::string read_label(const Config& config, std::string_view key) {
  std::string label = config.text(key);
  if (label.empty() || label.find_first_of(",/\\\n") != std::string::npos) {
    config.fail(key, "names files and rows of tables; some words without comma and slash are expected");
  }
  return label;
}

struct MemsNames {
  std::vector<std::string> imus, names;
  std::vector<std::pair<std::string, std::string>> article_sensors;  // name, and that of the article
};

MemsNames read_mems(const Config& config) {
  const bool with_article = config.has("article");
  MemsNames mems;
  std::set<std::string> imus, names;
  for (const Config& entry : config.maps("mems")) {
    mems.imus.push_back(entry.text("imu"));
    mems.names.push_back(read_label(entry, "name"));
    if (!imus.insert(mems.imus.back()).second) entry.fail("imu", fmt::format("`{}` stands twice", mems.imus.back()));
    if (!names.insert(mems.names.back()).second) {
      entry.fail("name", fmt::format("`{}` is taken; give each a name of its own", mems.names.back()));
    }
    if (with_article && entry.has("article_sensor")) {
      mems.article_sensors.emplace_back(mems.names.back(), entry.text("article_sensor"));
    }
  }
  if (mems.imus.empty()) config.fail("mems", "name at least one IMU, such as `- {imu: mt9a_1, name: MT-9A 1}`");
  if (imus.contains(config.text("reference"))) {
    config.fail("reference", "stands among `mems` as well; an IMU is not compared with itself");
  }
  return mems;
}

// The article with which the study is compared, copied along with the logs.
std::optional<CampaignArticle> read_article(const Config& config, const MemsNames& mems,
                                            std::map<std::string, std::string>& files) {
  if (!config.has("article")) return std::nullopt;
  const Config file = Config::load(config.existing_file("article"));
  if (file.has("base")) config.fail("article", "builds on another file; the campaign takes one that stands alone");
  CampaignArticle article{fmt::format("{}/{}", kArticleFolder, file.file().filename().string()), mems.article_sensors};
  files.emplace(article.path, file.source());
  return article;
}

CampaignRun read_run(const Config& config, const Config& run, const MemsNames& mems, std::set<std::string>& names) {
  CampaignRun r;
  r.name = claim_name(names, run);
  r.activity = read_label(run, "activity");
  r.scenario = read_scenario(run.existing_file("scenario"));
  if (const auto motion = run.find_map("motion")) r.scenario.motion = read_motion(*motion, r.scenario.motion);

  const std::string& file = r.scenario.file;
  r.reference = place_of(config, "reference", config.text("reference"), r.scenario.imus, file);
  r.gnss = place_of(config, "gnss", config.text("gnss"), r.scenario.gnss, file);
  for (const std::string& imu : mems.imus) r.mems.push_back(place_of(config, "mems", imu, r.scenario.imus, file));
  return r;
}

// An entry of campaign.yaml, on one line.
std::string imu_entry(const CampaignRun& run, std::size_t imu, const std::string& name = "") {
  const ImuSetup& setup = run.scenario.imus[imu];
  return fmt::format("{{{}file: {}/{}.csv, format: csv, sensor: {}, axes: +x +y +z, sampling: {}}}",
                     name.empty() ? "" : fmt::format("name: {}, ", json::string(name)), run.name, setup.name,
                     sensor_path(setup), setup.sampling == ImuSetup::Sampling::kInstant ? "instant" : "mean");
}

std::string gnss_entry(const CampaignRun& run) {
  const GnssSetup& setup = run.scenario.gnss[run.gnss];
  const Vector3d arm = lever_arm(run.scenario.imus[run.reference], setup).array() + 0.0;  // no −0
  return fmt::format("{{file: {}/{}.csv, format: csv, lever_arm: {:.9g} {:.9g} {:.9g} m}}", run.name, setup.name,
                     arm.x(), arm.y(), arm.z());
}

std::string article_lines(const CampaignArticle& article) {
  std::string text = fmt::format("article: {}\n", json::string(article.path));
  if (article.sensors.empty()) return text;
  text += "article_sensors:\n";
  for (const auto& [ours, its] : article.sensors) {
    text += fmt::format("  {}: {}\n", json::string(ours), json::string(its));
  }
  return text;
}

}  // namespace

bool is_campaign(const std::filesystem::path& file) { return Config::load(file).has("runs"); }

Campaign read_campaign(const std::filesystem::path& file) { return read_campaign(Config::load(file)); }

Campaign read_campaign(const Config& config) {
  Campaign c;
  const long seed = config.integer("seed", 1);
  if (seed < 0) config.fail("seed", "must not be negative");
  c.seed = static_cast<std::uint64_t>(seed);
  c.low_pass = config.quantity("low_pass", dimension::kFrequency);
  if (!(c.low_pass > 0)) config.fail("low_pass", "must be above zero, such as `12 Hz`");
  const MemsNames mems = read_mems(config);
  c.mems = mems.names;

  std::set<std::string> names{kSensorFolder, kArticleFolder};
  for (const Config& run : config.maps("runs")) {
    const CampaignRun& r = c.runs.emplace_back(read_run(config, run, mems, names));
    keep_sensor(c.files, run, r.scenario.imus[r.reference]);
    for (const std::size_t imu : r.mems) keep_sensor(c.files, run, r.scenario.imus[imu]);
  }
  c.article = read_article(config, mems, c.files);
  if (c.runs.empty()) config.fail("runs", "name at least one run, with its activity and its scenario");
  config.finish();
  return c;
}

std::uint64_t run_seed(std::uint64_t campaign_seed, const std::string& run) {
  return static_cast<std::uint64_t>(0x1p32 * RandomStream(campaign_seed, run).uniform());
}

std::string campaign_text(const Campaign& campaign, std::uint64_t seed) {
  std::string text = fmt::format(
      "# A simulated campaign, seed {}. Files are relative to this one.\n"
      "low_pass: {}\n",
      seed, format_quantity(campaign.low_pass, "Hz", dimension::kFrequency));
  if (campaign.article) text += article_lines(*campaign.article);
  text += "runs:\n";
  for (const CampaignRun& run : campaign.runs) {
    text += fmt::format(
        "  - name: {0}\n"
        "    activity: {1}\n"
        "    reference: {2}\n"
        "    gnss: {3}\n"
        "    phases: auto\n"
        "    truth: {0}/truth.json\n"
        "    mems:\n",
        run.name, json::string(run.activity), imu_entry(run, run.reference), gnss_entry(run));
    for (std::size_t i = 0; i < run.mems.size(); ++i) {
      text += fmt::format("      - {}\n", imu_entry(run, run.mems[i], campaign.mems[i]));
    }
  }
  return text;
}

}  // namespace piste
