// The TUM benchmark's text format (trajectory.hpp).

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <istream>
#include <ostream>
#include <sstream>

#include <lcmslam/evaluation/trajectory.hpp>
#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/files/decimal_text.hpp>

namespace lcmslam {
namespace {

constexpr double largest_coordinate = 1e9;  // m; its square and sums of it are exact enough

[[noreturn]] void fail(const std::string& name, int line, const std::string& what) {
  throw TrajectoryError(name + ":" + std::to_string(line) + ": " + what);
}

// from_chars: the numbers' meaning does not depend on the user's locale.
std::array<double, 8> parse_numbers(const std::string& text, const std::string& name, int line) {
  std::array<double, 8> numbers{};
  std::size_t count = 0;
  const char* position = text.data();
  const char* const end = position + text.size();
  while (true) {
    position = std::find_if_not(position, end, [](char c) { return c == ' '; });
    if (position == end) break;
    const char* const word_end = std::find(position, end, ' ');
    const std::string word(position, word_end);
    if (count == numbers.size()) fail(name, line, "more than 8 values; expected: t tx ty tz qx qy qz qw");
    const auto [last, error] = std::from_chars(position, word_end, numbers[count]);
    if (error != std::errc() || last != word_end) fail(name, line, "'" + word + "' is not a number");
    if (!std::isfinite(numbers[count])) fail(name, line, "'" + word + "' is not finite");
    position = word_end;
    ++count;
  }
  if (count != numbers.size()) {
    fail(name, line, std::to_string(count) + " values; expected 8: t tx ty tz qx qy qz qw");
  }
  return numbers;
}

StampedPose parse_pose(const std::array<double, 8>& v, const std::string& name, int line) {
  if (v[0] < 0 || v[0] > 9e9) {
    fail(name, line, "stamp " + std::to_string(v[0]) + "; expected seconds from 0 to 9e9");
  }
  for (int i = 1; i <= 3; ++i)
    if (std::abs(v[static_cast<std::size_t>(i)]) > largest_coordinate)
      fail(name, line,
           "position " + std::to_string(v[static_cast<std::size_t>(i)]) + "; expected at most 1e9 m");
  const Eigen::Quaterniond q(v[7], v[4], v[5], v[6]);
  if (std::abs(q.norm() - 1.0) > 0.01) {
    fail(name, line, "quaternion of norm " + std::to_string(q.norm()) + "; expected norm 1 (qx qy qz qw)");
  }
  StampedPose pose;
  pose.utime = std::llround(v[0] * 1e6);  // a double resolves 0.24 us at today's stamps
  pose.T_world_body.linear() = q.normalized().toRotationMatrix();
  pose.T_world_body.translation() << v[1], v[2], v[3];
  return pose;
}

}  // namespace

Trajectory read_tum(std::istream& text, const std::string& name) {
  Trajectory trajectory;
  std::string content;
  for (int line = 1; std::getline(text, content); ++line) {
    for (char& c : content) {
      if (c == '\t' || c == ',' || c == '\r') c = ' ';
    }
    const std::size_t first = content.find_first_not_of(' ');
    if (first == std::string::npos || content[first] == '#') continue;
    trajectory.push_back(parse_pose(parse_numbers(content, name, line), name, line));
  }
  if (text.bad()) throw TrajectoryError(name + ": reading failed");
  sort_trajectory(trajectory);
  return trajectory;
}

Trajectory read_tum(const std::filesystem::path& file) {
  std::ifstream text(file);
  if (!text || std::filesystem::is_directory(file)) {
    throw TrajectoryError(file.string() + ": cannot be opened as a trajectory file");
  }
  return read_tum(text, file.string());
}

void write_tum(std::ostream& text, const Trajectory& trajectory) {
  text << "# timestamp tx ty tz qx qy qz qw\n";
  for (const StampedPose& pose : trajectory) {
    const Eigen::Vector3d t = pose.T_world_body.translation();
    const Eigen::Quaterniond q(pose.T_world_body.linear());
    const std::string microseconds = std::to_string(1'000'000 + pose.utime % 1'000'000).substr(1);
    std::string line = std::to_string(pose.utime / 1'000'000) + '.' + microseconds;
    for (const double number : {t.x(), t.y(), t.z()}) append_fixed(line += ' ', number, 9);
    for (const double number : {q.x(), q.y(), q.z(), q.w()}) append_fixed(line += ' ', number, 12);
    text << line << '\n';
  }
}

void write_tum(const std::filesystem::path& file, const Trajectory& trajectory) {
  std::ostringstream text;
  write_tum(text, trajectory);
  write_atomically(FilePlace(file), text.str());
}

}  // namespace lcmslam
