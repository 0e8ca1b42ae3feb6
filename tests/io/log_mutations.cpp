// Logs with some bytes or lines gone wrong are read as finite values at increasing times, or refused: nothing else.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <optional>
#include <random>

#include "piste/io/log_io.h"
#include "support/receiver_logs.h"

namespace piste {
namespace {

constexpr int kMutations = 3000;

/// One whole log of eight rows.
struct Sample {
  const char* name;
  LogFormat format;
  std::function<std::size_t(const LogFile&, RowFaults*)> read;  ///< checks what it reads; gives its rows
  std::string text;
};

void expect_increasing(const std::vector<double>& time) {
  for (std::size_t i = 0; i < time.size(); ++i) {
    ASSERT_TRUE(std::isfinite(time[i]));
    ASSERT_TRUE(i == 0 || time[i] > time[i - 1]);
  }
}

std::size_t read_an_imu(const LogFile& log, RowFaults* faults) {
  const auto imu = read_imu(log, faults);
  EXPECT_EQ(imu.gyro.size(), imu.time.size());
  EXPECT_EQ(imu.accel.size(), imu.time.size());
  EXPECT_TRUE(imu.magnetic.empty() || imu.magnetic.size() == imu.time.size());
  EXPECT_TRUE(imu.temperature.empty() || imu.temperature.size() == imu.time.size());
  expect_increasing(imu.time);
  for (std::size_t i = 0; i < imu.time.size(); ++i) EXPECT_TRUE(imu.gyro[i].allFinite() && imu.accel[i].allFinite());
  return imu.time.size();
}

std::size_t read_fixes(const LogFile& log, RowFaults* faults) {
  const auto gnss = read_gnss(log, faults);
  std::vector<double> time;
  for (const GeodeticFix& fix : gnss.fixes) {
    time.push_back(fix.time);
    EXPECT_TRUE(std::isfinite(fix.position.latitude + fix.position.longitude + fix.position.height));
    EXPECT_GT(fix.sigma_position.minCoeff(), 0);
    EXPECT_TRUE(faults != nullptr || fix.sigma_position.allFinite());
    EXPECT_TRUE(!fix.velocity || (fix.velocity->value.allFinite() && fix.velocity->sigma.allFinite()));
  }
  expect_increasing(time);
  return time.size();
}

std::size_t read_attitudes(const LogFile& log, RowFaults* faults) {
  const auto attitude = read_attitude(log, faults);
  std::vector<double> time;
  for (const EulerFix& fix : attitude.fixes) {
    time.push_back(fix.time);
    EXPECT_TRUE(fix.angles.allFinite());
    EXPECT_GT(fix.sigma.minCoeff(), 0);
  }
  expect_increasing(time);
  return time.size();
}

std::string rows(const std::string& header, const std::function<std::string(int)>& row) {
  std::string text = header;
  for (int i = 0; i < 8; ++i) text += row(i);
  return text;
}

std::vector<Sample> samples() {
  const std::string rtklib =
      "% program : RTKLIB\n%  GPST  latitude(deg) longitude(deg) height(m) Q ns sdn(m) sde(m) sdu(m) sdne(m) sdeu(m) "
      "sdun(m) age(s) ratio\n";
  return {
      {"imu_csv", LogFormat::kCsv, read_an_imu,
       rows("time_s,gyro_x_deg_s,gyro_y_deg_s,gyro_z_deg_s,accel_x_g,accel_y_g,accel_z_g\n",
            [](int i) { return fmt::format("{}.25,1,2,3,0.1,0,-1\n", i); })},
      {"gnss_csv", LogFormat::kCsv, read_fixes,
       rows("time_s,latitude_deg,longitude_deg,height_m,sigma_north_m,sigma_east_m,sigma_down_m\n",
            [](int i) { return fmt::format("{}.25,46.5,7.25,1600,1,2,3\n", i); })},
      {"attitude_csv", LogFormat::kCsv, read_attitudes,
       rows("time_s,roll_deg,pitch_deg,heading_deg,sigma_roll_deg,sigma_pitch_deg,sigma_heading_deg\n",
            [](int i) { return fmt::format("{}.25,1,-2,359,0.1,0.2,0.3\n", i); })},
      {"imu_kf_gins", LogFormat::kKfGins, read_an_imu,
       rows("", [](int i) { return fmt::format("10.{} 0 0 .01 0 0 -0.98\n", i); })},
      {"gnss_kf_gins", LogFormat::kKfGins, read_fixes,
       rows("", [](int i) { return fmt::format("{} 46.5 7.25 1600 1 2 3 4 5 6 .1 .2 .3 1\n", i); })},
      {"rtklib_pos", LogFormat::kRtklibPos, read_fixes,
       rows(rtklib,
            [](int i) { return fmt::format("2025/07/08 19:34:1{}.5 46.5 7.25 1600 1 9 1 2 3 0 0 0 0 9\n", i); })},
      {"nmea", LogFormat::kNmea, read_fixes,
       rows("", [](int i) { return test::nmea_epoch(fmt::format("10000{}", i)); })},
      {"ubx", LogFormat::kUbx, read_fixes,
       rows("", [](int i) { return test::ubx(1, 7, test::nav_pvt(1000U * static_cast<unsigned>(i)).text()); })},
      {"xsens_ascii", LogFormat::kXsensAscii, read_an_imu,
       rows(test::kXsensHeader, [](int i) { return test::xsens_row(65530 + i - (i > 5 ? 65536 : 0)); })},
      {"imr", LogFormat::kImr, read_an_imu,
       rows(test::imr_header().text(), [](int i) { return test::imr_record(1 + 0.01 * i, 100000, -9800); })},
      {"gnss_novatel", LogFormat::kNovatel, read_fixes,
       rows("",
            [](int i) {
              return test::novatel(
                  fmt::format("#BESTPOSA,COM1,0,60.0,FINESTEERING,2374,{}.0,02000020,5b35,16809;SOL_COMPUTED,SINGLE,46."
                              "5,7.25,1550,50,WGS84,1,2,3,\"\",0,0,9,9,9,9,00,02,11,01",
                              i));
            })},
      {"imu_novatel", LogFormat::kNovatel, read_an_imu,
       rows("",
            [](int i) {
              return test::novatel(
                  fmt::format("%RAWIMUSXA,2374,1.{0};00,26,2374,1.{0},00000077,49000000,0,0,1000,0,0", i));
            })},
      {"inspva", LogFormat::kInspva, read_attitudes,
       rows("",
            [](int i) {
              return test::novatel(
                  fmt::format("%INSPVAXSA,2374,{}.0;INS_SOLUTION_GOOD,INS_PSRSP,46,7,1600,50,0,0,0,1,2,3,1,1,1,1,1,1,0."
                              "1,0.2,0.3,3,0",
                              i));
            })},
  };
}

class Mutator {
 public:
  explicit Mutator(unsigned seed) : engine_(seed) {}

  std::string operator()(std::string text) {
    for (std::size_t n = 1 + below(3); n > 0; --n) mutate(text);
    return text;
  }

 private:
  std::size_t below(std::size_t n) { return n == 0 ? 0 : static_cast<std::size_t>(engine_() % n); }
  char byte() {
    constexpr std::string_view kTelling = "0123456789.,;-+eE*$#% \t\r\n\"nainf";
    return below(2) == 0 ? kTelling[below(kTelling.size())] : static_cast<char>(below(256));
  }
  void mutate(std::string& text) {
    const std::size_t at = below(text.size() + 1), length = 1 + below(40);
    switch (below(6)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(text[at] ^ (1 << below(8)));
        break;
      case 1:
        if (at < text.size()) text[at] = byte();
        break;
      case 2:
        text.erase(at, length);
        break;
      case 3:
        text.insert(at, 1, byte());
        break;
      case 4:
        text.insert(at, text.substr(at, length));
        break;
      default: {  // a line twice, gone, or elsewhere
        const std::size_t end = std::min(text.find('\n', at), text.size());
        const std::string line = text.substr(at, end - at);
        if (below(2) == 0) text.erase(at, line.size());
        if (below(2) == 0) text.insert(below(text.size() + 1), line);
        if (below(8) == 0) text.resize(below(text.size() + 1));
      }
    }
  }

  std::mt19937 engine_;
};

// Rows, or none where it is refused.
std::optional<std::size_t> rows_of(const Sample& sample, const std::string& text, RowFaults* faults) {
  try {
    return sample.read({.file = "log", .format = sample.format, .content = text}, faults);
  } catch (const DataError& e) {
    EXPECT_EQ(std::string_view(e.what()).substr(0, 3), "log");
    return std::nullopt;
  }
}

TEST(Mutations, AreReadOrRefused) {
  for (const Sample& sample : samples()) {
    SCOPED_TRACE(sample.name);
    ASSERT_EQ(rows_of(sample, sample.text, nullptr), 8u);
    Mutator mutate(1);
    int read = 0, refused = 0;
    for (int i = 0; i < kMutations && !HasFailure(); ++i) {
      const std::string text = mutate(sample.text);
      SCOPED_TRACE(text);
      const auto strictly = rows_of(sample, text, nullptr);
      RowFaults faults;
      const auto listed = rows_of(sample, text, &faults);
      ++(strictly ? read : refused);
      // What is read strictly is read alike, without a fault.
      if (strictly) {
        EXPECT_EQ(listed, strictly);
        EXPECT_EQ(faults.total(), 0u);
      }
    }
    EXPECT_GT(read, kMutations / 100);
    EXPECT_GT(refused, kMutations / 10);
  }
}

}  // namespace
}  // namespace piste
