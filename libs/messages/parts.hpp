#pragma once
// Big messages in pieces (<CHANNEL>_PART), for machines whose receive buffers are too small for them,
// and back.

#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/part_t.hpp>

namespace lcmslam {

/// The channel that carries the pieces of a channel, and whether a channel is one of those.
std::string part_channel(const std::string& channel);
bool is_part_channel(const std::string& channel);

/// `message` counts the messages that went out in pieces on this channel; seq and sender are left to the
/// publisher. Throws std::invalid_argument when part_size is 0.
std::vector<part_t> split_message(const std::string& channel, const std::vector<std::uint8_t>& bytes,
                                  Utime utime, std::int64_t message, std::size_t part_size);

/// Puts pieces together, in whatever order and from however many senders they come.
class PartAssembler {
 public:
  /// Takes 32 MiB of pieces that wait, so also of a message.
  PartAssembler() = default;
  explicit PartAssembler(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  struct Whole {
    std::string channel;
    Utime utime = 0;
    std::vector<std::uint8_t> bytes;
  };

  /// The whole message when this was its last missing piece. Pieces that come twice are left out. Throws
  /// DecodeError for a piece that contradicts itself or the others.
  std::optional<Whole> add(const part_t& part);

  /// Messages that were given up because pieces of them never came.
  std::int64_t incomplete() const { return incomplete_; }

  /// Of pieces that wait, with what it takes to keep them; add() leaves no more than may wait.
  std::size_t waiting_bytes() const;
  /// Gives up what waits longest; it has to be something.
  void give_up_oldest();

 private:
  struct Key {
    std::int64_t sender;
    std::string channel;
    std::int64_t message;
    bool operator==(const Key& other) const {
      return sender == other.sender && message == other.message && channel == other.channel;
    }
  };
  struct Waiting {
    Key key;
    std::int32_t n_parts, total_size;
    std::size_t received;  // bytes
    std::map<std::int32_t, std::vector<std::uint8_t>> parts;
  };

  std::size_t most_bytes_ = 32 << 20;
  std::deque<Waiting> waiting_;  // oldest first
  std::int64_t incomplete_ = 0;
};

}  // namespace lcmslam
