#pragma once
/// Simulated campaigns: several runs with the same instruments, for `study`. The file of a campaign:
/// ```yaml
/// seed: 2008                    # of all that is random; every run gets its own from it
/// low_pass: 12 Hz               # of the signals, in the study
/// reference: ln200              # the IMU that the others are compared with
/// gnss: gnss_l1l2               # the receiver of the reference solution
/// mems:                         # the IMUs that are compared, and what the tables call them
///   - {imu: mt9a_1, name: MT-9A 1, article_sensor: sensor 1}   # and the article's sensor to compare with
/// article: ../articles/bonnaz_2008.yaml     # optional: the study is compared with it; a copy goes with the logs
/// runs:                         # each in a folder of its name; its motion is laid over that of its scenario
///   - {name: ski-1, activity: ski, scenario: campaign/ski.yaml}
///   - {name: ski-2, activity: ski, scenario: campaign/ski.yaml, motion: {heading: 120 deg, net_turn: -300 deg}}
/// ```
/// How the errors of the IMUs change from run to run stands in the scenarios: `bias_spread` and `scale_spread` of their
/// IMUs.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "piste/sim/scenario.h"

namespace piste {

/// One run of a campaign.
struct CampaignRun {
  std::string name, activity;
  Scenario scenario;              ///< with the motion of this run
  std::size_t reference = 0;      ///< of Scenario::imus
  std::size_t gnss = 0;           ///< of Scenario::gnss
  std::vector<std::size_t> mems;  ///< of Scenario::imus, in the order of Campaign::mems
};

/// An article with which the study is compared, as campaign.yaml names it.
struct CampaignArticle {
  std::string path;                                          ///< from campaign.yaml
  std::vector<std::pair<std::string, std::string>> sensors;  ///< ours, and that of the article to compare with
};

/// A campaign.
struct Campaign {
  std::uint64_t seed = 1;
  double low_pass = 0;            ///< [Hz]
  std::vector<std::string> mems;  ///< what the tables call them
  std::vector<CampaignRun> runs;  ///< one at least
  std::optional<CampaignArticle> article;
  std::map<std::string, std::string> files;  ///< texts of sensor files and article, by their paths from campaign.yaml
};

/// Whether the file describes a campaign, which has `runs:`, and not a scenario. Throws ConfigError if it is not YAML.
bool is_campaign(const std::filesystem::path& file);

/// Reads a campaign and the scenarios of its runs. Every error is a ConfigError `FILE:LINE: …`.
Campaign read_campaign(const std::filesystem::path& file);
Campaign read_campaign(const Config& config);

/// The seed of a run, from the seed of the campaign and the run's name. It is below 2³², so that every JSON reader can
/// represent it.
std::uint64_t run_seed(std::uint64_t campaign_seed, const std::string& run);

/// The text of the campaign file for `study`. Next to that file are a folder for each run with its logs and truth.json,
/// the folder `sensors` with the sensor files, and the folder `articles` with the article.
std::string campaign_text(const Campaign& campaign, std::uint64_t seed);

}  // namespace piste
