// Folders of numbered files: 7-Scenes, and whatever a description's patterns say.

#include <algorithm>
#include <cmath>
#include <sstream>

#include <lcmslam/datasets/numbered_files.hpp>
#include <lcmslam/datasets/pose_files.hpp>
#include <lcmslam/datasets/readers.hpp>
#include <lcmslam/datasets/text_rows.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

constexpr Utime first_stamp = 1'000'000;  // stamps of recordings without any begin at 1 s: 0 means unset

struct ShotTime {
  Utime colour, depth;
};

// Frames for which both files are there; a missing partner is reported. Numbers keep their time where a
// frame was lost. Returns the numbers of recording.frames from `begin` on.
template <class TimeOf>
std::vector<long> add_frames(const NumberedFiles& colour, const NumberedFiles& depth, const TimeOf& time_of,
                             Recording& recording) {
  std::vector<long> numbers = colour.numbers();
  numbers.insert(numbers.end(), depth.numbers().begin(), depth.numbers().end());
  std::sort(numbers.begin(), numbers.end());
  numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
  std::vector<long> complete;
  for (long number : numbers) {
    if (!colour.has(number)) recording.problems.push_back(colour.path(number).string() + ": is missing");
    if (!depth.has(number)) recording.problems.push_back(depth.path(number).string() + ": is missing");
    if (!colour.has(number) || !depth.has(number)) continue;
    const ShotTime time = time_of(number - numbers.front());
    recording.frames.push_back({time.colour, time.depth, colour.path(number), depth.path(number)});
    complete.push_back(number);
  }
  return complete;
}

Utime frame_time(const Description& description, long count) {
  return std::llround(static_cast<double>(count) * 1e6 / description.frame_rate);
}

/// Of both images, or colour's and then depth's.
std::vector<ShotTime> read_stamps(const fs::path& file) {
  std::vector<ShotTime> stamps;
  for (const TextRow& row : read_rows(file)) {
    const auto stamp_of = [&](const std::string& word) {
      const auto stamp = parse_stamp(word);
      if (!stamp) throw DatasetError(at_line(file, row.line, "'" + word + "', expected seconds"));
      return *stamp;
    };
    const ShotTime time{stamp_of(row.words[0]), stamp_of(row.words[row.words.size() > 1 ? 1 : 0])};
    if (!stamps.empty() && time.colour <= stamps.back().colour)
      throw DatasetError(at_line(file, row.line, "stamps must grow from frame to frame"));
    stamps.push_back(time);
  }
  return stamps;
}

std::string colour_pattern(const fs::path& sequence) {
  const std::string jpeg = "frame-%06d.color.jpg";
  return NumberedFiles(sequence, jpeg).numbers().empty() ? "frame-%06d.color.png" : jpeg;
}

bool is_sequence(const fs::path& folder) {
  return !NumberedFiles(folder, colour_pattern(folder)).numbers().empty();
}

// The folder itself, or the seq-NN in it.
std::vector<fs::path> sequences(const fs::path& folder) {
  if (is_sequence(folder)) return {folder};
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_directory() && entry.path().filename().string().rfind("seq-", 0) == 0 &&
        is_sequence(entry.path()))
      found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

}  // namespace

std::string frame_rate_note(const Description& description) {
  std::ostringstream note;
  note << "no stamps: " << description.frame_rate << " Hz assumed";
  return note.str();
}

bool is_seven_scenes(const fs::path& folder) {
  return !sequences(folder).empty();
}

Recording read_seven_scenes(const fs::path& folder, const Description& description) {
  Recording recording;
  recording.notes.push_back(frame_rate_note(description));
  Utime start = first_stamp;
  for (const fs::path& sequence : sequences(folder)) {
    if (sequence != folder)
      recording.notes.push_back(sequence.filename().string() + " begins at frame " +
                                std::to_string(recording.frames.size()) +
                                (start == first_stamp ? "" : ", 1 s after the one before: the camera jumps"));
    const std::size_t begin = recording.frames.size();
    const std::vector<long> numbers = add_frames(
        NumberedFiles(sequence, colour_pattern(sequence)), NumberedFiles(sequence, "frame-%06d.depth.png"),
        [&](long count) {
          const Utime utime = start + frame_time(description, count);
          return ShotTime{utime, utime};
        },
        recording);
    const NumberedFiles poses(sequence, "frame-%06d.pose.txt");
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (poses.has(numbers[i]))
        read_pose_file(poses.path(numbers[i]), recording.frames[begin + i].utime, recording);
      else if (!poses.numbers().empty())
        recording.problems.push_back(poses.path(numbers[i]).string() + ": is missing");
    }
    if (!numbers.empty()) start = recording.frames.back().utime + 1'000'000;
  }
  return recording;
}

Recording read_numbered_files(const fs::path& folder, const Description& description) {
  Recording recording;
  std::vector<ShotTime> stamps;
  if (description.stamps.empty())
    recording.notes.push_back(frame_rate_note(description));
  else
    stamps = read_stamps(folder / description.stamps);
  const auto has_time = [&](long count) {
    return count >= 0 && (description.stamps.empty() || count < static_cast<long>(stamps.size()));
  };
  const auto time_of = [&](long count) {
    if (!has_time(count))
      throw DatasetError((folder / description.stamps).string() + ": has " + std::to_string(stamps.size()) +
                         " stamps, but frame " + std::to_string(count + 1) + " is there");
    const Utime counted = first_stamp + frame_time(description, count);
    return description.stamps.empty() ? ShotTime{counted, counted} : stamps[static_cast<std::size_t>(count)];
  };
  const NumberedFiles colour(folder, description.colour);
  const NumberedFiles depth(folder, description.depth);
  add_frames(colour, depth, time_of, recording);
  if (description.poses.empty()) return recording;
  const fs::path poses = folder / description.poses;
  if (description.pose_format == "tum")
    read_stamped_poses(poses, recording);
  else
    read_counted_poses(
        poses, description.pose_format,
        [&](long count) {
          return has_time(count) ? std::optional<Utime>(time_of(count).colour) : std::nullopt;
        },
        recording);
  return recording;
}

}  // namespace lcmslam
