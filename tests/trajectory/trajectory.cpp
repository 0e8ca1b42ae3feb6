// One place and attitude in every format, and what is refused.

#include "piste/trajectory/trajectory.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>

#include "piste/core/error.h"
#include "piste/math/units.h"
#include "support/text_file.h"

namespace piste::test {
namespace {

std::string bytes_of(const std::vector<double>& values) {
  std::string bytes(8 * values.size(), '\0');
  std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

class Formats : public testing::Test {
 protected:
  Trajectory read(const std::string& name, const std::string& text) const {
    folder_.write(name, text);
    return read_trajectory({.path = folder_ / name});
  }
  void expect_refused(const std::string& name, const std::string& text, const std::string& what) const {
    try {
      read(name, text);
      ADD_FAILURE() << name << " was read";
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find(what), std::string::npos) << e.what();
    }
  }
  static void expect_place(const Trajectory& track, TrajectoryFormat format) {
    ASSERT_EQ(track.size(), 2u);
    EXPECT_EQ(track.format, format);
    EXPECT_TRUE(track.geodetic);
    EXPECT_DOUBLE_EQ(track.time[0], 302400.5);
    EXPECT_NEAR(track.place[0].latitude, 46.5 * kDegree, 1e-13);
    EXPECT_NEAR(track.place[0].longitude, 7.25 * kDegree, 1e-13);
    EXPECT_NEAR(track.place[0].height, 1500, 1e-9);
  }
  static void expect_motion(const Trajectory& track) {
    EXPECT_TRUE(track.velocity[0].isApprox(Vector3d(3, 4, -1), 1e-12));
    EXPECT_TRUE(to_euler(track.attitude[0]).isApprox(kDegree * Vector3d(10, -5, 120), 1e-12));
  }
  TemporaryFolder folder_;
};

TEST_F(Formats, Csv) {
  const Trajectory track =
      read("smoothed.csv",
           "time_s,time_utc,latitude_deg,longitude_deg,height_m,velocity_north_m_s,velocity_east_m_s,velocity_down_m_s,"
           "roll_deg,pitch_deg,heading_deg,sigma_north_m,sigma_east_m,sigma_down_m\n"
           "302400.5,2022-01-01T00:00:00Z,46.5,7.25,1500,3,4,-1,10,-5,120,0.1,0.2,0.3\n"
           "302401.5,2022-01-01T00:00:01Z,46.5,7.25,1500,3,4,-1,10,-5,120,0.1,0.2,0.3\n");
  expect_place(track, TrajectoryFormat::kCsv);
  expect_motion(track);
  EXPECT_EQ(track.sigma_position[1], Vector3d(0.1, 0.2, 0.3));
  EXPECT_TRUE(track.sigma_velocity.empty());
  // The folder of a replay, and a point of it.
  EXPECT_EQ(read_trajectory({.path = folder_.path()}).size(), 2u);
  EXPECT_THROW(read_trajectory({.path = folder_.path(), .at = "antenna"}), DataError);
  folder_.write("smoothed_antenna.csv", "time_s,latitude_deg,longitude_deg,height_m\n1,46,7,3\n");
  EXPECT_EQ(read_trajectory({.path = folder_.path(), .at = "antenna"}).size(), 1u);
}

TEST_F(Formats, KfGins) {
  const Trajectory track =
      read("truth.nav", "0 302400.5 46.5 7.25 1500 3 4 -1 10 -5 120\n0 302401.5 46.5 7.25 1500 3 4 -1 10 -5 120\n");
  expect_place(track, TrajectoryFormat::kKfGins);
  expect_motion(track);
}

TEST_F(Formats, Sbet) {
  const std::vector<double> row{302400.5,
                                46.5 * kDegree,
                                7.25 * kDegree,
                                1500,
                                3,
                                4,
                                -1,
                                10 * kDegree,
                                -5 * kDegree,
                                120 * kDegree,
                                0,
                                0,
                                0,
                                0,
                                0,
                                0,
                                0};
  std::vector<double> next = row;
  next[0] += 1;
  // Against axes turned by 90°: what goes east goes along their −x.
  next[10] = 90 * kDegree;
  next[4] = -4;
  next[5] = 3;
  next[9] += 90 * kDegree;
  folder_.write("sbet_smrmsg.out", bytes_of({302400.5, 0.1, 0.2, 0.3, 0.01, 0.02, 0.03, 6, 12, 60}));
  const Trajectory track = read("sbet.out", bytes_of(row) + bytes_of(next));
  expect_place(track, TrajectoryFormat::kSbet);
  expect_motion(track);
  EXPECT_EQ(track.sigma_position[0], Vector3d(0.1, 0.2, 0.3));
  EXPECT_TRUE(track.sigma_euler[0].isApprox(kDegree * Vector3d(0.1, 0.2, 1), 1e-12));
  EXPECT_TRUE(track.velocity[1].isApprox(track.velocity[0], 1e-12)) << track.velocity[1].transpose();
  EXPECT_TRUE(track.attitude[1].isApprox(track.attitude[0], 1e-12));
  folder_.write("cut.out", (bytes_of(row) + bytes_of(next)).substr(0, 200));
  EXPECT_THROW(read_trajectory({.path = folder_ / "cut.out", .format = TrajectoryFormat::kSbet}), DataError);
}

TEST_F(Formats, InertialExplorer) {
  const std::string text =
      "Project: ski\nProgram: Inertial Explorer\n\n"
      "Week   GPSTime     Latitude     Longitude   H-Ell   VNorth  VEast   VUp  Roll Pitch Heading SDNorth SDEast "
      "SDHeight\n"
      "(weeks)  (sec)   (+/-D M S)   (+/-D M S)      (m)    (m/s)  (m/s) (m/s) (deg) (deg) (deg)  (m) (m) (m)\n";
  const std::string row = " 46 30 0.00000 7 15 0.00000 1500.0 3.0 4.0 1.0 10.0 -5.0 120.0 0.1 0.2 0.3\n";
  const Trajectory track = read("ie.txt", text + "2200 302400.5" + row + "2200 302401.5" + row);
  expect_place(track, TrajectoryFormat::kInertialExplorer);
  expect_motion(track);
  EXPECT_EQ(track.sigma_position[0], Vector3d(0.1, 0.2, 0.3));
  expect_refused("cut.txt", text + "2200 302400.5" + row + "2200 302401.5 46 30\n", "cut.txt:7");
}

TEST_F(Formats, Rtklib) {
  const std::string row = "  46.500000000    7.250000000   1500.0000   1  12   0.0100   0.0100   0.0200   0 0 0 0 5\n";
  const Trajectory track = read("run.pos",
                                "% program   : RTKLIB\n%  GPST          latitude(deg) longitude(deg)  height(m)   Q  "
                                "ns   sdn(m)   sde(m)   sdu(m)"
                                "  sdne(m)  sdeu(m)  sdun(m) age(s)  ratio\n2200 302400.500" +
                                    row + "2200 302401.500" + row);
  expect_place(track, TrajectoryFormat::kRtklibPos);
  EXPECT_EQ(track.sigma_position[0], Vector3d(0.01, 0.01, 0.02));
}

// Without GST: places without sigmas. 2022-03-09 12:00:18.5 GPS is 12:00:00.5 UTC.
TEST_F(Formats, NmeaWithoutSigmas) {
  const auto sentence = [](const std::string& body) {
    unsigned sum = 0;
    for (const char c : body) sum ^= static_cast<unsigned char>(c);
    char end[8];
    std::snprintf(end, sizeof end, "*%02X\r\n", sum);
    return "$" + body + end;
  };
  std::string text;
  for (const char* time : {"115942.50", "115943.50"}) {
    text += sentence(std::string("GPGGA,") + time + ",4630.0000000,N,00715.0000000,E,4,12,0.8,1450.0,M,50.0,M,,");
    text += sentence(std::string("GPRMC,") + time + ",A,4630.0000000,N,00715.0000000,E,9.7,53.1,090322,,,R");
  }
  const Trajectory track = read("run.nmea", text);
  ASSERT_EQ(track.size(), 2u);
  EXPECT_DOUBLE_EQ(track.time[0], 302400.5);
  EXPECT_NEAR(track.place[0].height, 1500, 1e-9);
  EXPECT_TRUE(track.sigma_position.empty());
}

TEST_F(Formats, PosesInTheirOwnAxes) {
  const Trajectory tum = read("run.tum", "# t x y z qx qy qz qw\n10.5 1 2 3 0 0 0.6 0.8\n11.5 1 2 3 0 0 0.6 0.8\n"),
                   euroc = read("data.csv", "#timestamp [ns],x,y,z,qw,qx,qy,qz\n10500000000000,1,2,3,0.8,0,0,0.6\n"),
                   kitti =
                       read("00.txt", "0.28 -0.96 0 1 0.96 0.28 0 2 0 0 1 3\n0.28 -0.96 0 1 0.96 0.28 0 2 0 0 1 3\n");
  EXPECT_EQ(tum.format, TrajectoryFormat::kTum);
  EXPECT_EQ(euroc.format, TrajectoryFormat::kEuroc);
  EXPECT_EQ(kitti.format, TrajectoryFormat::kKitti);
  for (const Trajectory* track : {&tum, &euroc, &kitti}) {
    EXPECT_FALSE(track->geodetic);
    EXPECT_EQ(track->position[0], Vector3d(1, 2, 3));
    EXPECT_TRUE(track->attitude[0].isApprox(Quaterniond(0.8, 0, 0, 0.6), 1e-12));
  }
  EXPECT_DOUBLE_EQ(euroc.time[0], 10500);
  EXPECT_FALSE(kitti.has_time);
  folder_.write("00_times.txt", "10.5\n11.5\n");
  EXPECT_DOUBLE_EQ(read_trajectory({.path = folder_ / "00.txt"}).time[1], 11.5);
  folder_.write("00_times.txt", "10.5\n");
  EXPECT_THROW(read_trajectory({.path = folder_ / "00.txt"}), DataError);
}

TEST_F(Formats, ATableByItsMapping) {
  folder_.write("table.txt",
                "t;lat;lon;alt;r;p;h\n302400.5;46.5;7.25;1500;10;-5;120\n302401.5;46.5;7.25;1500;10;-5;120\n");
  const Trajectory track = read("table.yaml", R"(gnss:
  file: table.txt
  format: columns
  columns:
    time: {name: t, unit: s, of: gps_week}
    latitude: {name: lat, unit: deg}
    longitude: {name: lon, unit: deg}
    height: {name: alt, unit: m}
attitude:
  file: table.txt
  format: columns
  columns:
    time: {name: t, unit: s, of: gps_week}
    angles: {names: [r, p, h], unit: deg}
)");
  expect_place(track, TrajectoryFormat::kMapping);
  EXPECT_TRUE(to_euler(track.attitude[0]).isApprox(kDegree * Vector3d(10, -5, 120), 1e-12));
}

TEST_F(Formats, RefusesWhatItCannotRead) {
  expect_refused("a.txt", "hello\nworld\n", "no format of a trajectory is recognised");
  expect_refused("b.txt", "", "is empty");
  expect_refused("c.csv", "time_s,latitude_deg,longitude_deg,height_m\n1,46,7\n", "c.csv:2");
  expect_refused("d.tum", "10.5 1 2 3 0 0 0 1\n10.5 1 2 3 0 0 0 1\n", "d.tum:2");
  expect_refused("e.tum", "10.5 1 2 3 0 0 0 2\n", "norm");
  expect_refused("f.yaml", "gnss: {file: nowhere.csv}\n", "f.yaml:1");
  EXPECT_THROW(trajectory_format("gpx"), ConfigError);
}

}  // namespace
}  // namespace piste::test
