#pragma once
// What the page is told, an item at a time: a header (JSON) and bytes (docs/LIVE_PAGE.md, which has the
// meaning of each). All bytes are little endian.

#include <Eigen/Core>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

namespace lcmslam {

struct PageItem {
  std::string channel, key;
  nlohmann::json header = nlohmann::json::object();
  std::string bytes = {};
  std::optional<Eigen::Vector3f> place = {};  ///< m, map; bulk that is near is wanted first
};

/// Appends a number's bytes. The machines that this runs on are little endian.
template <class Number>
void append_bytes(std::string& bytes, Number number) {
  char raw[sizeof(Number)];
  std::memcpy(raw, &number, sizeof(Number));
  bytes.append(raw, sizeof(Number));
}

/// To hundredths of a millimetre: what lies below is noise, and digits are bytes.
inline double rounded_for_page(double value) {
  return std::isfinite(value) ? std::round(1e5 * value) / 1e5 : 0;
}

}  // namespace lcmslam
