#include <lcmslam/evaluation/pose_text.hpp>

#include <Eigen/SVD>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>

#include <lcmslam/files/atomic_file.hpp>
#include <lcmslam/files/decimal_text.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

constexpr double latest_seconds = 9e9;
constexpr double kitti_period = 0.1;       // s
constexpr double farthest_position = 1e9;  // m
const char* const unknown = "unknown";     // a frame
const char* const formats =
    "expected a line of 8 values (TUM: t tx ty tz qx qy qz qw, s), of 8 or more with a stamp in ns (EuRoC: "
    "t,px,py,pz,qw,qx,qy,qz) or of 12 (KITTI: a 3x4 matrix)";

[[noreturn]] void wrong_line(const fs::path& file, int line, const std::string& what) {
  throw TrajectoryError(file.string() + ":" + std::to_string(line) + ": " + what);
}

struct PoseRow {
  int line = 0;
  bool commas = false;
  std::vector<std::string> words;
};

/// What stands between blanks, tabs and commas; no comments, no empty lines.
std::vector<PoseRow> read_pose_rows(const fs::path& file, std::string& head) {
  std::ifstream text(file);
  if (!text || fs::is_directory(file))
    throw TrajectoryError(file.string() + ": cannot be opened as a trajectory file");
  std::vector<PoseRow> rows;
  std::string content;
  for (int line = 1; std::getline(text, content); ++line) {
    const bool commas = content.find(',') != std::string::npos;
    std::replace_if(
        content.begin(), content.end(), [](char c) { return c == '\t' || c == ',' || c == '\r'; }, ' ');
    std::istringstream words(content);
    PoseRow row{line, commas, {}};
    for (std::string word; words >> word;) row.words.push_back(word);
    if (row.words.empty()) continue;
    if (row.words[0][0] != '#')
      rows.push_back(std::move(row));
    else if (rows.empty())
      head += content + "\n";
  }
  if (text.bad()) throw TrajectoryError(file.string() + ": reading failed");
  return rows;
}

/// from_chars: the numbers' meaning does not depend on the user's locale.
double number_at(const fs::path& file, const PoseRow& row, std::size_t i) {
  const std::string& word = row.words[i];
  double value = 0;
  const auto [last, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || last != word.data() + word.size())
    wrong_line(file, row.line, "'" + word + "' is not a number");
  if (!std::isfinite(value)) wrong_line(file, row.line, "'" + word + "' is not finite");
  return value;
}

bool is_nanoseconds(const std::string& word) {
  return word.size() >= 15 &&
         std::all_of(word.begin(), word.end(), [](char c) { return c >= '0' && c <= '9'; });
}

PoseFormat format_of(const fs::path& file, const PoseRow& row) {
  if (row.words.size() == 12 && !is_nanoseconds(row.words[0])) return PoseFormat::kitti;
  if (row.words.size() >= 8 && is_nanoseconds(row.words[0])) {
    if (row.commas) return PoseFormat::euroc;
    wrong_line(file, row.line, "stamp " + row.words[0] + " seems to be in ns; " + formats);
  }
  if (row.words.size() == 8) return PoseFormat::tum;
  wrong_line(file, row.line, std::to_string(row.words.size()) + " values; " + formats);
}

Eigen::Vector3d position_at(const fs::path& file, const PoseRow& row, const std::array<std::size_t, 3>& at) {
  Eigen::Vector3d p;
  for (int i = 0; i < 3; ++i) {
    p[i] = number_at(file, row, at[static_cast<std::size_t>(i)]);
    if (std::abs(p[i]) > farthest_position)
      wrong_line(file, row.line, "position " + std::to_string(p[i]) + "; expected at most 1e9 m");
  }
  return p;
}

// Stamps in ns are whole numbers that a double does not hold.
StampedPose euroc_pose(const fs::path& file, const PoseRow& row) {
  if (row.words.size() < 8 || !is_nanoseconds(row.words[0]))
    wrong_line(file, row.line, "expected a stamp in ns and at least 7 values behind it (EuRoC)");
  std::int64_t ns = 0;
  const std::string& stamp = row.words[0];
  if (std::from_chars(stamp.data(), stamp.data() + stamp.size(), ns).ec != std::errc() ||
      static_cast<double>(ns) > 1e9 * latest_seconds)
    wrong_line(file, row.line, "stamp " + stamp + "; expected at most 9e18 ns");
  const Eigen::Quaterniond q(number_at(file, row, 4), number_at(file, row, 5), number_at(file, row, 6),
                             number_at(file, row, 7));
  if (std::abs(q.norm() - 1) > 0.01)
    wrong_line(file, row.line,
               "quaternion of norm " + std::to_string(q.norm()) + "; expected norm 1 (qw qx qy qz, EuRoC)");
  StampedPose pose;
  pose.utime = ns / 1000;
  pose.T_world_body.linear() = q.normalized().toRotationMatrix();
  pose.T_world_body.translation() = position_at(file, row, {1, 2, 3});
  return pose;
}

StampedPose kitti_pose(const fs::path& file, const PoseRow& row) {
  if (row.words.size() != 12)
    wrong_line(file, row.line,
               std::to_string(row.words.size()) + " values; expected 12 of a 3x4 matrix (KITTI)");
  Eigen::Matrix3d M;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) M(r, c) = number_at(file, row, static_cast<std::size_t>(4 * r + c));
  if ((M * M.transpose() - Eigen::Matrix3d::Identity()).norm() > 0.05 || M.determinant() < 0)
    wrong_line(file, row.line, "the left 3x3 numbers are no rotation (KITTI: a 3x4 matrix, row by row)");
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  StampedPose pose;
  pose.T_world_body.linear() = svd.matrixU() * svd.matrixV().transpose();
  pose.T_world_body.translation() = position_at(file, row, {3, 7, 11});
  return pose;
}

/// The stamps of a KITTI file's lines; `told`: where they come from, when that is assumed.
std::vector<Utime> kitti_times(const fs::path& file, std::size_t poses, std::string& told) {
  std::vector<Utime> times;
  for (const fs::path& name :
       {file.parent_path() / (file.stem().string() + "_times.txt"), file.parent_path() / "times.txt"}) {
    if (!fs::exists(name)) continue;
    std::string head;
    for (const PoseRow& row : read_pose_rows(name, head)) {
      const double seconds = number_at(name, row, 0);
      if (seconds < 0 || seconds > latest_seconds)
        wrong_line(name, row.line, "stamp " + row.words[0] + "; expected seconds from 0 to 9e9");
      times.push_back(std::llround(1e6 * seconds));
    }
    if (times.size() != poses)
      throw TrajectoryError(name.string() + ": " + std::to_string(times.size()) + " stamps for the " +
                            std::to_string(poses) + " poses of " + file.string() + "; expected one a pose");
    return times;
  }
  for (std::size_t i = 0; i < poses; ++i)
    times.push_back(std::llround(1e6 * kitti_period * static_cast<double>(i)));
  told = "has no stamps and there is no times.txt beside it: 10 Hz are assumed";
  return times;
}

/// The word behind `key:` in the file's first comments.
std::string head_word(const std::string& head, const std::string& key) {
  std::istringstream words(head);
  for (std::string word; words >> word;)
    if (word == key + ":" && words >> word) return word == unknown ? "" : word;
  return "";
}

}  // namespace

PoseText read_pose_text(const fs::path& file) {
  std::string head;
  const std::vector<PoseRow> rows = read_pose_rows(file, head);
  PoseText result;
  result.body = head_word(head, "body");
  result.frame = head_word(head, "frame");
  if (rows.empty()) return result;
  result.format = format_of(file, rows[0]);
  if (result.format == PoseFormat::tum) {
    result.trajectory = read_tum(file);
    return result;
  }
  for (const PoseRow& row : rows)
    result.trajectory.push_back(result.format == PoseFormat::euroc ? euroc_pose(file, row)
                                                                   : kitti_pose(file, row));
  if (result.format == PoseFormat::kitti) {
    const auto times = kitti_times(file, rows.size(), result.assumption);
    for (std::size_t i = 0; i < rows.size(); ++i) result.trajectory[i].utime = times[i];
  }
  sort_trajectory(result.trajectory);
  return result;
}

void save_tum(const fs::path& file, const Trajectory& trajectory, const PoseFrames& frames) {
  std::ostringstream text;
  const auto named = [](const std::string& name) { return name.empty() ? std::string(unknown) : name; };
  text << "# frame: " << named(frames.frame) << ", body: " << named(frames.body) << "\n";
  write_tum(text, trajectory);
  write_atomically(FilePlace(file), text.str());
}

void save_kitti(const fs::path& file, const Trajectory& trajectory) {
  std::string poses, times;
  for (const StampedPose& pose : trajectory) {
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 4; ++c) {
        append_general(poses, pose.T_world_body.matrix()(r, c), 12);
        poses += r == 2 && c == 3 ? '\n' : ' ';
      }
    append_fixed(times, 1e-6 * static_cast<double>(pose.utime), 6);
    times += '\n';
  }
  write_atomically(FilePlace(file.parent_path() / (file.stem().string() + "_times.txt")), times);
  write_atomically(FilePlace(file), poses);
}

}  // namespace lcmslam
