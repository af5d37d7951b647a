#include <lcmslam/ros/ros_recording.hpp>

#include <algorithm>
#include <cmath>
#include <set>

#include <lcmslam/datasets/dataset.hpp>
#include <lcmslam/datasets/stamp_pairs.hpp>
#include <lcmslam/imaging/io/calibration_file.hpp>
#include <lcmslam/ros/head_calibration.hpp>

namespace lcmslam::ros {
namespace {

namespace fs = std::filesystem;

/// A bag that its recorder did not close is called .bag.active, and is read as it is.
bool is_ros_file(const fs::path& path) {
  if (path.extension() == ".active") return path.stem().extension() == ".bag";
  return path.extension() == ".bag" || path.extension() == ".mcap";
}

Utime microseconds(double seconds) {
  return std::llround(seconds * 1e6);
}

bool is_clock_offset(const std::string& topic) {
  return topic == clock_offset_beside(topic);
}

double read_clock_offset(ByteView message, const std::string& encoding) {
  const double offset = read_number(message, encoding);
  if (!(std::abs(offset) <= 10)) throw RecordingError("must be -10 to 10 s");
  return offset;
}

void check_size(const EncodedImage& image, const CameraModel& camera) {
  if (image.width == camera.width && image.height == camera.height) return;
  throw CodecError("is " + std::to_string(image.width) + "x" + std::to_string(image.height) +
                   ", by the calibration it must be " + std::to_string(camera.width) + "x" +
                   std::to_string(camera.height));
}

}  // namespace

std::vector<fs::path> ros_files(const fs::path& path) {
  std::vector<fs::path> files;
  if (fs::is_directory(path)) {
    for (const auto& entry : fs::directory_iterator(path))
      if (is_ros_file(entry.path()) && entry.is_regular_file()) files.push_back(entry.path());
    std::sort(files.begin(), files.end());
  } else if (is_ros_file(path)) {
    files.push_back(path);
  }
  return files;
}

RosRecording::RosRecording(const std::vector<fs::path>& files, const RosOptions& options)
    : jpeg_quality_(options.jpeg_quality) {
  for (const fs::path& file : files) {
    files_.push_back(open_recording(file.string()));
    names_.push_back(file.string());
    look_through(files_.size() - 1);
  }
  list_unusable_transforms();
  for (Topic& topic : topics_) sort_entries(topic);
  try {
    choose(options);
  } catch (const DatasetError& error) {
    // What is missing may be what could not be read, and nobody can ask for problems() now.
    const std::vector<std::string> all = problems();
    std::string text = names_.empty() ? "no file" : names_.front();
    if (names_.size() > 1) text += " and " + std::to_string(names_.size() - 1) + " more";
    text += ": " + std::string(error.what());
    if (!all.empty())
      text += "; of " + std::to_string(all.size()) + (all.size() == 1 ? " problem" : " problems") +
              " the first: " + all.front();
    throw DatasetError(text);
  }
  if (unstamped_ > 0)
    notes_.push_back(std::to_string(unstamped_) +
                     " messages have no stamp: the times of their recording are taken");
  list_events(options.max_stamp_difference);
}

RosRecording::~RosRecording() = default;

void RosRecording::choose(const RosOptions& options) {
  std::vector<TopicFacts> facts;
  for (const Topic& topic : topics_) facts.push_back(topic.facts);
  TopicChoice choice = choose_topics(facts, options.topics);
  notes_ = std::move(choice.notes);
  colour_ = find(choice.topics.colour);
  depth_ = find(choice.topics.depth);
  odometry_ = find(choice.topics.odometry);
  truth_ = find(choice.topics.truth);
  const std::string robot_frame = settle_calibration(options, choice.topics);
  if (truth_ == nullptr) return;
  truth_body_ = find_truth_body(truth_->facts.frame, robot_frame, colour_->facts.frame, transforms_);
  if (!truth_body_.note.empty()) notes_.push_back(truth_->facts.name + ": " + truth_body_.note);
}

RosRecording::Topic* RosRecording::find(const std::string& name) {
  const auto found =
      std::find_if(topics_.begin(), topics_.end(), [&](auto& t) { return t.facts.name == name; });
  return found == topics_.end() || name.empty() ? nullptr : &*found;
}

RosRecording::Topic& RosRecording::topic(const std::string& name, const std::string& type,
                                         const std::string& encoding) {
  if (Topic* known = find(name)) {
    if (known->facts.type != type || known->encoding != encoding)
      throw RecordingError("is of type " + type + " here, of " + known->facts.type + " before");
    return *known;
  }
  Topic made;
  made.facts.name = name;
  made.facts.type = type;
  made.encoding = encoding;
  topics_.push_back(std::move(made));
  return topics_.back();
}

void RosRecording::look_through(std::size_t file) {
  files_[file]->scan([&](const RecordedMessage& message, ByteView bytes) {
    try {
      look_at(message, bytes, file);
    } catch (const std::runtime_error& error) {  // RecordingError, CodecError
      problems_.push_back(files_[file]->topics()[message.topic].name +
                          ": a message is left out: " + error.what());
    }
  });
}

void RosRecording::look_at(const RecordedMessage& message, ByteView bytes, std::size_t file) {
  const RecordedTopic& recorded = files_[file]->topics()[message.topic];
  const std::string type = short_type(recorded.type);
  Topic& of = topic(recorded.name, type, recorded.encoding);
  if (is_image(type)) {
    const Image image = read_image(bytes, type, recorded.encoding);
    if (of.entries.empty()) {
      of.facts.kind = kind_of(image);
      of.facts.encoding = image.encoding;
      of.facts.frame = image.header.frame;
      if (of.facts.kind != ImageKind::unknown) of.facts.size = size_of(image);
    }
    // As the camera stamped it: what a calibration says of its clock is said of that.
    RosHeader header = image.header;
    if (header.utime != 0) header.utime -= microseconds(clock_offset_of(recorded.name));
    add_entry(of, header, message, file);
  } else if (is_number(type)) {
    if (is_clock_offset(recorded.name))
      clock_offsets_[recorded.name] = read_clock_offset(bytes, recorded.encoding);
  } else if (is_pose(type)) {
    const Pose pose = read_pose(bytes, type, recorded.encoding);
    if (of.entries.empty()) of.facts.frame = pose.child_frame;
    add_entry(of, pose.header, message, file);
  } else if (is_camera_info(type)) {
    if (!of.info) {
      of.info = read_camera_info(bytes, recorded.encoding);
      of.facts.frame = of.info->header.frame;
    }
  } else if (is_transforms(type)) {
    const Transforms transforms = read_transforms(bytes, recorded.encoding);
    for (const Transform& transform : transforms.usable) transforms_.add(transform);
    for (const std::string& frames : transforms.unusable)
      ++unusable_transforms_[recorded.name + ": the transform " + frames];
  }
  ++of.facts.messages;
}

void RosRecording::add_entry(Topic& topic, const RosHeader& header, const RecordedMessage& message,
                             std::size_t file) {
  if (header.utime == 0) ++unstamped_;
  topic.entries.push_back({header.utime != 0 ? header.utime : message.log_time / 1000, file, message});
}

/// Seconds that stand in the stamps of these images, by what was read so far.
double RosRecording::clock_offset_of(const std::string& images) const {
  const auto known = clock_offsets_.find(clock_offset_beside(images));
  return known == clock_offsets_.end() ? 0 : known->second;
}

/// One line for each: a robot may repeat it a hundred times a second.
void RosRecording::list_unusable_transforms() {
  for (const auto& [transform, times] : unusable_transforms_)
    problems_.push_back(transform + " is left out" +
                        (times == 1 ? "" : " " + std::to_string(times) + " times") +
                        ": its numbers are not finite or its quaternion is no unit one");
}

void RosRecording::sort_entries(Topic& topic) {
  auto& entries = topic.entries;
  std::stable_sort(entries.begin(), entries.end(), [](auto& a, auto& b) { return a.utime < b.utime; });
  const auto end =
      std::unique(entries.begin(), entries.end(), [](auto& a, auto& b) { return a.utime == b.utime; });
  if (end != entries.end())
    problems_.push_back(topic.facts.name + ": " + std::to_string(entries.end() - end) +
                        " messages have the stamp of another and are left out");
  entries.erase(end, entries.end());
}

std::string RosRecording::settle_calibration(const RosOptions& options, const Topics& chosen) {
  const std::string odometry_frame = odometry_ == nullptr ? "" : odometry_->facts.frame;
  std::string robot_frame;
  if (!options.calibration.empty()) {
    calibration_ = load_calibration(options.calibration);
    notes_.push_back("calibration of " + options.calibration.string());
    if (calibration_.has_mount) return odometry_frame;
  } else {
    const auto camera = [&](const Topic& images, const std::string& info) {
      const Topic* of_info = find(info);
      return RecordedCamera{images.facts.name, images.facts.frame, images.facts.size,
                            of_info == nullptr ? std::nullopt : of_info->info, info};
    };
    std::vector<std::string> robot_frames;
    if (!odometry_frame.empty()) robot_frames.push_back(odometry_frame);
    for (const char* usual : {"base_footprint", "base_link"})
      if (odometry_frame != usual) robot_frames.emplace_back(usual);
    HeadCalibration head = make_calibration(camera(*colour_, chosen.colour_info),
                                            camera(*depth_, chosen.depth_info), transforms_, robot_frames);
    calibration_ = head.calibration;
    calibration_.depth_clock_offset = clock_offset_of(depth_->facts.name);
    if (calibration_.depth_clock_offset != 0)
      notes_.push_back("depth's clock: by " + clock_offset_beside(depth_->facts.name));
    notes_.insert(notes_.end(), head.notes.begin(), head.notes.end());
    robot_frame = head.robot_frame;
    // An empty name is of no frame: without a mount both are empty.
    if (!odometry_frame.empty() && robot_frame == odometry_frame) return robot_frame;
  }
  if (odometry_ == nullptr) return robot_frame;
  notes_.push_back("odometry is left out: it is of " +
                   (odometry_frame.empty() ? "no frame" : odometry_frame) +
                   ", and where the camera sits on that nobody says; --calibration FILE gives a mount");
  odometry_ = nullptr;
  return robot_frame;
}

void RosRecording::pair_images(double max_stamp_difference) {
  const auto stamps = [](const Topic& topic) {
    std::vector<Utime> utimes;
    for (const Entry& entry : topic.entries) utimes.push_back(entry.utime);
    return utimes;
  };
  const auto pairs = pair_by_stamps(stamps(*colour_), stamps(*depth_), calibration_.depth_offset(),
                                    microseconds(max_stamp_difference));
  for (const auto& [colour, depth] : pairs)
    events_.push_back({colour_->entries[colour].utime, EventKind::frame, colour, depth});
  frames_ = pairs.size();
  const auto note = [&](const Topic& topic, const char* other) {
    if (topic.entries.size() > frames_)
      notes_.push_back(std::to_string(topic.entries.size() - frames_) + " of " +
                       std::to_string(topic.entries.size()) + " images of " + topic.facts.name + " have no " +
                       other + " image within " + std::to_string(std::lround(max_stamp_difference * 1000)) +
                       " ms and are left out");
  };
  note(*colour_, "depth");
  note(*depth_, "colour");
}

void RosRecording::list_events(double max_stamp_difference) {
  pair_images(max_stamp_difference);
  const auto add = [&](const Topic* topic, EventKind kind) {
    for (std::size_t i = 0; topic != nullptr && i < topic->entries.size(); ++i)
      events_.push_back({topic->entries[i].utime, kind, i, 0});
  };
  add(odometry_, EventKind::odometry);
  add(truth_, EventKind::truth);
  std::stable_sort(events_.begin(), events_.end(), [](const Event& a, const Event& b) {
    return std::make_pair(a.utime, a.kind) < std::make_pair(b.utime, b.kind);
  });
}

Pose RosRecording::read_pose_of(const Topic& topic, std::size_t entry) {
  const Entry& at = topic.entries[entry];
  return read_pose(files_[at.file]->read(at.message), topic.facts.type, topic.encoding);
}

EncodedImage RosRecording::read_image_of(const Topic& topic, std::size_t entry, bool depth) {
  const Entry& at = topic.entries[entry];
  const Image image = read_image(files_[at.file]->read(at.message), topic.facts.type, topic.encoding);
  EncodedImage encoded = depth ? to_depth(image, at.utime) : to_colour(image, at.utime, jpeg_quality_);
  check_size(encoded, depth ? calibration_.depth : calibration_.colour);
  return encoded;
}

EncodedFrame RosRecording::read_frame(const Event& event) {
  EncodedFrame frame;
  frame.utime = event.utime;
  frame.sensor = calibration_.sensor;
  frame.colour = read_image_of(*colour_, event.first, false);
  frame.depth = read_image_of(*depth_, event.second, true);
  frame.seq = seq_++;
  return frame;
}

std::optional<RosEvent> RosRecording::next() {
  while (next_ < events_.size()) {
    const Event& event = events_[next_++];
    const Topic& of = event.kind == EventKind::frame      ? *colour_
                      : event.kind == EventKind::odometry ? *odometry_
                                                          : *truth_;
    try {
      if (event.kind == EventKind::frame) return read_frame(event);
      const Pose pose = read_pose_of(of, event.first);
      if (event.kind == EventKind::truth)
        return TruthEvent{event.utime, truth_body_.body, pose.pose * truth_body_.T_told_body};
      return OdometryEvent{event.utime, pose.pose, {event.utime, pose.linear, pose.angular}};
    } catch (const std::runtime_error& error) {  // RecordingError, CodecError
      problems_.push_back(of.facts.name + ": the one of " + std::to_string(event.utime) +
                          " us is left out: " + error.what());
    }
  }
  return std::nullopt;
}

std::vector<std::string> RosRecording::problems() const {
  std::vector<std::string> all;
  for (std::size_t i = 0; i < files_.size(); ++i) {
    for (const std::string& damage : files_[i]->damages()) all.push_back(names_[i] + ": " + damage);
    if (const std::size_t more = files_[i]->damage_count() - files_[i]->damages().size(); more > 0)
      all.push_back(names_[i] + ": " + std::to_string(more) + " damages more");
  }
  all.insert(all.end(), problems_.begin(), problems_.end());
  return all;
}

}  // namespace lcmslam::ros
