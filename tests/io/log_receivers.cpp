#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "piste/io/log_io.h"
#include "piste/math/units.h"
#include "support/receiver_logs.h"
#include "support/text_file.h"

namespace piste {
namespace {

using test::contains;
using test::message_of;
using test::nmea;
using test::nmea_epoch;
using test::novatel;
using test::ubx;
using Kind = RowFault::Kind;

LogFile log_of(const std::string& text, LogFormat format) { return {.file = "log", .format = format, .content = text}; }

GnssRecording gnss_of(const std::string& text, LogFormat format, RowFaults* faults = nullptr) {
  return read_gnss(log_of(text, format), faults);
}
std::string gnss_refused(const std::string& text, LogFormat format) {
  return message_of<DataError>([&] { gnss_of(text, format); });
}

// ---- nmea ----

GnssRecording nmea_of(const std::string& text, RowFaults* faults = nullptr) {
  return gnss_of(text, LogFormat::kNmea, faults);
}
std::string nmea_refused(const std::string& text) { return gnss_refused(text, LogFormat::kNmea); }

GnssRecording stated_nmea(const std::string& text) {
  LogFile log = log_of(text, LogFormat::kNmea);
  log.sigma = Vector3d(2, 3, 4);
  return read_gnss(log);
}

const std::string kGgaTail = ",4630.0,N,00715.0,W,1,12,0.8,1550.0,M,50.0,M,,";
const std::string kGst = ",1.0,,,,0.02,0.03,0.05";
std::string rmc(const std::string& time, const std::string& date) {
  return nmea("GPRMC," + time + ",A,4630.0,N,00715.0,W,0.0,," + date + ",,,A");
}

// As receivers of several constellations write it, also beside GGA.
TEST(Nmea, PlacesOfGns) {
  const auto gns = [](const std::string& time, const std::string& modes, const std::string& geoid) {
    return nmea("GNGNS," + time + ",4630.0,N,00715.0,W," + modes + ",15,0.6,1550.0," + geoid + ",1.0,0001");
  };
  const auto gnss =
      stated_nmea(gns("100000", "RRN", "50.0") + rmc("100000", "080725") + gns("100001", "FA", "50.0") +
                  gns("100002", "NN", "") + gns("100003", "AA", "50.0") + nmea("GPGGA,100003" + kGgaTail));
  ASSERT_EQ(gnss.fixes.size(), 3u);
  EXPECT_DOUBLE_EQ(gnss.fixes[0].position.height, 1600);
  EXPECT_EQ(gnss.fixes[0].quality, FixQuality::kFixed);
  EXPECT_EQ(gnss.fixes[1].quality, FixQuality::kFloat);
  EXPECT_EQ(gnss.fixes[2].quality, FixQuality::kSingle);
  EXPECT_EQ(gnss.without_fix, 1u);
  const auto bare = stated_nmea(gns("100000", "A", "") + rmc("100000", "080725"));
  ASSERT_EQ(bare.fixes.size(), 1u);
  EXPECT_DOUBLE_EQ(bare.fixes[0].position.height, 1550);
  EXPECT_EQ(bare.above_sea, 1u);
}

// It has no time: it is of the epoch that is open, unless RMC states the velocity.
TEST(Nmea, VelocitiesOfVtg) {
  const auto vtg = [](const std::string& knots) { return nmea("GPVTG,90.00,T,,M," + knots + ",N,,K,A"); };
  const std::string text = vtg("1.0") + nmea("GPGGA,100000" + kGgaTail) + vtg("10.0") +
                           nmea("GPZDA,100000,08,07,2025,00,00") + nmea("GPGGA,100001" + kGgaTail) +
                           rmc("100001", "080725") + vtg("10.0") + nmea("GPGGA,100002" + kGgaTail);
  LogFile log = log_of(text, LogFormat::kNmea);
  log.sigma = Vector3d(2, 3, 4);
  log.sigma_velocity = Vector3d::Constant(0.1);
  const auto gnss = read_gnss(log);
  ASSERT_EQ(gnss.fixes.size(), 3u);
  ASSERT_TRUE(gnss.fixes[0].velocity);
  EXPECT_NEAR(gnss.fixes[0].velocity->value.y(), 10 * 1852 / 3600.0, 1e-12);
  ASSERT_TRUE(gnss.fixes[1].velocity);
  EXPECT_EQ(gnss.fixes[1].velocity->value.y(), 0) << "of RMC";
  EXPECT_FALSE(gnss.fixes[2].velocity);
}

// A stamp before and behind a sentence leaves its checksum what it is.
TEST(Nmea, StampsAroundASentence) {
  const std::string gga = nmea("GPGGA,100000" + kGgaTail), date = rmc("100000", "080725");
  const auto stamped = [](const std::string& line, const std::string& behind) {
    return "12;2025-07-08;\"" + line.substr(0, line.size() - 2) + behind + "\n";
  };
  for (const char* behind : {"\";", ",1707307242.2", "\t17:00:01"}) {
    const auto gnss = stated_nmea(stamped(date, behind) + stamped(gga, behind));
    EXPECT_EQ(gnss.fixes.size(), 1u) << behind;
    EXPECT_EQ(gnss.unchecked, 0u) << behind;
  }
}

TEST(Nmea, EpochOfFourSentences) {
  const auto gnss = nmea_of(nmea_epoch("193418.50") + nmea_epoch("193419.00"));
  ASSERT_EQ(gnss.fixes.size(), 2u);
  const GeodeticFix& fix = gnss.fixes[0];
  EXPECT_DOUBLE_EQ(fix.time, 243276.5);  // Tuesday 2025-07-08, 18 leap seconds
  EXPECT_DOUBLE_EQ(gnss.fixes[1].time, 243277.0);
  EXPECT_DOUBLE_EQ(fix.position.latitude, 46.5 * kDegree);
  EXPECT_DOUBLE_EQ(fix.position.longitude, -7.25 * kDegree);
  EXPECT_DOUBLE_EQ(fix.position.height, 1600);
  EXPECT_EQ(fix.sigma_position, Vector3d(0.02, 0.03, 0.05));
  EXPECT_EQ(fix.quality, FixQuality::kFixed);
}

// Sentences as they stand in textbooks and logs, with their own checksums.
TEST(Nmea, PublishedSentences) {
  const auto gnss = stated_nmea(
      "$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47\n"
      "$GPRMC,123519,A,4807.038,N,01131.000,E,022.4,084.4,230394,003.1,W*6A\n"
      "$GPVTG,054.7,T,034.4,M,005.5,N,010.2,K*48\n");
  ASSERT_EQ(gnss.fixes.size(), 1u);
  EXPECT_DOUBLE_EQ(gnss.fixes[0].time, 3 * 86400 + 12 * 3600 + 35 * 60 + 19 + 9);  // Wednesday 1994-03-23
  EXPECT_DOUBLE_EQ(gnss.fixes[0].position.latitude, (48 + 7.038 / 60) * kDegree);
  EXPECT_DOUBLE_EQ(gnss.fixes[0].position.longitude, (11 + 31.0 / 60) * kDegree);
  EXPECT_DOUBLE_EQ(gnss.fixes[0].position.height, 545.4 + 46.9);
  EXPECT_EQ(gnss.fixes[0].quality, FixQuality::kSingle);
  EXPECT_EQ(gnss.fixes[0].satellites, 8);

  const auto with_gst = nmea_of(
      "$GPGGA,172814.0,3723.46587704,N,12202.26957864,W,2,6,1.2,18.893,M,-25.669,M,2.0,0031*4F\r\n"
      "$GPGST,172814.0,0.006,0.023,0.020,273.6,0.023,0.020,0.031*6A\r\n"
      "$GNRMC,140800.00,A,4646.13684,N,00737.21786,E,15.370,136.28,230216,,,D*43\r\n");
  EXPECT_EQ(with_gst.fixes[0].sigma_position, Vector3d(0.023, 0.020, 0.031));
  EXPECT_EQ(with_gst.fixes[0].quality, FixQuality::kDifferential);
  EXPECT_EQ(with_gst.fixes[0].satellites, 6);
  // 14:08 follows 17:28 by less than half a day: the same day, 2016-02-23, a Tuesday.
  EXPECT_DOUBLE_EQ(with_gst.fixes[0].time, 2 * 86400 + 17 * 3600 + 28 * 60 + 14 + 17);

  const auto dated_by_zda = stated_nmea("$GNZDA,140759.75,23,02,2016,00,00*72\n" + nmea("GNGGA,140759.75" + kGgaTail));
  EXPECT_DOUBLE_EQ(dated_by_zda.fixes[0].time, 2 * 86400 + 14 * 3600 + 7 * 60 + 59.75 + 17);
}

// The ellipse of errors stands beside the sigmas of its projections.
TEST(Nmea, GstTellsTheCorrelation) {
  const auto correlation = [](const std::string& gst) {
    const std::string time = "100000";
    return nmea_of(nmea("GPGGA," + time + kGgaTail) + nmea("GPGST," + time + gst) + rmc(time, "080725"))
        .fixes.at(0)
        .correlation;
  };
  // Semi-axes of 5 and 1 m: at 45 degrees both projections are of 13 m², and the covariance is 12 m².
  const std::string projections = ",3.605551,3.605551,2.0";
  EXPECT_NEAR(correlation(",1.0,5.0,1.0,45.0" + projections).x(), 12.0 / 13, 1e-6);
  EXPECT_NEAR(correlation(",1.0,5.0,1.0,135.0" + projections).x(), -12.0 / 13, 1e-6);
  EXPECT_EQ(correlation(",1.0,,,,0.02,0.03,0.05"), Correlation::Zero());
}

TEST(Nmea, SentencesOfAnEpochComeInAnyOrderOfAnyTalker) {
  const auto gnss = nmea_of(nmea("GAGST,100000" + kGst) + nmea("QZGGA,100000" + kGgaTail) + rmc("100000", "080725") +
                            nmea("GLGGA,100001" + kGgaTail) + rmc("100001", "080725") + nmea("GBGST,100001" + kGst));
  ASSERT_EQ(gnss.fixes.size(), 2u);
  EXPECT_DOUBLE_EQ(gnss.fixes[1].time - gnss.fixes[0].time, 1);
}

TEST(Nmea, SpeedAndCourseAreAHorizontalVelocityWhereItsSigmaIsStated) {
  const auto with_sigma = [](const std::string& text) {
    LogFile log = log_of(text, LogFormat::kNmea);
    log.sigma_velocity = Vector3d::Constant(0.1);
    return read_gnss(log);
  };
  const std::string course = nmea("GPRMC,100001,A,4630.0,N,00715.0,W,10.0,120.0,080725,,,A"),
                    standing = nmea("GPRMC,100002,A,4630.0,N,00715.0,W,0.0,,080725,,,A"),
                    unsure = nmea("GPRMC,100003,A,4630.0,N,00715.0,W,0.3,,080725,,,A");
  const auto epoch = [](const std::string& time) {
    return nmea("GPGGA," + time + kGgaTail) + nmea("GPGST," + time + kGst);
  };
  const std::string text =
      epoch("100001") + course + epoch("100002") + standing + epoch("100003") + unsure + epoch("100004");
  const auto gnss = with_sigma(text);
  ASSERT_EQ(gnss.fixes.size(), 4u);
  ASSERT_TRUE(gnss.fixes[0].velocity && gnss.fixes[1].velocity);
  EXPECT_LT((gnss.fixes[0].velocity->value - Vector3d(-2.57222, 4.45522, 0)).norm(), 1e-5);
  EXPECT_EQ(gnss.fixes[0].velocity->sigma.head<2>(), Eigen::Vector2d(0.1, 0.1));
  EXPECT_FALSE(gnss.fixes[0].velocity->has_down());
  EXPECT_EQ(gnss.fixes[1].velocity->value, Vector3d::Zero());
  EXPECT_FALSE(gnss.fixes[2].velocity);
  EXPECT_FALSE(gnss.fixes[3].velocity);
  EXPECT_FALSE(nmea_of(text).fixes[0].velocity);
  EXPECT_TRUE(contains(message_of<DataError>([&] { with_sigma(epoch("100003") + unsure); }),
                       "no RMC with status A gives a fix its speed and course"));
}

TEST(Nmea, PassesOverWhatItDoesNotNeed) {
  const auto gnss = nmea_of(nmea("PUBX,00,1") + nmea("GPGSV,1,1,00") + "!AIVDM,1,1,,A,x*" +
                            nmea("AIVDM,1,1,,A,x").substr(16, 2) + "\n\n" + nmea_epoch("100000"));
  EXPECT_EQ(gnss.fixes.size(), 1u);
}

TEST(Nmea, DateCountsOverMidnightForwardAndBack) {
  const auto epoch = [](const std::string& time) {
    return nmea("GPGGA," + time + kGgaTail) + nmea("GPGST," + time + kGst);
  };
  // 2025-07-12 is a Saturday: the week rolls over as well.
  const double before = 6 * 86400 + 86399 + 18;
  for (const std::string& text :
       {rmc("235959", "120725") + epoch("235959") + epoch("000000"),
        epoch("235959") + epoch("000000") + rmc("000001", "130725"),
        rmc("235959", "120725") + epoch("235959") + rmc("000000", "130725") + epoch("000000"),
        epoch("235959") + rmc("235959", "120725") + epoch("000000") + rmc("000000", "130725")}) {
    const auto gnss = nmea_of(text);
    ASSERT_EQ(gnss.fixes.size(), 2u) << text;
    EXPECT_DOUBLE_EQ(gnss.fixes[0].time, before) << text;
    EXPECT_DOUBLE_EQ(gnss.fixes[1].time, before + 1) << text;
  }
  // A break of two days is known by its date.
  const auto broken = nmea_of(nmea_epoch("100000", "080725") + nmea_epoch("110000", "100725"));
  EXPECT_DOUBLE_EQ(broken.fixes[1].time - broken.fixes[0].time, 2 * 86400 + 3600);
}

TEST(Nmea, EpochsWithoutFixAreCounted) {
  const auto gnss =
      nmea_of(nmea("GPGGA,,,,,,0,00,99.99,,,,,,") + nmea("GPRMC,,V,,,,,,,,,,N") +
              nmea("GPGGA,095959,,,,,0,00,99.99,,,,,,") + nmea("GPGST,095959,,,,,,,") + nmea_epoch("100000"));
  EXPECT_EQ(gnss.fixes.size(), 1u);
  EXPECT_EQ(gnss.without_fix, 2u);
}

TEST(Nmea, QualityOfGga) {
  const std::pair<char, FixQuality> qualities[] = {{'1', FixQuality::kSingle},  {'2', FixQuality::kDifferential},
                                                   {'3', FixQuality::kPrecise}, {'4', FixQuality::kFixed},
                                                   {'5', FixQuality::kFloat},   {'6', FixQuality::kDeadReckoned}};
  for (const auto& [digit, quality] : qualities) {
    std::string gga = "GPGGA,100000" + kGgaTail;
    gga.replace(gga.find(",W,1"), 4, std::string(",W,") + digit);
    const std::string text = nmea(gga) + rmc("100000", "080725");
    LogFile log = log_of(text, LogFormat::kNmea);
    log.sigma = Vector3d(3, 3, 6);
    log.use_quality = {quality};
    EXPECT_EQ(read_gnss(log).fixes.at(0).quality, quality);
  }
}

// A fix that the receiver carried on is no measurement: GGA says so by its quality, RMC by its mode.
TEST(Nmea, DeadReckonedFixesAreLeftOutAndCounted) {
  std::string reckoned = "GPGGA,100001" + kGgaTail;
  reckoned.replace(reckoned.find(",W,1"), 4, ",W,6");
  const std::string estimated =
                        nmea("GPGGA,100002" + kGgaTail) + nmea("GNRMC,100002,A,4630.0,N,00715.0,W,3.0,10.0,080725,,,E"),
                    text = nmea("GPGGA,100000" + kGgaTail) + rmc("100000", "080725") + nmea(reckoned) + estimated +
                           nmea("GPGGA,100003" + kGgaTail);
  const auto gnss = stated_nmea(text);
  ASSERT_EQ(gnss.fixes.size(), 2u);
  EXPECT_EQ(gnss.not_used, 2u);
  EXPECT_DOUBLE_EQ(gnss.fixes[1].time - gnss.fixes[0].time, 3);
  LogFile fixed = log_of(text, LogFormat::kNmea);
  fixed.sigma = Vector3d(3, 3, 6);
  fixed.use_quality = {FixQuality::kFixed};
  EXPECT_TRUE(contains(message_of<DataError>([&] { read_gnss(fixed); }), "none of its 4 fixes is of a quality"));
}

// A minute of sentences, each as `written` has it of a right one.
template <class Write>
std::string minute_of(Write&& written) {
  std::string text;
  for (int i = 0; i < 60; ++i) {
    const std::string time = fmt::format("1000{:02}", i);
    text += written(nmea("GNGGA," + time + kGgaTail)) + written(rmc(time, "080725"));
  }
  return text;
}

TEST(Nmea, WhatStandsBesideTheSentenceIsPassedOver) {
  const auto bare = [](const std::string& s) { return s.substr(0, s.size() - 1); };
  const std::function<std::string(const std::string&)> ways[] = {
      [&](const std::string& s) { return "12:00:01.250 -> " + s; },
      [&](const std::string& s) { return "1752000001.25\t" + s; },
      [&](const std::string& s) { return "[2025-07-08 10:00:01] RX: " + s; },
      [&](const std::string& s) { return "\"" + bare(s) + "\"\n"; },
      [&](const std::string& s) { return bare(s) + ",,,\r\n"; }};
  for (const auto& way : ways) EXPECT_EQ(stated_nmea(minute_of(way)).fixes.size(), 60u) << way("$\n");
  // The end of a sentence that is cut stays a fault.
  EXPECT_TRUE(
      contains(message_of<DataError>([] { stated_nmea(rmc("100000", "080725") + "$GPGG" + rmc("100001", "080725")); }),
               "log:2: the checksum"));
}

TEST(Nmea, WithoutChecksumsIfNotOneIsRight) {
  const auto cut = [](const std::string& s) { return s.substr(0, s.find('*')) + "\n"; };
  const auto none = stated_nmea(minute_of(cut));
  EXPECT_EQ(none.fixes.size(), 60u);
  EXPECT_EQ(none.unchecked, 120u);
  const std::string one = minute_of(cut) + rmc("100100", "080725");
  EXPECT_TRUE(contains(message_of<DataError>([&] { stated_nmea(one); }), "log:1: the checksum"));
}

TEST(Nmea, WithoutTheGeoidHeightsAreAsTheyStand) {
  const std::string tail = ",4630.0,N,00715.0,W,1,12,0.8,1550.0,M,,,,";
  const std::string bare = rmc("100000", "080725") + nmea("GPGGA,100000" + tail);
  const auto gnss = stated_nmea(bare);
  EXPECT_EQ(gnss.above_sea, 1u);
  EXPECT_DOUBLE_EQ(gnss.fixes.at(0).position.height, 1550);
  EXPECT_TRUE(contains(message_of<DataError>([&] { stated_nmea(bare + nmea("GPGGA,100001" + kGgaTail)); }),
                       "log:2: the geoid separation is empty, and others are not"));
}

TEST(Nmea, Refusals) {
  const std::string dated = rmc("100000", "080725"), gst = nmea("GPGST,100000" + kGst);
  const auto gga = [](const std::string& tail) { return nmea("GPGGA,100000" + tail); };
  const std::pair<std::string, const char*> cases[] = {
      {"hello\n", "log:1: no NMEA sentence"},
      {dated + "\xB5\x62\x01\n", "log:2: no NMEA sentence"},
      {dated + "$GPGGA,100000\n", "log:2: the checksum"},
      {dated + "$GPGGA,100000*00\n", "log:2: the checksum"},
      {dated + "$GPGSV,1*xx\n", "log:2: the checksum"},
      {dated + nmea("GPGGA,100000,4630.0,N"), "log:2: 3 fields in GPGGA, 14 at least"},
      {dated + gga(",4660.0,N,00715.0,W,1,12,0.8,1550.0,M,50.0,M,,"), "log:2: `4660.0,N` is no angle"},
      {dated + gga(",4630.0,N,00715.0,N,1,12,0.8,1550.0,M,50.0,M,,"), "log:2: `00715.0,N` is no angle"},
      {dated + gst + gga(",9130.0,N,00715.0,W,1,12,0.8,1550.0,M,50.0,M,,"), "log:3: latitude 91.5"},
      {dated + gga(",4630.x,N,00715.0,W,1,12,0.8,1550.0,M,50.0,M,,"), "is no number"},
      {dated + gga(",4630.0,N,00715.0,W,1,12,0.8,1550.0,F,50.0,M,,"), "unit `F` of a height"},
      {dated + gga(",4630.0,N,00715.0,W,8,12,0.8,1550.0,M,50.0,M,,"), "log:2: quality `8` of GGA"},
      {dated + nmea("GPGGA,250000" + kGgaTail), "log:2: `250000` is no time of day"},
      {dated + nmea("GPGGA," + kGgaTail), "log:2: a fix without its time"},
      {dated + gst + gga(kGgaTail) + nmea("GNGGA,100000" + kGgaTail), "log:4: a second GGA of the same time"},
      {dated + gga(kGgaTail), "log:2: no GST of this time"},
      {dated + gga(kGgaTail) + nmea("GPGST,100000,1,,,,,,"), "`sigma: 2 2 4 m`"},
      {dated + gga(kGgaTail) + nmea("GPGST,100000,1,,,,0,1,1"), "log:2: the sigmas of a position must be above zero"},
      {gst + gga(kGgaTail), "log:2: the time of day has no date"},
      {gst + gga(kGgaTail), "let the receiver write RMC"},
      {rmc("100000", "320725"), "log:1: 2025-7-32 is no date"},
      {nmea_epoch("100001") + nmea_epoch("100000"), "log:7: time"},
      {nmea_epoch("100000", "090725") + nmea_epoch("100001", "080725"), "does not increase"},
      {dated, "holds no fix; sentences GGA, GST and RMC"},
  };
  for (const auto& [text, expected] : cases) {
    EXPECT_TRUE(contains(nmea_refused(text), expected)) << text;
  }
  EXPECT_EQ(stated_nmea(nmea_epoch("100000")).fixes.at(0).sigma_position, Vector3d(2, 3, 4)) << "over those of GST";
}

TEST(Nmea, ListsWhatItRefusesWhereAsked) {
  RowFaults faults;
  const auto gnss = nmea_of(nmea_epoch("100000") + "$GPGGA,1*00\nrubbish\n" + nmea_epoch("100001") +
                                nmea("GPGGA,100002" + kGgaTail) + nmea_epoch("100001"),
                            &faults);
  EXPECT_EQ(gnss.fixes.size(), 3u);
  EXPECT_EQ(faults.count(Kind::kChecksum), 1u);
  EXPECT_EQ(faults.count(Kind::kText), 1u);
  EXPECT_EQ(faults.count(Kind::kTimeBack), 1u);
  EXPECT_EQ(faults.total(), 3u);
  EXPECT_EQ(faults.first[0].place, 5u);
  // A sigma that nobody states is not known.
  EXPECT_EQ(gnss.fixes[2].sigma_position.x(), std::numeric_limits<double>::infinity());
}

// ---- ubx ----

GnssRecording ubx_of(const std::string& text, RowFaults* faults = nullptr) {
  return gnss_of(text, LogFormat::kUbx, faults);
}
std::string ubx_refused(const std::string& text) { return gnss_refused(text, LogFormat::kUbx); }
std::string pvt(const test::Bytes& payload) { return ubx(1, 7, payload.text()); }
std::string pvt(std::uint32_t time_of_week_ms) { return pvt(test::nav_pvt(time_of_week_ms)); }

TEST(Ubx, NavPvt) {
  const auto gnss =
      ubx_of(ubx(1, 3, "status") + pvt(test::nav_pvt(604799800).put<std::uint8_t>(23, 14)) + nmea("GPTXT,01") + pvt(0));
  ASSERT_EQ(gnss.fixes.size(), 2u);
  EXPECT_EQ(gnss.fixes[0].satellites, 14);
  const GeodeticFix& fix = gnss.fixes[0];
  EXPECT_DOUBLE_EQ(fix.time, 604799.8);
  EXPECT_DOUBLE_EQ(gnss.fixes[1].time, 604800.0);
  EXPECT_NEAR(fix.position.latitude, 46.5 * kDegree, 1e-12);
  EXPECT_NEAR(fix.position.longitude, -7.25 * kDegree, 1e-12);
  EXPECT_DOUBLE_EQ(fix.position.height, 1600);
  EXPECT_LT((fix.sigma_position - Vector3d(2, 2, 3)).norm(), 1e-3);
  EXPECT_TRUE(fix.velocity->value.isApprox(Vector3d(4, -5, 0.6)));
  EXPECT_LT((fix.velocity->sigma - Vector3d::Constant(0.1)).norm(), 1e-3);
  EXPECT_EQ(fix.quality, FixQuality::kSingle);
}

TEST(Ubx, TimeIsRefinedByTheFractionOfTheSecond) {
  const auto at = [](std::uint32_t week_ms, std::int32_t nano, std::uint8_t valid) {
    return ubx_of(pvt(test::nav_pvt(week_ms).put<std::int32_t>(16, nano).put<std::uint8_t>(11, valid))).fixes[0].time;
  };
  EXPECT_NEAR(at(136903000, -378166, 7), 136902.999621834, 1e-9);
  EXPECT_NEAR(at(136903200, 200000123, 7), 136903.200000123, 1e-9);
  EXPECT_EQ(at(136903000, -378166, 1), 136903);  // the time is not valid
  EXPECT_EQ(at(136903000, 500000000, 7), 136903);
}

TEST(Ubx, QualityAndEpochsWithoutFix) {
  const auto flags = [](std::uint32_t time, std::uint8_t type, int value) {
    return pvt(test::nav_pvt(time).put<std::uint8_t>(20, type).put<std::uint8_t>(21, static_cast<std::uint8_t>(value)));
  };
  const auto gnss = ubx_of(flags(1000, 3, 0x03) + flags(2000, 3, 0x41) + flags(3000, 4, 0x83) + flags(4000, 3, 0x02) +
                           flags(5000, 2, 0x01) + flags(6000, 0, 0x00) + flags(7000, 5, 0x01));
  ASSERT_EQ(gnss.fixes.size(), 3u);
  EXPECT_EQ(gnss.fixes[0].quality, FixQuality::kDifferential);
  EXPECT_EQ(gnss.fixes[1].quality, FixQuality::kFloat);
  EXPECT_EQ(gnss.fixes[2].quality, FixQuality::kFixed);
  EXPECT_EQ(gnss.without_fix, 4u);
}

// NAV-COV stands after the fix of its time, or before it.
TEST(Ubx, NavCov) {
  const auto cov = [](std::uint32_t time, std::uint8_t valid, float ne) {
    return ubx(1, 0x36,
               test::Bytes(64)
                   .put<std::uint32_t>(0, time)
                   .put<std::uint8_t>(5, valid)
                   .put<float>(16, 4)
                   .put<float>(20, ne)
                   .put<float>(28, 9)
                   .put<float>(36, 16)
                   .text());
  };
  const auto gnss = ubx_of(pvt(1000) + cov(1000, 1, 3) + cov(2000, 1, -3) + pvt(2000) + pvt(3000) + cov(3000, 0, 3) +
                           cov(3500, 1, 3) + pvt(4000));
  ASSERT_EQ(gnss.fixes.size(), 4u);
  EXPECT_EQ(gnss.fixes[0].sigma_position, Vector3d(2, 3, 4));
  EXPECT_DOUBLE_EQ(gnss.fixes[0].correlation.x(), 0.5);
  EXPECT_DOUBLE_EQ(gnss.fixes[1].correlation.x(), -0.5);
  for (const std::size_t other : {2U, 3U}) {  // not valid, and of no fix
    EXPECT_LT((gnss.fixes[other].sigma_position - Vector3d(2, 2, 3)).norm(), 1e-3);
    EXPECT_EQ(gnss.fixes[other].correlation, Correlation::Zero());
  }
  EXPECT_TRUE(contains(ubx_refused(ubx(1, 0x36, "short")), "NAV-COV of 5 bytes; 64 are expected"));
}

TEST(Ubx, Refusals) {
  const std::string first = pvt(1000), second = pvt(2000);
  std::string wrong = second;
  wrong[40] = static_cast<char>(wrong[40] ^ 1);
  const std::pair<std::string, const char*> cases[] = {
      {"xyz" + first, "log: byte 0: 3 bytes that are neither"},
      {first + "\xD3rtcm" + second, "log: byte 100: 5 bytes that are neither"},
      {first + "$GPTXT,01*00\r\n" + second, "log: byte 100: 14 bytes that are neither"},
      {first + wrong, "log: byte 100: the checksum of the frame is wrong"},
      {first + second.substr(0, 99), "log: byte 100: the frame is cut"},
      {first + second.substr(0, 4), "log: byte 100: the frame is cut"},
      {first + first, "log: byte 100: time 1.000000 s does not increase"},
      {second + first, "log: byte 100: time 1.000000 s does not increase"},
      {ubx(1, 7, std::string(91, 'x')), "log: byte 0: NAV-PVT of 91 bytes"},
      {pvt(700000000), "log: byte 0: time of week 700000.000 s is beyond the week"},
      {pvt(test::nav_pvt(1).put<std::uint32_t>(40, 0)), "log: byte 0: the sigmas of a position must be above zero"},
      {pvt(test::nav_pvt(1).put<std::uint32_t>(68, 0)), "log: byte 0: the sigmas of a velocity must be above zero"},
      {pvt(test::nav_pvt(1).put<std::int32_t>(28, 950000000)), "log: byte 0: latitude 95.0"},
      {ubx(1, 3, "status"), "holds no fix; frames NAV-PVT"},
      {"", "holds no fix"},
  };
  for (const auto& [text, expected] : cases) EXPECT_TRUE(contains(ubx_refused(text), expected));
}

TEST(Ubx, ListsWhatItRefusesWhereAsked) {
  std::string wrong = pvt(2000);
  wrong[40] = static_cast<char>(wrong[40] ^ 1);
  RowFaults faults;
  const auto gnss = ubx_of("xyz" + pvt(1000) + wrong + pvt(3000) + pvt(3000) + pvt(4000).substr(0, 50), &faults);
  EXPECT_EQ(gnss.fixes.size(), 2u);
  EXPECT_EQ(faults.count(Kind::kText), 1u);
  EXPECT_EQ(faults.count(Kind::kChecksum), 1u);
  EXPECT_EQ(faults.count(Kind::kTimeRepeated), 1u);
  EXPECT_EQ(faults.count(Kind::kFields), 1u);
  EXPECT_EQ(faults.total(), 4u);
}

// ---- inspva ----

AttitudeRecording inspva_of(const std::string& text, std::optional<Vector3d> sigma = {}, RowFaults* faults = nullptr) {
  LogFile log = log_of(text, LogFormat::kInspva);
  log.sigma = sigma;
  return read_attitude(log, faults);
}
std::string inspva_refused(const std::string& text) {
  return message_of<DataError>([&] { inspva_of(text, Vector3d(1, 2, 3)); });
}

const std::string kHead = "#INSPVAA,COM1,0,31.0,FINESTEERING,2374,1.000,02040000,5615,1541;";
std::string inspva(const std::string& week_seconds, const std::string& status = "INS_SOLUTION_GOOD",
                   const std::string& angles = "1.5,-2.5,350.0") {
  return novatel(kHead + week_seconds + ",46.5,7.25,1600.0,1.0,2.0,3.0," + angles + "," + status);
}

// Lines of manuals and recorded logs, with their own CRC.
TEST(Inspva, PublishedLogs) {
  const Vector3d sigma(0.01, 0.02, 0.03);
  const auto ascii = inspva_of(
      "#INSPVAA,COM1,0,31.0,FINESTEERING,1264,144088.000,02040000,5615,1541;1264,144088.002284950,51.116827527,"
      "-114.037738908,401.191547167,354.846489850,108.429407241,-10.837482850,1.116219952,-3.476059035,7.372686190,"
      "INS_ALIGNMENT_COMPLETE*a2913d36\r\n",
      sigma);
  EXPECT_EQ(ascii.fixes.at(0).time, 144088.002284950);
  EXPECT_TRUE(ascii.fixes[0].angles.isApprox(Vector3d(1.116219952, -3.476059035, 7.372686190) * kDegree));
  EXPECT_EQ(ascii.fixes[0].sigma, sigma);

  const auto small = inspva_of(
      "%INSPVASA,2083,374524.200;2083,374524.200000000,31.51668826020,120.38636567293,13.9998,13.1095,-12.9404,"
      "-0.0070,2.093819658,2.854168081,316.626703726,INS_SOLUTION_GOOD*8fc5adb1\n",
      sigma);
  EXPECT_TRUE(small.fixes.at(0).angles.isApprox(Vector3d(2.093819658, 2.854168081, 316.626703726) * kDegree));

  const auto extended = inspva_of(
      "#INSPVAXA,COM1,0,73.5,FINESTEERING,1695,309428.000,00000040,4e77,43562;INS_SOLUTION_GOOD,INS_PSRSP,"
      "51.11637873403,-114.03825114994,1063.6093,-16.9000,-0.0845,-0.0464,-0.0127,0.138023492,0.069459386,"
      "90.000923268,0.9428,0.6688,1.4746,0.0430,0.0518,0.0521,0.944295466,0.944567084,1.000131845,3,0*e877c178\n");
  EXPECT_EQ(extended.fixes.at(0).time, 309428);
  EXPECT_TRUE(extended.fixes[0].angles.isApprox(Vector3d(0.138023492, 0.069459386, 90.000923268) * kDegree));
  EXPECT_TRUE(extended.fixes[0].sigma.isApprox(Vector3d(0.944295466, 0.944567084, 1.000131845) * kDegree));
}

TEST(Inspva, WeekRollsOverAndWhatIsNotValidIsCounted) {
  const auto attitude = inspva_of(inspva("2374,604799.5") + novatel("#BESTPOSA,COM1;SOL_COMPUTED") + nmea("GPTXT,01") +
                                      inspva("2375,0.0", "INS_ALIGNING") + inspva("2375,0.5", "INS_SOLUTION_FREE"),
                                  Vector3d(1, 2, 3));
  ASSERT_EQ(attitude.fixes.size(), 2u);
  EXPECT_EQ(attitude.fixes[1].time, 604800.5);
  EXPECT_EQ(attitude.not_valid, 1u);
}

TEST(Inspva, Refusals) {
  const std::string good = inspva("2374,1.0");
  const std::pair<std::string, const char*> cases[] = {
      {"hello\n", "log:1: no ASCII log of NovAtel"},
      {good + "#INSPVAA,COM1;2374*00000000\n", "log:2: the CRC is missing or wrong"},
      {good + "#INSPVAA,COM1;2374*0\n", "log:2: the CRC"},
      {good + "#INSPVAA\n", "log:2: the CRC"},
      {good + "$GPTXT,01*00\n", "log:2: no ASCII log"},
      {good + novatel("#INSPVAA,COM1;2374,1.0"), "log:2: 2 fields in INSPVAA; 12 are expected"},
      {good + novatel("#INSPVAXA,COM1;2374,1.0"), "log:2: 2 fields in the header; 10 are expected"},
      {good + inspva("2374,x"), "is no number"},
      {good + inspva("2374,700000"), "log:2: `2374,700000` is no GPS week"},
      {good + inspva("2374.5,7"), "is no GPS week"},
      {good + good, "log:2: time 1.000000 s does not increase"},
      {good + inspva("2373,604799"), "does not increase"},
      {good + inspva("2374,2.0", "INS_SOLUTION_GOOD", "1,95,3"), "log:2: an angle is out of range"},
      {inspva("2374,1.0", "INS_INACTIVE"), "holds no attitude; logs INSPVAA"},
  };
  for (const auto& [text, expected] : cases) EXPECT_TRUE(contains(inspva_refused(text), expected)) << text;
  EXPECT_TRUE(contains(message_of<DataError>([&] { inspva_of(good); }),
                       "log:1: INSPVAA has no sigmas; state them in the configuration: `sigma: 0.05 0.05 0.1 deg`"));
  const std::string extended =
      novatel("%INSPVAXSA,2374,1.0;INS_SOLUTION_GOOD,INS_PSRSP,46,7,1600,50,0,0,0,1,2,3,1,1,1,1,1,1,0.1,0.2,0.3,3,0");
  EXPECT_TRUE(inspva_of(extended).fixes.at(0).sigma.isApprox(Vector3d(0.1, 0.2, 0.3) * kDegree));
  EXPECT_EQ(inspva_of(extended, Vector3d(1, 2, 3)).fixes.at(0).sigma, Vector3d(1, 2, 3)) << "the stated ones";
}

TEST(Inspva, ListsWhatItRefusesWhereAsked) {
  RowFaults faults;
  const auto attitude =
      inspva_of(inspva("2374,1.0") + "rubbish\n" + inspva("2374,1.0") + inspva("2374,2.0"), {}, &faults);
  EXPECT_EQ(attitude.fixes.size(), 2u);
  EXPECT_EQ(faults.count(Kind::kText), 1u);
  EXPECT_EQ(faults.count(Kind::kTimeRepeated), 1u);
  EXPECT_EQ(faults.total(), 2u);
}

TEST(LogFormats, EachKindOfLogNamesItsFormats) {
  const auto wrong = [](auto read, LogFormat format) {
    return message_of<ConfigError>([&] { read(log_of("", format)); });
  };
  const auto imu = [](const LogFile& log) { read_imu(log); };
  const auto gnss = [](const LogFile& log) { read_gnss(log); };
  const auto attitude = [](const LogFile& log) { read_attitude(log); };
  EXPECT_TRUE(
      contains(wrong(imu, LogFormat::kUbx), "an IMU is read from csv, kf_gins, xsens_ascii, imr, novatel or columns"));
  EXPECT_TRUE(contains(wrong(gnss, LogFormat::kImr),
                       "GNSS is read from csv, kf_gins, rtklib_pos, nmea, ubx, novatel or columns"));
  EXPECT_TRUE(contains(wrong(attitude, LogFormat::kNmea), "an attitude is read from csv, inspva or columns"));
}

}  // namespace
}  // namespace piste
