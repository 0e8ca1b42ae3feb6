#pragma once
/// Records of the formats that receivers and sensors write, with correct checksums.

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>

namespace piste::test {

/// `$BODY*HH` and a line end.
inline std::string nmea(const std::string& body) {
  unsigned char sum = 0;
  for (const char c : body) sum = static_cast<unsigned char>(sum ^ static_cast<unsigned char>(c));
  return fmt::format("${}*{:02X}\r\n", body, sum);
}

/// `TEXT*CRC` of NovAtel and a line end; TEXT begins with `#` or `%`. The CRC is computed bit by bit, without a table.
inline std::string novatel(const std::string& text) {
  std::uint32_t crc = 0;
  for (const char c : text.substr(1)) {
    crc ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) crc = (crc & 1) != 0 ? (crc >> 1) ^ 0xEDB88320U : crc >> 1;
  }
  return fmt::format("{}*{:08x}\r\n", text, crc);
}

/// Bytes that are written at offsets, in either byte order.
class Bytes {
 public:
  explicit Bytes(std::size_t size, std::endian order = std::endian::little) : text_(size, '\0'), order_(order) {}
  template <class T>
  Bytes& put(std::size_t offset, T value) {
    char* const to = text_.data() + offset;
    std::memcpy(to, &value, sizeof(T));
    if (order_ != std::endian::native) std::reverse(to, to + sizeof(T));
    return *this;
  }
  Bytes& put_text(std::size_t offset, std::string_view text) {
    text_.replace(offset, text.size(), text);
    return *this;
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
  std::endian order_;
};

inline std::string ubx(std::uint8_t frame_class, std::uint8_t id, const std::string& payload) {
  std::string frame = "\xB5\x62";
  frame += static_cast<char>(frame_class);
  frame += static_cast<char>(id);
  frame += static_cast<char>(payload.size() & 0xFF);
  frame += static_cast<char>(payload.size() >> 8);
  frame += payload;
  unsigned a = 0, b = 0;
  for (std::size_t i = 2; i < frame.size(); ++i) b += a += static_cast<unsigned char>(frame[i]);
  frame += static_cast<char>(a & 0xFF);
  frame += static_cast<char>(b & 0xFF);
  return frame;
}

/// Payload of NAV-PVT: a three-dimensional fix of 46.5 N, 7.25 W, 1600 m; sigmas 2 m √2, 3 m, 0.1 m/s √3.
inline Bytes nav_pvt(std::uint32_t time_of_week_ms) {
  Bytes payload(92);
  payload.put<std::uint32_t>(0, time_of_week_ms).put<std::uint8_t>(20, 3).put<std::uint8_t>(21, 1);
  payload.put<std::int32_t>(24, -72500000).put<std::int32_t>(28, 465000000).put<std::int32_t>(32, 1600000);
  payload.put<std::uint32_t>(40, 2828).put<std::uint32_t>(44, 3000).put<std::uint32_t>(68, 173);
  payload.put<std::int32_t>(48, 4000).put<std::int32_t>(52, -5000).put<std::int32_t>(56, 600);
  return payload;
}

/// Header of the generic IMU format of Inertial Explorer: rates, 100 Hz, scales 1e-4 deg/s and 1e-3 m/s², GPS time.
inline Bytes imr_header(std::endian order = std::endian::little) {
  Bytes header(512, order);
  header.put_text(0, "$IMURAW").put<std::int8_t>(8, order == std::endian::little ? 0 : 1).put<double>(9, 8.9);
  header.put<double>(25, 100).put<double>(33, 1e-4).put<double>(41, 1e-3).put<std::int32_t>(49, 2);
  return header;
}

inline std::string imr_record(double time, std::int32_t gyro_z, std::int32_t accel_z,
                              std::endian order = std::endian::little) {
  return Bytes(32, order).put<double>(0, time).put<std::int32_t>(16, gyro_z).put<std::int32_t>(28, accel_z).text();
}

/// Header of an Xsens log of 50 Hz, and one row of it, both with the trailing tab.
inline const std::string kXsensHeader =
    "// Start Time: 0\n// Sample rate: 50.0Hz\n// Scenario: 4.9\n// Firmware Version: 2.5.1\n"
    "Counter\tAcc_X\tAcc_Y\tAcc_Z\tGyr_X\tGyr_Y\tGyr_Z\tMag_X\tMag_Y\tMag_Z\tQuat_w\tQuat_x\tQuat_y\tQuat_z\t\n";
inline std::string xsens_row(int counter) {
  return fmt::format("{:05}\t0.1\t-0.2\t9.8\t0.01\t-0.02\t0.03\t0.5\t0.1\t-0.8\t1\t0\t0\t0\t\n", counter);
}

/// One epoch of a receiver at a time of day: position, sigmas, date and speed.
inline std::string nmea_epoch(const std::string& time, const std::string& date = "080725") {
  return nmea("GNRMC," + time + ",A,4630.000000,N,00715.000000,W,10.000,090.00," + date + ",,,R,V") +
         nmea("GNVTG,090.00,T,,M,10.000,N,18.520,K,R") +
         nmea("GNGGA," + time + ",4630.000000,N,00715.000000,W,4,12,0.80,1550.000,M,50.000,M,1.0,0000") +
         nmea("GNGST," + time + ",1.0,0.03,0.02,45.0,0.02,0.03,0.05");
}

}  // namespace piste::test
