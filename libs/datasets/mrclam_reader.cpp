// UTIAS Multi-Robot Cooperative Localization and Mapping (Leung et al., IJRR 30(8), 2011).

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <sstream>

#include <lcmslam/datasets/landmark_recording.hpp>
#include <lcmslam/datasets/text_rows.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

constexpr int last_robot = 5;          // subjects 1 to 5 are robots, the others landmarks
constexpr double longest_run = 86400;  // s; the published ones last 15 to 70 minutes

fs::path robot_file(const fs::path& folder, int robot, const std::string& what) {
  return folder / ("Robot" + std::to_string(robot) + "_" + what + ".dat");
}

std::string joined(const TextRow& row) {
  std::string text;
  for (const std::string& word : row.words) text += (text.empty() ? "" : " ") + word;
  return text;
}

// Calls take(numbers) for each row of `count` numbers; others, and those that take refuses, are problems.
template <class Take>
void read_table(const fs::path& file, std::size_t count, const std::string& expected,
                LandmarkRecording& recording, Take take) {
  std::size_t good = 0;
  for (const TextRow& row : read_rows(file)) {
    const auto numbers = row_numbers(row, 0, count);
    if (numbers && take(*numbers))
      ++good;
    else
      recording.problems.push_back(
          at_line(file, row.line, "'" + joined(row) + "' left out, expected: " + expected));
  }
  if (good == 0) throw DatasetError(file.string() + ": has no row of: " + expected);
}

bool is_stamp(double seconds) {
  return seconds >= 0 && seconds < 9e9;
}

Utime to_utime(double seconds) {
  return std::llround(1e6 * seconds);
}

bool is_subject(double number) {
  return number >= 1 && number < 1e6 && number == std::floor(number);
}

std::map<int, int> read_barcodes(const fs::path& folder, LandmarkRecording& recording) {
  std::map<int, int> subject_of;
  read_table(folder / "Barcodes.dat", 2, "subject barcode", recording, [&](const auto& row) {
    if (!is_subject(row[0]) || !is_subject(row[1])) return false;
    subject_of[static_cast<int>(row[1])] = static_cast<int>(row[0]);
    return true;
  });
  return subject_of;
}

Feature make_feature(int subject, double measured, double bearing, const MrclamSensor& sensor) {
  const double along_ray = sensor.range_along_axis ? measured / std::cos(bearing) : measured;
  const double range = (along_ray - sensor.range_offset) / sensor.range_scale;
  Feature feature;
  feature.kind = MeasurementKind::range_bearing;
  feature.landmark_id = subject;
  feature.point = Eigen::Vector3d(range, bearing, 0).cast<float>();
  feature.depth_sigma = static_cast<float>(sensor.range_sigma + sensor.range_sigma_per_m2 * range * range);
  return feature;
}

// A frame without an image: one pixel wide, so that pixel_sigma / fx is the bearing's sigma.
FeatureFrame make_frame(Utime utime, std::size_t seq, const std::string& name, double bearing_sigma) {
  FeatureFrame frame;
  frame.utime = utime;
  frame.seq = static_cast<std::int64_t>(seq);
  frame.sensor = name;
  frame.width = frame.height = 1;
  frame.fx = frame.fy = 1;
  frame.pixel_sigma = bearing_sigma;
  frame.has_mount = true;
  return frame;
}

// Frames without features where the camera saw no landmark for long.
void fill_gaps(Utime begin, Utime end, const MrclamSensor& sensor, LandmarkRecording& recording) {
  const Utime period = to_utime(sensor.frame_period);
  const std::string name = recording.frames.front().sensor;
  std::vector<FeatureFrame> filled;
  Utime next = begin;
  const auto fill_until = [&](Utime utime) {
    for (; next + period <= utime; next += period)
      filled.push_back(make_frame(next, 0, name, sensor.bearing_sigma));
  };
  for (FeatureFrame& frame : recording.frames) {
    fill_until(frame.utime);
    next = std::max(next, frame.utime + period);
    filled.push_back(std::move(frame));
  }
  fill_until(end);
  for (std::size_t i = 0; i < filled.size(); ++i) filled[i].seq = static_cast<std::int64_t>(i);
  recording.frames = std::move(filled);
}

/// What lies so far apart is a damaged stamp, and would be filled with as many frames.
void check_duration(const fs::path& folder, int robot, const LandmarkRecording& recording) {
  const Utime begin = std::min(recording.twists.front().utime, recording.frames.front().utime);
  const Utime end = std::max(recording.twists.back().utime, recording.frames.back().utime);
  const auto seconds = [](Utime utime) { return 1e-6 * static_cast<double>(utime); };
  if (seconds(end - begin) <= longest_run) return;
  std::ostringstream text;
  text << std::fixed << std::setprecision(3) << (folder / ("Robot" + std::to_string(robot))).string()
       << "_Odometry.dat and _Measurement.dat: stamps from " << seconds(begin) << " to " << seconds(end)
       << " s, expected a run of at most " << std::setprecision(0) << longest_run << " s";
  throw DatasetError(text.str());
}

void read_measurements(const fs::path& file, const std::map<int, int>& subject_of, const std::string& name,
                       const MrclamSensor& sensor, LandmarkRecording& recording) {
  std::map<Utime, std::vector<Feature>> seen;
  int robots = 0, unknown = 0;
  read_table(file, 4, "stamp barcode range bearing", recording, [&](const auto& row) {
    if (!is_stamp(row[0]) || !is_subject(row[1]) || !(row[2] > 0 && row[2] < 1000) ||
        !(std::abs(row[3]) < 1.5))
      return false;
    const auto subject = subject_of.find(static_cast<int>(row[1]));
    unknown += subject == subject_of.end();
    robots += subject != subject_of.end() && subject->second <= last_robot;
    if (subject == subject_of.end() || subject->second <= last_robot) return true;
    const Feature feature = make_feature(subject->second, row[2], row[3], sensor);
    if (feature.point.x() > 0) seen[to_utime(row[0])].push_back(feature);
    return feature.point.x() > 0;
  });
  if (seen.empty())
    throw DatasetError(file.string() + ": sees no landmark: " + std::to_string(robots) +
                       " observations of other robots, " + std::to_string(unknown) +
                       " of barcodes that nobody wears");
  for (auto& [utime, features] : seen) {
    recording.frames.push_back(make_frame(utime, 0, name, sensor.bearing_sigma));
    recording.frames.back().features = std::move(features);
  }
  if (robots > 0)
    recording.notes.push_back(std::to_string(robots) + " observations of other robots left out");
  if (unknown > 0)
    recording.notes.push_back(std::to_string(unknown) +
                              " observations of barcodes that nobody wears left out");
}

}  // namespace

std::vector<int> mrclam_robots(const fs::path& folder) {
  std::vector<int> robots;
  if (!fs::exists(folder / "Barcodes.dat")) return robots;
  for (int robot = 1; robot <= last_robot; ++robot)
    if (fs::exists(robot_file(folder, robot, "Odometry")) &&
        fs::exists(robot_file(folder, robot, "Measurement")))
      robots.push_back(robot);
  return robots;
}

LandmarkRecording read_mrclam(const fs::path& folder, int robot, const MrclamSensor& sensor) {
  LandmarkRecording recording;
  const std::map<int, int> subject_of = read_barcodes(folder, recording);
  read_table(robot_file(folder, robot, "Odometry"), 3, "stamp v w", recording, [&](const auto& row) {
    if (!is_stamp(row[0]) || !(std::abs(row[1]) < 100) || !(std::abs(row[2]) < 100)) return false;
    recording.twists.push_back({to_utime(row[0]), {row[1], 0, 0}, {0, 0, row[2]}});
    return true;
  });
  std::stable_sort(recording.twists.begin(), recording.twists.end(),
                   [](const Twist& a, const Twist& b) { return a.utime < b.utime; });
  read_measurements(robot_file(folder, robot, "Measurement"), subject_of,
                    "mrclam robot " + std::to_string(robot), sensor, recording);
  check_duration(folder, robot, recording);
  fill_gaps(recording.twists.front().utime, recording.twists.back().utime, sensor, recording);

  if (const fs::path file = robot_file(folder, robot, "Groundtruth"); fs::exists(file))
    read_table(file, 4, "stamp x y heading", recording, [&](const auto& row) {
      if (!is_stamp(row[0])) return false;
      recording.truth.push_back({to_utime(row[0]), planar_pose(row[1], row[2], row[3])});
      return true;
    });
  sort_trajectory(recording.truth);
  if (const fs::path file = folder / "Landmark_Groundtruth.dat"; fs::exists(file))
    read_table(file, 5, "subject x y x-sigma y-sigma", recording, [&](const auto& row) {
      if (!is_subject(row[0])) return false;
      recording.landmark_truth[static_cast<int>(row[0])] = {row[1], row[2]};
      return true;
    });
  recording.notes.push_back("where no landmark was seen, a frame without features every " +
                            std::to_string(std::lround(1000 * sensor.frame_period)) + " ms");
  return recording;
}

}  // namespace lcmslam
