#include <lcmslam/datasets/pose_files.hpp>

#include <Eigen/SVD>
#include <cmath>

#include <lcmslam/datasets/text_rows.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

using Pose = std::optional<Eigen::Isometry3d>;

// tx ty tz qx qy qz qw
Pose from_quaternion(const std::vector<double>& n) {
  const double quaternion[4] = {n[6], n[3], n[4], n[5]};
  const double norm = std::sqrt(n[3] * n[3] + n[4] * n[4] + n[5] * n[5] + n[6] * n[6]);
  if (std::abs(norm - 1) > 1e-2) return std::nullopt;
  return make_transform(n.data(), quaternion);
}

// The nearest rotation; nothing when the matrix is far from one (published poses are rounded).
Pose from_matrix(const std::vector<double>& n) {
  if (n.size() == 16 && (std::abs(n[12]) + std::abs(n[13]) + std::abs(n[14]) + std::abs(n[15] - 1) > 1e-6))
    return std::nullopt;
  Eigen::Matrix3d M;
  M << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  if ((M * M.transpose() - Eigen::Matrix3d::Identity()).norm() > 0.05 || M.determinant() < 0)
    return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(M, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  T.linear() = svd.matrixU() * svd.matrixV().transpose();
  T.translation() << n[3], n[7], n[11];
  return T;
}

void report(const fs::path& file, int line, const std::string& expected, Recording& recording) {
  recording.problems.push_back(at_line(file, line, "pose left out, expected " + expected));
}

// Four rows of four numbers, starting at row `first`.
Pose block(const std::vector<TextRow>& rows, std::size_t first) {
  std::vector<double> numbers;
  for (std::size_t i = first; i < first + 4; ++i) {
    const auto row = i < rows.size() ? row_numbers(rows[i], 0, 4) : std::nullopt;
    if (!row) return std::nullopt;
    numbers.insert(numbers.end(), row->begin(), row->end());
  }
  return from_matrix(numbers);
}

void read_log(const fs::path& file, const std::vector<TextRow>& rows,
              const std::function<std::optional<Utime>(long)>& time_of, Recording& recording) {
  for (std::size_t i = 0; i < rows.size();) {
    const auto header = row_numbers(rows[i], 0, 3);
    if (!header) {  // go on to the next line of three numbers
      report(file, rows[i].line, "three whole numbers in front of a 4x4 matrix", recording);
      while (i < rows.size() && rows[i].words.size() != 3) ++i;
      continue;
    }
    const Pose pose = block(rows, i + 1);
    if (!pose)
      report(file, rows[i].line, "a rigid 4x4 matrix after this line", recording);
    else if (const auto utime = time_of(std::lround((*header)[0])))
      recording.truth.push_back({*utime, *pose});
    ++i;
    while (i < rows.size() && rows[i].words.size() != 3) ++i;
  }
}

}  // namespace

void read_stamped_poses(const fs::path& file, Recording& recording) {
  for (const TextRow& row : read_rows(file)) {
    const auto stamp = parse_stamp(row.words[0]);
    const auto numbers = row_numbers(row, 1, 7);
    const Pose pose = numbers ? from_quaternion(*numbers) : std::nullopt;
    if (stamp && pose)
      recording.truth.push_back({*stamp, *pose});
    else
      report(file, row.line, "stamp tx ty tz qx qy qz qw with a unit quaternion", recording);
  }
}

void read_counted_poses(const fs::path& file, const std::string& format,
                        const std::function<std::optional<Utime>(long)>& time_of, Recording& recording) {
  const std::vector<TextRow> rows = read_rows(file);
  if (format == "log") return read_log(file, rows, time_of, recording);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    Pose pose;
    if (format == "quaternions") {
      const auto numbers = row_numbers(rows[i], 0, 7);
      if (numbers) pose = from_quaternion(*numbers);
      if (!pose) report(file, rows[i].line, "tx ty tz qx qy qz qw with a unit quaternion", recording);
    } else {
      const auto numbers = row_numbers(rows[i], 0, rows[i].words.size() == 12 ? 12 : 16);
      if (numbers) pose = from_matrix(*numbers);
      if (!pose) report(file, rows[i].line, "12 or 16 numbers of a rigid matrix", recording);
    }
    if (const auto utime = pose ? time_of(static_cast<long>(i)) : std::nullopt)
      recording.truth.push_back({*utime, *pose});
  }
}

void read_pose_file(const fs::path& file, Utime utime, Recording& recording) {
  const std::vector<TextRow> rows = read_rows(file);
  const Pose pose = rows.size() == 4 ? block(rows, 0) : std::nullopt;
  if (pose)
    recording.truth.push_back({utime, *pose});
  else
    recording.problems.push_back(file.string() +
                                 ": pose left out, expected four lines of a rigid 4x4 matrix");
}

}  // namespace lcmslam
