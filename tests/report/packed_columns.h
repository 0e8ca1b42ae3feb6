#pragma once
/// The columns of a page's tables, as its script reads them.

#include <gtest/gtest.h>
#include <yaml-cpp/yaml.h>

#include <array>
#include <boost/beast/zlib/inflate_stream.hpp>
#include <cmath>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

namespace piste::test {

inline std::string from_base64(const std::string& text) {
  static const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  std::uint32_t bits = 0;
  int have = 0;
  for (const char c : text) {
    const std::size_t digit = digits.find(c);
    if (digit == std::string::npos) break;
    bits = (bits << 6) | static_cast<std::uint32_t>(digit);
    have += 6;
    if (have < 8) continue;
    have -= 8;
    out += static_cast<char>((bits >> have) & 0xffU);
  }
  return out;
}

inline std::string inflated(const std::string& bytes, std::size_t most) {
  namespace zlib = boost::beast::zlib;
  zlib::inflate_stream stream;
  std::string out(most, '\0');
  zlib::z_params z;
  z.next_in = bytes.data();
  z.avail_in = bytes.size();
  z.next_out = out.data();
  z.avail_out = out.size();
  boost::beast::error_code error;
  stream.write(z, zlib::Flush::finish, error);
  EXPECT_EQ(z.avail_in, 0U) << error.message();
  out.resize(z.total_out);
  return out;
}

/// The columns of a table as the script of a page reads them.
inline std::map<std::string, std::vector<double>> columns_of(const YAML::Node& table) {
  const auto rows = table["rows"].as<std::size_t>();
  const std::string bytes =
      inflated(from_base64(table["data"].as<std::string>()), 16 * (rows + 1) * table["columns"].size());
  std::map<std::string, std::vector<double>> out;
  for (const YAML::Node& column : table["columns"]) {
    auto at = column["at"].as<std::size_t>();
    const auto order = column["order"].as<int>();
    const auto step = column["step"].as<double>();
    std::array<double, 3> before{};
    std::vector<double>& values = out[column["name"].as<std::string>()];
    for (std::size_t i = 0; i < rows; ++i) {
      double number = 0, weight = 1;
      unsigned char byte = 0;
      do {
        byte = static_cast<unsigned char>(bytes.at(at++));
        number += (byte & 0x7fU) * weight;
        weight *= 128;
      } while ((byte & 0x80U) != 0);
      if (number == 0) {
        values.push_back(std::nan(""));
        continue;
      }
      number -= 1;
      double value = std::fmod(number, 2) == 1 ? -(number + 1) / 2 : number / 2;
      for (int k = order - 1; k >= 0; --k) {
        value += before[static_cast<std::size_t>(k)];
        before[static_cast<std::size_t>(k)] = value;
      }
      values.push_back(column["log"].as<bool>() ? std::exp(value * step) : value * step);
    }
  }
  return out;
}

inline std::map<std::string, std::vector<double>> columns_of(const std::string& json) {
  return columns_of(YAML::Load(json));  // JSON is YAML
}

}  // namespace piste::test
