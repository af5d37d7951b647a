// Victoria Park (Nebot, Guivant; University of Sydney) in iSAM's text form: truck odometry and trees.

#include <cmath>
#include <fstream>
#include <sstream>

#include <lcmslam/datasets/landmark_recording.hpp>
#include <lcmslam/datasets/text_rows.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const fs::path& file, const TextRow& row, const std::string& expected) {
  std::string text;
  for (const std::string& word : row.words) text += (text.empty() ? "" : " ") + word;
  throw DatasetError(at_line(file, row.line, "'" + text + "': expected " + expected));
}

bool is_index(double number) {
  return number >= 0 && number < 2e9 && number == std::floor(number);
}

// x, y and heading of a 6x6 covariance from an upper triangle of three rows.
Matrix6d planar_covariance(const double* upper) {
  constexpr int at[3] = {0, 1, 5};
  Matrix6d covariance = Matrix6d::Zero();
  for (int i = 0; i < 3; ++i)
    for (int j = i; j < 3; ++j) covariance(at[i], at[j]) = covariance(at[j], at[i]) = *upper++;
  return covariance;
}

class Reader {
 public:
  Reader(const fs::path& file, const VictoriaParkSettings& settings) : file_(file), settings_(settings) {}

  LandmarkRecording read() {
    for (const TextRow& row : read_rows(file_)) {
      if (row.words[0] == "ODOMETRY")
        odometry(row);
      else if (row.words[0] == "LANDMARK")
        landmark(row);
      else
        fail(file_, row, "ODOMETRY or LANDMARK");
    }
    if (recording_.odometry.size() < 2) throw DatasetError(file_.string() + ": has no row ODOMETRY");
    recording_.notes.push_back("no stamps: a pose every " +
                               std::to_string(std::lround(1000 * settings_.period)) + " ms assumed");
    return std::move(recording_);
  }

 private:
  void odometry(const TextRow& row) {
    const auto n = row_numbers(row, 1, 11);
    if (!n || !is_index((*n)[0]) || !is_index((*n)[1]))
      fail(file_, row, "ODOMETRY i j dx dy dtheta and 6 numbers of its covariance");
    const Matrix6d Q = planar_covariance(n->data() + 5);
    if (!(Q(0, 0) > 0 && Q(1, 1) > 0 && Q(5, 5) > 0)) fail(file_, row, "positive variances");
    if (recording_.odometry.empty()) add_pose(static_cast<long>((*n)[0]), MotionSample{});
    if (static_cast<long>((*n)[0]) != pose_)
      fail(file_, row, "a motion that begins at the pose before, " + std::to_string(pose_));
    const Eigen::Isometry3d step = planar_pose((*n)[2], (*n)[3], (*n)[4]);
    MotionSample next = recording_.odometry.back();
    const Matrix6d A = adjoint(step.inverse());
    next.T_odom_robot = next.T_odom_robot * step;
    next.covariance = A * next.covariance * A.transpose() + Q;
    next.covariance = (0.5 * (next.covariance + next.covariance.transpose())).eval();
    add_pose(static_cast<long>((*n)[1]), next);
  }

  void landmark(const TextRow& row) {
    const auto n = row_numbers(row, 1, 7);
    if (!n || !is_index((*n)[0]) || !is_index((*n)[1]))
      fail(file_, row, "LANDMARK i l dx dy and 3 numbers of its covariance");
    if (recording_.odometry.empty()) add_pose(static_cast<long>((*n)[0]), MotionSample{});
    if (static_cast<long>((*n)[0]) != pose_)
      fail(file_, row, "a landmark seen from the newest pose, " + std::to_string(pose_));
    const double xx = (*n)[4], xy = (*n)[5], yy = (*n)[6];
    if (!(xx > 0 && yy > 0 && xx * yy > xy * xy)) fail(file_, row, "a positive covariance");
    Feature feature;
    feature.kind = MeasurementKind::planar;
    feature.landmark_id = static_cast<std::int32_t>((*n)[1]);
    feature.point = Eigen::Vector3d((*n)[2], (*n)[3], 0).cast<float>();
    feature.depth_sigma = static_cast<float>(std::sqrt(0.5 * (xx + yy)));  // alike on both axes
    recording_.frames.back().features.push_back(feature);
  }

  void add_pose(long index, MotionSample sample) {
    pose_ = index;
    const auto count = static_cast<Utime>(recording_.odometry.size());
    sample.utime = settings_.start + count * std::llround(1e6 * settings_.period);
    FeatureFrame frame;
    frame.utime = sample.utime;
    frame.seq = count;
    frame.sensor = "victoria park laser";
    frame.width = frame.height = 1;
    frame.fx = frame.fy = 1;
    frame.has_mount = true;
    recording_.odometry.push_back(sample);
    recording_.frames.push_back(frame);
  }

  fs::path file_;
  VictoriaParkSettings settings_;
  LandmarkRecording recording_;
  long pose_ = 0;  // index of the newest
};

}  // namespace

bool is_victoria_park(const fs::path& file) {
  if (!fs::is_regular_file(file)) return false;
  std::string begin(std::size_t{1} << 16, ' ');  // it may be any file, of gigabytes
  std::ifstream stream(file, std::ios::binary);
  stream.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  begin.resize(static_cast<std::size_t>(stream.gcount()));
  std::istringstream lines(begin);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string first;
    if (words >> first && first[0] != '#') return first == "ODOMETRY" || first == "LANDMARK";
  }
  return false;
}

LandmarkRecording read_victoria_park(const fs::path& file, const VictoriaParkSettings& settings) {
  return Reader(file, settings).read();
}

}  // namespace lcmslam
