#include <lcmslam/recordings/recording_file.hpp>

#include <algorithm>

#include <lcmslam/recordings/mapped_file.hpp>

namespace lcmslam {
namespace {

constexpr std::size_t most_kept = 4;  // colour and depth images lie in neighbouring chunks

}  // namespace

ByteView RecordingFile::read(const RecordedMessage& message) {
  ByteReader bytes(bytes_);
  if (message.chunk != 0) {
    const Bytes& unpacked = chunk(message.chunk);
    bytes = ByteReader({unpacked.data(), unpacked.size()});
  }
  bytes.take(message.offset);
  return bytes.take(message.size);
}

const RecordingFile::Bytes& RecordingFile::chunk(std::uint64_t place) {
  const auto known =
      std::find_if(kept_.begin(), kept_.end(), [&](const Kept& kept) { return kept.place == place; });
  if (known != kept_.end()) return known->bytes;
  Kept kept{place, unpack_chunk(place)};
  if (kept_.size() == most_kept) kept_.pop_front();
  kept_.push_back(std::move(kept));
  return kept_.back().bytes;
}

std::size_t RecordingFile::add_topic(const RecordedTopic& topic) {
  const auto known = std::find_if(topics_.begin(), topics_.end(), [&](const RecordedTopic& other) {
    return other.name == topic.name && other.type == topic.type && other.encoding == topic.encoding;
  });
  if (known != topics_.end()) return static_cast<std::size_t>(known - topics_.begin());
  topics_.push_back(topic);
  return topics_.size() - 1;
}

void RecordingFile::damage(std::uint64_t at, const std::string& reason) {
  ++damage_count_;
  if (damages_.size() < most_damages) damages_.push_back("byte " + std::to_string(at) + ": " + reason);
}

void RecordingFile::check_chunk_size(std::uint64_t size) const {
  if (size > largest_chunk_)
    throw RecordingError("a chunk of " + std::to_string(size) + " bytes: may have " +
                         std::to_string(largest_chunk_));
}

std::unique_ptr<RecordingFile> open_recording(const std::string& file) {
  const auto mapped = std::make_shared<const MappedFile>(file);
  const std::string_view text = mapped->bytes().text();
  std::unique_ptr<RecordingFile> recording;
  try {
    recording = text.substr(0, 7) == "#ROSBAG" ? open_bag(mapped->bytes()) : open_mcap(mapped->bytes());
  } catch (const RecordingError& error) {
    throw std::runtime_error(file + ": " + error.what());
  }
  recording->owner_ = mapped;
  return recording;
}

}  // namespace lcmslam
