// The files of a study: the columns to the letter, and the numbers read again.

#include "piste/files/study.h"

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "piste/math/units.h"
#include "piste/report/study_text.h"
#include "piste/study/ranking.h"
#include "piste/study/study_tables.h"
#include "support/study_case.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::StudyCase;

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> out;
  std::string field;
  bool quoted = false;
  for (const char c : text) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == separator && !quoted) {
      out.push_back(field);
      field.clear();
    } else {
      field += c;
    }
  }
  out.push_back(field);
  return out;
}

// A CSV file, read without the library.
struct Table {
  std::string header;
  std::vector<std::map<std::string, std::string>> rows;
};

Table read(const std::vector<StudyFile>& files, const std::string& name) {
  const auto file = std::ranges::find(files, name, &StudyFile::name);
  if (file == files.end()) {
    ADD_FAILURE() << name << " is not there";
    return {};
  }
  EXPECT_TRUE(file->content.ends_with('\n'));
  std::istringstream in(file->content);
  Table out;
  std::getline(in, out.header);
  const auto names = split(out.header, ',');
  for (std::string line; std::getline(in, line);) {
    const auto fields = split(line, ',');
    EXPECT_EQ(fields.size(), names.size()) << name << ": " << line;
    auto& row = out.rows.emplace_back();
    for (std::size_t i = 0; i < std::min(names.size(), fields.size()); ++i) row[names[i]] = fields[i];
  }
  return out;
}

const Study& whole() {
  static const Study study = StudyCase{}.study();
  return study;
}
const std::vector<StudyFile>& files() {
  static const std::vector<StudyFile> written = study_csv(whole());
  return written;
}

void expect_number(const std::string& field, double value) {
  ASSERT_FALSE(field.empty());
  EXPECT_NEAR(std::stod(field), value, 1e-8 * std::abs(value));
}

TEST(StudyCsv, HasTheColumnsOfTheContract) {
  const std::map<std::string, std::pair<std::string, std::size_t>> contract{
      {"table_1.csv", {"sensor,axis,unit,bias,std,standard_error,p_value,significant", 18}},
      {"table_2.csv", {"sensor,axis,unit,before,after,difference,p_value", 18}},
      {"table_3.csv", {"sensor,axis,unit,value,std,standard_error,p_value,reverse_value", 18}},
      {"table_4.csv", {"sensor,axis,unit,value,std,standard_error,p_value,reverse_value", 18}},
      {"table_5.csv", {"sensor,axis,correlation", 18}},
      {"table_6.csv", {"sensor,axis,unit,bias,std,standard_error,p_value,significant", 18}},
      {"table_7.csv",
       {"method,estimates,position_rmse_m,velocity_rmse_m_s,attitude_rmse_deg,outage_drift_m,remark", 25}},
      {"filter_bias.csv", {"sensor,axis,unit,bias,std,standard_error,p_value,significant", 18}},
      {"cross_axis.csv", {"sensor,axis,element,value,std,standard_error,p_value", 3 * 9}},
      {"scale_scatter.csv", {"sensor,axis,runs,std_alone,std_with_cross_axis,explained", 18}},
      {"estimates.csv",
       {"run,sensor,axis,unit,method,quantity,value,sigma,standard_error,systematic,half_width_95,truth",
        27 * 6 * (3 + 2 * 20)}},
      {"comparisons.csv",
       {"sensor,axis,quantity,unit,method,against,runs,difference,std,standard_error,p_value,p_holm",
        18 * (23 * 22 / 2 + 20 * 19 / 2)}},
      {"coverage.csv", {"method,quantity,triad,inside,all,rate,worst", 3 * 2 + 19 * 4}},
      {"timing.csv", {"delay_ms,axis,forward,forward_standard_error,reverse,reverse_standard_error", 7 * 6}},
      {"phases.csv", {"run,activity,phase,start_s,end_s", 27}}};
  EXPECT_EQ(files().size(), contract.size());
  for (const auto& [name, expected] : contract) {
    const Table table = read(files(), name);
    EXPECT_EQ(table.header, expected.first) << name;
    EXPECT_EQ(table.rows.size(), expected.second) << name;
  }
}

TEST(StudyCsv, HasTheNumbersOfTheTables) {
  const Table first = read(files(), "table_1.csv"), alone = read(files(), "table_6.csv"),
              filter = read(files(), "filter_bias.csv");
  for (const auto& [table, method] :
       {std::pair{&first, Method::kRest}, {&alone, Method::kBiasOnly}, {&filter, Method::kMarkovSmoothed}}) {
    const auto rows = table_of(whole(), method, StudyQuantity::kBias);
    for (std::size_t i = 0; i < 18; ++i) {
      auto row = table->rows[i];
      EXPECT_EQ(row["sensor"], whole().sensors[i / 6]);
      EXPECT_EQ(row["axis"], kSignalNames[i % 6]);
      EXPECT_EQ(row["unit"], i % 6 < 3 ? "m/s^2" : "deg/s");
      expect_number(row["bias"], rows[i].value.mean);
      expect_number(row["std"], rows[i].value.std);
      expect_number(row["standard_error"], rows[i].value.standard_error);
      expect_number(row["p_value"], rows[i].value.p_value);
      EXPECT_EQ(row["significant"], rows[i].value.significant ? "1" : "0");
    }
  }
  auto second = read(files(), "table_2.csv").rows[4];
  const BeforeAfterRow change = before_after(whole())[4];
  expect_number(second["before"], change.before);
  expect_number(second["after"], change.after);
  expect_number(second["difference"], change.difference.mean);
  expect_number(second["p_value"], change.difference.p_value);
  const auto scales = table_of(whole(), Method::kJoint, StudyQuantity::kScale);
  auto fourth = read(files(), "table_4.csv").rows[7];
  EXPECT_EQ(fourth["unit"], "1");
  expect_number(fourth["value"], scales[7].value.mean);
  expect_number(fourth["reverse_value"], scales[7].reverse);
  EXPECT_EQ(read(files(), "table_3.csv").rows[5]["unit"], "deg/s");
  expect_number(read(files(), "table_5.csv").rows[0]["correlation"], correlations(whole())[0].correlation);
}

TEST(StudyCsv, HasTheSignOfACorrection) {
  Study study = whole();
  for (SensorRun& r : study.results) {
    const auto found = std::ranges::find(r.estimates, Method::kRest, &MethodEstimate::method);
    found->axes[3].bias_alone->value = 0.5 / kDegreesPerRadian;  // the sensor adds half a degree a second
  }
  EXPECT_DOUBLE_EQ(std::stod(read(study_csv(study), "table_1.csv").rows[3]["bias"]), -0.5);
}

TEST(StudyCsv, HasEveryNumberOfEveryRun) {
  const Table table = read(files(), "estimates.csv");
  const SensorRun& r = whole().results[4];  // second run, second IMU
  int seen = 0;
  for (auto row : table.rows) {
    if (row["run"] != "ski-2" || row["sensor"] != "MT-9A 2" || row["axis"] != "wy") continue;
    ++seen;
    EXPECT_TRUE(row["method"] != "rest" || row["quantity"] == "bias");
    if (row["method"] != "joint" || row["quantity"] != "bias") continue;
    const AxisEstimate& e = *r.estimate(Method::kJoint, 4);
    const Term bias = *shown(e, StudyQuantity::kBias, 4);
    EXPECT_EQ(row["unit"], "deg/s");
    expect_number(row["value"], bias.value);
    expect_number(row["sigma"], bias.sigma);
    expect_number(row["standard_error"], bias.standard_error);
    expect_number(row["systematic"], bias.systematic);
    expect_number(row["half_width_95"], bias.half_width(0.95));
    expect_number(row["truth"], *shown_truth(e, StudyQuantity::kBias, 4));
  }
  EXPECT_EQ(seen, 3 + 2 * 20);
}

TEST(StudyCsv, LeavesFieldsEmptyWhereThereIsNoNumber) {
  const auto of_one = study_csv(StudyCase{.runs = 1, .sensors = 1, .simulated = false}.study());
  auto row = read(of_one, "table_1.csv").rows[0];
  EXPECT_EQ(row["std"], "");
  EXPECT_NE(row["standard_error"], "");
  EXPECT_EQ(read(of_one, "estimates.csv").rows[0]["truth"], "");
  EXPECT_EQ(read(of_one, "timing.csv").rows[0]["forward_standard_error"], "");
  EXPECT_TRUE(read(of_one, "coverage.csv").rows.empty());
  for (const StudyFile& f : of_one) {
    for (const char* wrong : {"nan", "inf,"}) EXPECT_FALSE(contains(f.content, wrong)) << f.name;
  }
  for (const StudyFile& f : study_csv(Study{})) EXPECT_EQ(std::ranges::count(f.content, '\n'), 1) << f.name;
}

TEST(StudyCsv, QuotesNamesThatHoldAComma) {
  Study study = StudyCase{.runs = 2, .sensors = 1}.study();
  study.sensors[0] = "MT-9A, left";
  const auto row = read(study_csv(study), "table_1.csv").rows[0];
  EXPECT_EQ(row.at("sensor"), "MT-9A, left");
}

TEST(TableSeven, TellsRanksFromTheResults) {
  auto rows = read(files(), "table_7.csv").rows;
  const Ranking found = ranking(whole());
  std::map<std::string, std::string> remark;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    remark[rows[i]["method"]] = rows[i]["remark"];
    expect_number(rows[i]["position_rmse_m"], found.rows[i].position_rmse);
    expect_number(rows[i]["velocity_rmse_m_s"], found.rows[i].velocity_rmse);
    expect_number(rows[i]["attitude_rmse_deg"], kDegreesPerRadian * found.rows[i].attitude_rmse);
    expect_number(rows[i]["outage_drift_m"], found.rows[i].outage_drift);
  }
  EXPECT_EQ(rows[1]["estimates"], "bias");
  EXPECT_TRUE(contains(remark["gauss_markov_smoothed"], "winner: 25"));
  EXPECT_TRUE(contains(remark["gauss_markov_smoothed"], "better than rest; wins 100 % of the resamplings"));
  EXPECT_TRUE(contains(remark["rest"], "% worse than the winner (p < 0.001)"));
  EXPECT_FALSE(contains(remark["rest"], "correlation")) << "it has no scale";
  EXPECT_TRUE(contains(remark["joint"], "; correlation of bias and scale 0.98 on fz"));
  EXPECT_TRUE(contains(remark["nothing"], "does not compete; "));
  EXPECT_TRUE(contains(remark["truth"], "% better than the winner"));
}

TEST(TableSeven, SaysWhereADifferenceIsNotSignificant) {
  Study study = StudyCase{.runs = 3, .sensors = 1}.study();
  for (SensorRun& r : study.results) r.scores.clear();
  const auto add = [&study](std::size_t run, Method method, double error) {
    study.results[run].scores.push_back({method, error, error, error, error});
  };
  for (std::size_t r = 0; r < 3; ++r) {
    add(r, Method::kNothing, 100);
    add(r, Method::kRest, 1);
    add(r, Method::kJoint, r == 0 ? 3 : 0.9);
  }
  const auto said = remarks(study, ranking(study));
  ASSERT_EQ(said.size(), 3U);
  EXPECT_TRUE(said[1].starts_with("lowest score of 2 that tie: 25.6 % better than joint")) << "2.43 to the power of ⅓";
  EXPECT_EQ(said[2].substr(0, 53), "34.4 % worse than the best (not significantly; p = 0.");
  study.runs.resize(1);
  std::erase_if(study.results, [](const SensorRun& r) { return r.run > 0; });
  const auto of_one = remarks(study, ranking(study));
  EXPECT_EQ(of_one[1], "winner: 3.0 times better than joint");
  EXPECT_EQ(of_one[2].substr(0, 31), "3.0 times worse than the winner");
}

TEST(StudyJson, TellsTheStudy) {
  const Study study = StudyCase{.failed = true}.study();
  const std::string text = study_json(study);
  EXPECT_EQ(text, study_json(study));
  const YAML::Node json = YAML::Load(text);
  EXPECT_EQ(json["name"].as<std::string>(), study.name);
  EXPECT_EQ(json["low_pass_hz"].as<double>(), 12);
  EXPECT_TRUE(json["simulated"].as<bool>());
  EXPECT_EQ(json["sensors"][2].as<std::string>(), "MT-9A 3");
  EXPECT_EQ(json["missing"].size(), 3U);
  EXPECT_TRUE(contains(json["missing"][0].as<std::string>(), "MT-9A 3 in bicycle-9 failed"));
  const Ranking found = ranking(study);
  const YAML::Node ranked = json["ranking"];
  EXPECT_EQ(ranked["winner"].as<std::string>(), "gauss_markov_smoothed");
  EXPECT_EQ(ranked["leaders"].as<std::vector<std::string>>(), std::vector<std::string>{"gauss_markov_smoothed"});
  EXPECT_EQ(ranked["second"].as<std::string>(), "rest");
  EXPECT_NEAR(ranked["score_over_nothing"].as<double>(), 1 / found.rows[0].versus_winner, 1e-8);
  EXPECT_LT(ranked["score_over_second"].as<double>(), 1);
  EXPECT_EQ(ranked["confidence"].as<double>(), found.confidence);
  ASSERT_EQ(ranked["methods"].size(), found.rows.size());
  EXPECT_NEAR(ranked["methods"][1]["interval_95"][0].as<double>(), found.rows[1].low, 1e-8);
  EXPECT_EQ(json["coverage"].size(), coverage(study).size());
  EXPECT_EQ(json["coverage"][0]["all"].as<int>(), 78);
  ASSERT_EQ(json["runs"].size(), 9U);
  const YAML::Node run = json["runs"][0];
  EXPECT_EQ(run["phases"]["run"][1].as<double>(), 1015);
  EXPECT_TRUE(run["failure"].IsNull());
  EXPECT_EQ(run["sensors"].size(), 3U);
  EXPECT_EQ(run["sensors"][0]["warnings"][0].as<std::string>(), "the plate flexes by 0.2°");
  EXPECT_NEAR(run["sensors"][0]["clock_drift_ppm"].as<double>(), 20, 1e-9);
  EXPECT_EQ(json["runs"][8]["sensors"][2]["failure"].as<std::string>(), "mt9a_3.csv:1: no sample");
}

TEST(StudyJson, HasNullsWhereNothingWas) {
  const std::string text = study_json(StudyCase{.runs = 1, .sensors = 1, .simulated = false}.study());
  const YAML::Node json = YAML::Load(text);
  EXPECT_TRUE(json["ranking"]["confidence"].IsNull());
  EXPECT_TRUE(json["ranking"]["methods"][1]["p_holm"].IsNull());
  EXPECT_EQ(json["coverage"].size(), 0U);
  for (const char* wrong : {": nan", ", nan", "[nan", "inf"}) EXPECT_FALSE(contains(text, wrong)) << wrong;
  EXPECT_TRUE(YAML::Load(study_json(Study{}))["ranking"].IsNull());
}

TEST(StudyText, SaysWhatRanWhatIsMissingAndWhoWins) {
  const std::string text = study_text(StudyCase{.failed = true}.study());
  for (const char* part : {"nine <runs> & more: 3 IMUs in 9 runs, 26 of 27 went well; low-pass 12 Hz; simulated",
                           "\n  MT-9A 3 in bicycle-9 failed: mt9a_3.csv:1: no sample\n", "\ngauss_markov_smoothed ",
                           "  winner: ", "\nMT-9A 2 ", "fx m/s^2", "wz deg/s", " ± ", " *"}) {
    EXPECT_TRUE(contains(text, part));
  }
  EXPECT_FALSE(contains(text, " \n"));
  EXPECT_FALSE(contains(study_text(StudyCase{.runs = 1, .simulated = false}.study()), "nan"));
}

}  // namespace
}  // namespace piste
