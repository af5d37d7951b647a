#include <algorithm>
#include <set>

#include <lcmslam/configuration/share.hpp>
#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/datasets/description.hpp>
#include <lcmslam/datasets/image_file.hpp>
#include <lcmslam/datasets/readers.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/imaging/io/encoded_frame.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

// Frames of a recording, read when they are asked for.
class FolderSource : public RgbdSource {
 public:
  FolderSource(Recording recording, RgbdCalibration calibration, std::string truth_frame, double depth_scale,
               int jpeg_quality)
      : recording_(std::move(recording)),
        calibration_(std::move(calibration)),
        truth_frame_(std::move(truth_frame)),
        depth_scale_(depth_scale),
        jpeg_quality_(jpeg_quality) {}

  const RgbdCalibration& calibration() const override { return calibration_; }
  std::size_t size() const override { return recording_.frames.size(); }
  Entry entry(std::size_t index) const override {
    return {recording_.frames.at(index).utime, recording_.frames.at(index).depth_utime};
  }
  const Trajectory& truth() const override { return recording_.truth; }
  const std::string& truth_frame() const override { return truth_frame_; }
  const std::vector<std::string>& notes() const override { return recording_.notes; }
  const std::vector<std::string>& problems() const override { return recording_.problems; }

  std::optional<EncodedFrame> frame(std::size_t index) override {
    const FrameFiles& files = recording_.frames.at(index);
    try {
      EncodedFrame frame;
      frame.utime = files.utime;
      frame.seq = static_cast<std::int64_t>(index);
      frame.sensor = calibration_.sensor;
      frame.colour = load_colour(files.colour, files.utime, calibration_.colour, jpeg_quality_);
      frame.depth =
          encode_depth(load_depth(files.depth, calibration_.depth, depth_scale_), files.depth_utime);
      return frame;
    } catch (const CodecError& error) {
      if (reported_.insert(index).second) recording_.problems.emplace_back(error.what());
      return std::nullopt;
    }
  }

 private:
  Recording recording_;
  RgbdCalibration calibration_;
  std::string truth_frame_;
  double depth_scale_;
  int jpeg_quality_;
  std::set<std::size_t> reported_;
};

Recording read_recording(const fs::path& folder, const Description& description,
                         const CalibrationOf& calibration_of) {
  if (description.format == "tum") return read_tum_folder(folder, description, calibration_of);
  if (description.format == "seven_scenes") return read_seven_scenes(folder, description);
  return read_numbered_files(folder, description);
}

RgbdCalibration find_calibration(const fs::path& folder, const DatasetOptions& options,
                                 const Description& description, Recording& recording) {
  if (!options.calibration.empty()) return load_calibration(options.calibration);
  if (fs::exists(folder / "calibration.yaml")) return load_calibration(folder / "calibration.yaml");
  for (const auto& [name, file] : description.calibration_by_name) {
    if (recording.name_in_files.find(name) == std::string::npos) continue;
    recording.notes.push_back("intrinsics of " + file.filename().string() + ": the files are of " + name);
    return load_calibration(file);
  }
  if (description.calibration.empty())
    throw DatasetError(folder.string() +
                       ": no calibration; put a calibration.yaml beside the data, or name one with "
                       "--calibration or in the data set's YAML (keys: config/calibration/tum_fr1.yaml)");
  recording.notes.push_back("no calibration.yaml beside the data: intrinsics of " +
                            description.calibration.filename().string() + " assumed");
  return load_calibration(description.calibration);
}

// Poses of the depth camera become those of the colour camera.
std::string settle_truth(const std::string& truth_of, const RgbdCalibration& calibration,
                         Recording& recording) {
  sort_trajectory(recording.truth);
  if (truth_of == "depth")
    recording.truth = in_other_frame(recording.truth, calibration.T_colour_depth.inverse());
  if (recording.truth.empty()) recording.notes.emplace_back("no true poses");
  return truth_of == "robot" ? "robot" : "camera";
}

bool is_ros2_in_sqlite(const fs::path& path) {
  if (!fs::is_directory(path)) return path.extension() == ".db3";
  return std::any_of(fs::directory_iterator(path), fs::directory_iterator(),
                     [](const fs::directory_entry& entry) { return entry.path().extension() == ".db3"; });
}

}  // namespace

std::unique_ptr<RgbdSource> open_dataset(const fs::path& folder, const DatasetOptions& options) {
  if (is_ros2_in_sqlite(folder))
    throw DatasetError(folder.string() +
                       ": is a ROS 2 recording in SQLite; ros2 bag convert makes MCAP of it (docs/ROS.md)");
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw DatasetError(folder.string() + (folder.extension() == ".lcmlog"
                                              ? ": is an LCM log already, not a folder of images"
                                              : ": is a file, not a folder of images"));
  if (!fs::is_directory(folder)) throw DatasetError(folder.string() + ": no such folder");
  const fs::path config_folder = options.config_folder.empty() ? share_path("config") : options.config_folder;
  const Description description = find_description(folder, options, config_folder);
  std::optional<RgbdCalibration> calibration;
  const CalibrationOf calibration_of = [&](Recording& of) -> const RgbdCalibration& {
    if (!calibration) calibration = find_calibration(folder, options, description, of);
    return *calibration;
  };
  Recording recording = read_recording(folder, description, calibration_of);
  if (recording.frames.empty()) {
    const std::string first = recording.problems.empty() ? "" : " (" + recording.problems.front() + ")";
    throw DatasetError(folder.string() + ": no frame with a colour and a depth image" + first);
  }
  std::string truth_frame = settle_truth(description.truth_of, calibration_of(recording), recording);
  return std::make_unique<FolderSource>(std::move(recording), *calibration, std::move(truth_frame),
                                        description.depth_scale, options.jpeg_quality);
}

}  // namespace lcmslam
