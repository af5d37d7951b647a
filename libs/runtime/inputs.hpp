#pragma once
// What a node receives: one handler a channel, each message checked before the handler sees it, and
// everything that goes wrong counted.

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>
#include <lcmslam/messages/any_message.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/messages/origin.hpp>
#include <lcmslam/runtime/sender_counts.hpp>
#include <lcmslam/runtime/stamp_judge.hpp>

namespace lcmslam {

/// What remains of a message that was thrown away unhandled.
struct MessageIdentity {
  Origin origin;
  Utime utime = 0;
};

class Input {
 public:
  Input(std::string channel, std::size_t capacity) : channel_(std::move(channel)), capacity_(capacity) {}
  virtual ~Input() = default;

  const std::string& channel() const { return channel_; }
  /// Messages that wait at most; when one more comes, the oldest goes (1: the latest wins).
  std::size_t capacity() const { return capacity_; }

  /// Checks, counts and handles one message. Never throws for a bad message: it is counted.
  /// `dropped` messages of this channel were thrown away since the last call and nobody knows their numbers.
  void deliver(const std::uint8_t* data, std::size_t size, std::int64_t dropped = 0);
  /// Follows the number of a message that was thrown away: it is not lost.
  void skip(const MessageIdentity& message);
  /// Nothing when the bytes are no message of this input's type. May be called by any thread.
  virtual std::optional<MessageIdentity> identify(const std::uint8_t* data, std::size_t size) const = 0;

  /// Latency is measured from the arrival of these messages.
  bool primary = false;
  /// Called with the utime of each message that decoded, before its handler.
  std::function<void(Utime)> on_seen;
  /// Says whether the handler may see a message that decoded; empty: every one.
  std::function<bool(std::int64_t sender, Utime utime)> admits;

  std::int64_t decode_errors = 0;
  std::string last_error;
  SenderCounts senders;

 protected:
  /// Decodes, calls `seen`, then the handler. Throws DecodeError.
  virtual void decode_and_handle(const std::uint8_t* data, std::size_t size) = 0;
  void seen(const Origin& origin, Utime utime, std::size_t size);

 private:
  std::string channel_;
  std::size_t capacity_;
  std::int64_t known_missing_ = 0;    // since the last good message
  InputCount* counted_in_ = nullptr;  // the message under way was followed by its number
};

class Inputs {
 public:
  /// Handler for messages of type M on a channel; it may throw DecodeError for wrong values.
  template <class M>
  Input& subscribe(const std::string& channel, std::size_t capacity, std::function<void(const M&)> handler) {
    inputs_.push_back(std::make_unique<TypedInput<M>>(channel, capacity, std::move(handler)));
    return *inputs_.back();
  }

  /// For who hands messages on: whatever is a message of ours, and what can be said of it.
  using BytesHandler = std::function<void(const std::vector<std::uint8_t>&, const AnyMessage&)>;
  Input& subscribe_bytes(const std::string& channel, std::size_t capacity, BytesHandler handler);

  /// The same for what is measured at its utime: the handler sees one publisher's messages, in order of time
  /// within a session (see StampJudge). All such channels of a process are judged together. Throws
  /// std::logic_error for a channel that is measured already: a second handler would see none of it.
  template <class M>
  Input& subscribe_measured(const std::string& channel, std::size_t capacity,
                            std::function<void(const M&)> handler) {
    for (const auto& other : inputs_)
      if (other->channel() == channel && other->admits)
        throw std::logic_error(channel + " is measured by another handler already");
    Input& input = subscribe<M>(channel, capacity, std::move(handler));
    input.admits = [this, channel](std::int64_t sender, Utime utime) {
      return admit(channel, sender, utime);
    };
    return input;
  }
  /// Called before the first message of a new session: time began anew.
  std::function<void()> on_new_session;
  const StampJudge& stamps() const { return stamps_; }
  /// Messages that no handler saw: they do not decode, or their stamps are not believed.
  std::int64_t refused() const;

  const std::vector<std::unique_ptr<Input>>& all() const { return inputs_; }

  /// Delivers straight to the channel's handlers (batch, tests); false when nobody listens.
  bool deliver(const std::string& channel, const std::uint8_t* data, std::size_t size);

 private:
  template <class M>
  class TypedInput : public Input {
   public:
    TypedInput(const std::string& channel, std::size_t capacity, std::function<void(const M&)> handler)
        : Input(channel, capacity), handler_(std::move(handler)) {}

    std::optional<MessageIdentity> identify(const std::uint8_t* data, std::size_t size) const override {
      try {
        const M message = decode_message<M>(data, size);
        return MessageIdentity{origin(message), message.utime};
      } catch (const DecodeError&) {
        return std::nullopt;
      }
    }

   private:
    void decode_and_handle(const std::uint8_t* data, std::size_t size) override {
      const M message = decode_message<M>(data, size);
      seen(origin(message), message.utime, size);
      if (!admits || admits(origin(message).sender, message.utime)) handler_(message);
    }
    std::function<void(const M&)> handler_;
  };

  class BytesInput : public Input {
   public:
    BytesInput(const std::string& channel, std::size_t capacity, BytesHandler handler)
        : Input(channel, capacity), handler_(std::move(handler)) {}
    std::optional<MessageIdentity> identify(const std::uint8_t* data, std::size_t size) const override;

   private:
    void decode_and_handle(const std::uint8_t* data, std::size_t size) override;
    BytesHandler handler_;
  };

  bool admit(const std::string& channel, std::int64_t sender, Utime utime);

  std::vector<std::unique_ptr<Input>> inputs_;
  StampJudge stamps_;
};

}  // namespace lcmslam
