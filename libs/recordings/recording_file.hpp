#pragma once
// A recording of messages on topics as others write it: bags of ROS 1 and MCAP files.
//
//   const auto file = open_recording("kitchen.bag");
//   file->scan([&](const RecordedMessage& message, ByteView bytes) { ... });   // all, in the file's order
//   const ByteView again = file->read(message);                                // one of them later

#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <lcmslam/recordings/byte_reader.hpp>

namespace lcmslam {

struct RecordedTopic {
  std::string name;      ///< "/camera/image_raw"
  std::string type;      ///< as the file has it: "sensor_msgs/Image", "sensor_msgs/msg/Image"
  std::string encoding;  ///< of its messages: "ros1", "cdr", or another
};

/// Where a message lies.
struct RecordedMessage {
  std::size_t topic = 0;      ///< in topics()
  std::int64_t log_time = 0;  ///< ns, when it was recorded
  std::uint64_t chunk = 0;    ///< place of its chunk in the file; 0: in none
  std::uint64_t offset = 0;   ///< in the unpacked chunk, or in the file
  std::uint64_t size = 0;
};

/// What is damaged is left out and listed; what is whole is given.
class RecordingFile {
 public:
  using Visitor = std::function<void(const RecordedMessage&, ByteView)>;

  virtual ~RecordingFile() = default;

  /// Every message that is whole, in the file's order.
  virtual void scan(const Visitor& visit) = 0;

  /// A message that scan() has given; valid until the next call. Reads its chunk where that is none of the
  /// last few. Throws RecordingError.
  ByteView read(const RecordedMessage& message);

  /// Found by scan() so far.
  const std::vector<RecordedTopic>& topics() const { return topics_; }
  /// What is wrong with the file, each beginning with the byte at which it is; after so many as
  /// most_damages only counted.
  const std::vector<std::string>& damages() const { return damages_; }
  std::size_t damage_count() const { return damage_count_; }

  static constexpr std::size_t most_damages = 1000;

 protected:
  RecordingFile(ByteView bytes, std::uint64_t largest_chunk) : bytes_(bytes), largest_chunk_(largest_chunk) {}

  using Bytes = std::vector<std::uint8_t>;
  /// The unpacked chunk whose record begins at `place`. Throws RecordingError.
  virtual Bytes unpack_chunk(std::uint64_t place) const = 0;
  /// The same; the last few are kept.
  const Bytes& chunk(std::uint64_t place);

  std::size_t add_topic(const RecordedTopic& topic);
  void damage(std::uint64_t at, const std::string& reason);
  /// What goes wrong with the record at that place is damage.
  template <class Work>
  void guarded(std::uint64_t at, const Work& work) {
    try {
      work();
    } catch (const RecordingError& error) {
      damage(at, error.what());
    }
  }
  /// Refuses a chunk that says it is larger than any.
  void check_chunk_size(std::uint64_t size) const;

  ByteView bytes_;

 private:
  struct Kept {
    std::uint64_t place = 0;
    Bytes bytes;
  };

  friend std::unique_ptr<RecordingFile> open_recording(const std::string& file);

  std::shared_ptr<const void> owner_;  // of bytes_, where this is to keep it
  std::uint64_t largest_chunk_;
  std::deque<Kept> kept_;  // the newest last
  std::vector<RecordedTopic> topics_;
  std::vector<std::string> damages_;
  std::size_t damage_count_ = 0;
};

/// Chunks that say to be larger are refused: writers make them of about a MiB, or of one image.
constexpr std::uint64_t usual_largest_chunk = 1ULL << 30;

/// From memory, which must stay. Throws RecordingError when the bytes do not begin as such a file does.
std::unique_ptr<RecordingFile> open_mcap(ByteView bytes, std::uint64_t largest_chunk = usual_largest_chunk);
std::unique_ptr<RecordingFile> open_bag(ByteView bytes, std::uint64_t largest_chunk = usual_largest_chunk);

/// An MCAP file or a bag, as its first bytes say. Throws std::runtime_error naming the file.
std::unique_ptr<RecordingFile> open_recording(const std::string& file);

}  // namespace lcmslam
