#pragma once
// What waits to be sent to a broker, and what goes next. Nothing here waits for the network: who puts
// something in is back at once, whatever the link does.
//
// Two kinds of messages. Of a measurement (a pose, a picture) only the newest of each sender is held, and
// sent at its channel's rate at most: what is behind the times is replaced, never queued. (Of a channel
// without a rate, orders say, the last few.) What makes the map is kept: each message has a name, replaces
// the one that had that name before, and is held until the broker has it, and after that for the case that
// the broker forgets it.
//
// Small measurements go in the order of the rules and wait for nobody, beside what the link carries
// (LinkWindow) and on a connection of their own: where the link loses a packet of a map, no pose waits until
// it has been sent again. What is large shares the link: the channel that has had the least of it goes next
// (start-time fair queueing, Goyal, Vin and Cheng 1996), so that landmarks that change all the time leave
// room for keyframes. Within a channel the newest group goes first, but what was begun is finished: who puts
// pieces together need not hold many.
//
// What the broker has: each kept message has a number, and mark() is the number up to which the broker
// acknowledged all. The bridge stores the mark on the broker behind what it speaks of. A broker that comes
// back with an old mark (from its disk) or without one gets again what is newer than that, and nothing else.
//
// All functions may be called by any thread.

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <vector>

#include <lcmslam/bridge/channel_rule.hpp>
#include <lcmslam/bridge/link_window.hpp>
#include <lcmslam/bridge/token_bucket.hpp>

namespace lcmslam::bridge {

using Bytes = std::vector<std::uint8_t>;

struct OutboxLimits {
  double delay = 0.15;               ///< s that what is under way may queue on the link
  double bandwidth = 0;              ///< bytes a second, 0: what the link carries
  std::size_t memory = 256'000'000;  ///< bytes of kept messages
  double kept_for = 604'800;         ///< s that the broker keeps them; they go anew after half of it
};

/// What is to be published now.
struct Outgoing {
  std::uint64_t ticket = 0;
  std::string name;                    ///< CHANNEL or CHANNEL/KEY
  std::shared_ptr<const Bytes> bytes;  ///< empty: what the broker keeps under the name goes
  bool kept = false;
  bool beside = false;      ///< on the connection of small measurements
  std::int64_t number = 0;  ///< of a measurement: counts what was sent of its sender on its channel
  double lives = 0;         ///< s after which nobody shall get it any more
};

struct OutboxCounts {
  std::int64_t sent = 0, acknowledged = 0, replaced = 0, evicted = 0, again = 0;
  std::size_t kept = 0, waiting = 0;  ///< kept messages, and those that the broker has not
  std::size_t kept_bytes = 0, window = 0;
  double age = 0;  ///< s, of the oldest measurement when it was acknowledged, since the last call
};

class Outbox {
 public:
  Outbox(const std::vector<ChannelRule>& rules, const OutboxLimits& limits);

  /// The newest measurement of this sender. Channels without a rule are left out.
  void put(const std::string& channel, std::int64_t sender, Bytes bytes, Time now);

  struct Piece {
    std::string name;  ///< begins with its channel
    Bytes bytes;
  };
  /// The same in pieces, so that a large one holds up nothing. They go one after the other.
  void put(const std::string& channel, std::int64_t sender, std::vector<Piece> pieces, Time now);

  /// Kept messages that together replace what the group had before: all pieces of a keyframe's tile, say. An
  /// empty one, behind those with content, clears what a former run may have left under its name.
  /// `version` names what they say, for holds(); 0: nothing does.
  void keep(const std::string& channel, const std::string& group, std::vector<Piece> pieces,
            std::int64_t version = 0);
  /// The whole group is here in this version: to keep the same anew would only send it again.
  bool holds(const std::string& channel, const std::string& group, std::int64_t version) const;
  /// The groups that begin so are no more; the broker is told.
  void forget(const std::string& channel, const std::string& groups);

  /// For what is made only when it can go (changes of a map): the channel's time has come, nothing of it
  /// waits and nothing is under way.
  bool wants(const std::string& channel, Time now) const;

  /// Measurements that were put without a connection never go.
  void connected();
  void disconnected();
  bool is_connected() const;
  /// How often connected() was called: whoever tells changes begins anew when it rises.
  std::int64_t connections() const;
  /// What the broker has kept, as it says itself: the mark of this outbox, 0 for none. Until then nothing
  /// kept is sent.
  void broker_keeps(std::uint64_t mark);
  std::uint64_t mark() const;
  /// True once when the broker must get what is not held here any more: whoever made it shall tell it again.
  bool lacks();

  std::optional<Outgoing> next(Time now);
  /// Nothing kept waits or is under way.
  bool idle() const;
  void acknowledged(std::uint64_t ticket, Time now);

  OutboxCounts counts();

 private:
  struct Measurement {
    std::string name;
    std::shared_ptr<const Bytes> bytes;
    Time put{};
  };
  struct Slot {  // of a sender
    std::deque<Measurement> waiting;
    Time last{}, due{};
    std::int64_t sent = 0;
    bool beside = false;  // all so far were small and at a rate: none passes another on another connection
  };
  struct Kept {
    std::size_t channel = 0;
    std::uint64_t number = 0;
    std::string group;
    std::shared_ptr<const Bytes> bytes;
    bool stored = false;
    Time stored_at{};
  };
  struct Channel {
    ChannelRule rule;
    std::map<std::int64_t, Slot> slots;            // by sender
    std::map<std::uint64_t, std::string> waiting;  // names of kept messages, by number
    std::size_t under_way = 0;                     // messages
    std::string begun;                             // group of which a piece went last
    std::uint64_t served = 0;                      // bytes of the shared link up to which it had its part
  };
  struct UnderWay {
    std::size_t channel = 0, bytes = 0;
    std::string name;          // empty: a measurement
    std::uint64_t number = 0;  // of a kept one
    Time put{}, sent{};
    bool beside = false;
  };

  double period(const Channel& channel) const { return channel.rule.rate > 0 ? 1 / channel.rule.rate : 0; }
  Slot& slot_of(Channel& channel, std::int64_t sender, Time now);
  bool is_cleared(const std::string& name) const;
  void keep_one(std::size_t channel, const std::string& group, const std::string& name, Bytes bytes);
  void renew(Time now);
  void drop(const Kept& kept);
  void forget_measurements();
  void make_room();
  bool affords(std::size_t bytes, Time now);
  Outgoing send_measurement(std::size_t channel, Slot& slot, Time now);
  std::optional<Outgoing> next_beside(Time now);
  static Slot* due_slot(Channel& channel, bool beside, Time now);
  std::uint64_t served(std::size_t channel) const;
  std::uint64_t next_kept(const Channel& channel) const;
  Outgoing send_kept(std::size_t channel, std::uint64_t number, Time now);

  mutable std::mutex mutex_;
  OutboxLimits limits_;
  std::vector<Channel> channels_;
  std::map<std::string, std::size_t> index_;             // of channels
  std::map<std::string, Kept> kept_;                     // by name
  std::map<std::string, std::set<std::string>> groups_;  // names, by channel/group
  std::map<std::string, std::int64_t> versions_;         // of whole groups, by channel/group
  std::set<std::uint64_t> unstored_;                     // numbers that the broker has not
  std::map<std::uint64_t, std::string> stored_;          // names, by number
  std::map<std::uint64_t, UnderWay> under_way_;          // by ticket
  LinkWindow window_;
  std::size_t beside_ = 0;  // small measurements under way
  TokenBucket bucket_;
  std::uint64_t last_ticket_ = 0, last_number_ = 0, evicted_up_to_ = 0;
  std::uint64_t shared_ = 0;  // bytes that a channel which always waits has had
  std::int64_t connections_ = 0;
  bool connected_ = false, decided_ = false, lacks_ = false;
  OutboxCounts counts_;
};

}  // namespace lcmslam::bridge
