// TUM RGB-D folders (Sturm et al., IROS 2012) and others of the same layout.

#include <algorithm>
#include <cmath>

#include <lcmslam/datasets/pose_files.hpp>
#include <lcmslam/datasets/readers.hpp>
#include <lcmslam/datasets/stamp_pairs.hpp>
#include <lcmslam/datasets/text_rows.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

struct StampedFile {
  Utime utime;
  std::string file;
};

// "stamp file" a line. TUM's header "# file: 'rgbd_dataset_freiburg1_rpy.bag'" names the recording.
std::vector<StampedFile> read_list(const fs::path& list, Recording& recording) {
  std::vector<StampedFile> files;
  std::vector<std::string> comments;
  for (const TextRow& row : read_rows(list, &comments)) {
    const auto stamp = parse_stamp(row.words[0]);
    if (stamp && row.words.size() == 2)
      files.push_back({*stamp, row.words[1]});
    else
      recording.problems.push_back(at_line(list, row.line, "left out, expected: stamp file"));
  }
  for (const std::string& comment : comments)
    if (const auto at = comment.find("file:"); at != std::string::npos)
      recording.name_in_files = comment.substr(at + 5);
  std::stable_sort(files.begin(), files.end(), [](auto& a, auto& b) { return a.utime < b.utime; });
  return files;
}

void associate(const std::vector<StampedFile>& colour, const std::vector<StampedFile>& depth,
               Utime depth_offset, Utime max_difference, const fs::path& folder, Recording& recording) {
  const auto stamps = [](const std::vector<StampedFile>& files) {
    std::vector<Utime> utimes;
    utimes.reserve(files.size());
    for (const StampedFile& file : files) utimes.push_back(file.utime);
    return utimes;
  };
  for (const auto& [i, j] : pair_by_stamps(stamps(colour), stamps(depth), depth_offset, max_difference))
    recording.frames.push_back(
        {colour[i].utime, depth[j].utime, folder / colour[i].file, folder / depth[j].file});
  const std::size_t unpaired = colour.size() - recording.frames.size();
  if (unpaired > 0)
    recording.notes.push_back(std::to_string(unpaired) + " of " + std::to_string(colour.size()) +
                              " colour images have no depth image within " +
                              std::to_string(max_difference / 1000) + " ms and are left out");
}

// "stamp file stamp file" a line; ICL-NUIM has depth first.
void read_associations(const fs::path& list, const fs::path& folder, Recording& recording) {
  for (const TextRow& row : read_rows(list)) {
    const auto a = parse_stamp(row.words[0]);
    const auto b = row.words.size() == 4 ? parse_stamp(row.words[2]) : std::nullopt;
    if (!a || !b) {
      recording.problems.push_back(
          at_line(list, row.line, "left out, expected: stamp colour-file stamp depth-file"));
      continue;
    }
    if (row.words[1].find("depth") != std::string::npos && row.words[3].find("depth") == std::string::npos)
      recording.frames.push_back({*b, *a, folder / row.words[3], folder / row.words[1]});
    else
      recording.frames.push_back({*a, *b, folder / row.words[1], folder / row.words[3]});
  }
}

// ICL-NUIM counts frames instead of giving seconds: all stamps whole, most steps one.
bool stamps_are_counters(const std::vector<FrameFiles>& frames) {
  std::size_t ones = 0;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (frames[i].utime % 1'000'000 != 0 || frames[i].depth_utime % 1'000'000 != 0) return false;
    if (i > 0 && frames[i].utime - frames[i - 1].utime == 1'000'000) ++ones;
  }
  return frames.size() > 2 && 2 * ones > frames.size();
}

fs::path find_truth(const fs::path& folder) {
  if (fs::exists(folder / "groundtruth.txt")) return folder / "groundtruth.txt";
  std::vector<fs::path> found;  // ICL-NUIM: livingRoom1.gt.freiburg
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".freiburg") found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found.empty() ? fs::path() : found.front();
}

}  // namespace

bool is_tum(const fs::path& folder) {
  return fs::exists(folder / "associations.txt") ||
         (fs::exists(folder / "rgb.txt") && fs::exists(folder / "depth.txt"));
}

Recording read_tum_folder(const fs::path& folder, const Description& description,
                          const CalibrationOf& calibration_of) {
  Recording recording;
  std::vector<StampedFile> colour;
  if (fs::exists(folder / "rgb.txt")) colour = read_list(folder / "rgb.txt", recording);
  if (fs::exists(folder / "associations.txt")) {
    read_associations(folder / "associations.txt", folder, recording);
  } else {
    const std::vector<StampedFile> depth = read_list(folder / "depth.txt", recording);
    associate(colour, depth, calibration_of(recording).depth_offset(),
              std::llround(description.max_stamp_difference * 1e6), folder, recording);
  }

  std::stable_sort(recording.frames.begin(), recording.frames.end(),
                   [](auto& a, auto& b) { return a.utime < b.utime; });

  if (const fs::path truth = find_truth(folder); !truth.empty()) read_stamped_poses(truth, recording);

  if (stamps_are_counters(recording.frames)) {
    recording.notes.push_back("stamps count frames; " + frame_rate_note(description));
    const auto to_time = [&](Utime& utime) {
      utime = std::llround(static_cast<double>(utime) / description.frame_rate) + 1'000'000;
    };
    for (FrameFiles& frame : recording.frames) to_time(frame.utime), to_time(frame.depth_utime);
    for (StampedPose& pose : recording.truth) to_time(pose.utime);
  }
  return recording;
}

}  // namespace lcmslam
