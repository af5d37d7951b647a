#pragma once
// Chosen channels to a broker and from it. The broker's connection is a thread of its own, which takes from
// the outbox and fills the inbox; nothing here waits for it. It waits where the inbox is full, as the bus
// takes less than most links bring.

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>

#include <lcmslam/bridge/broker.hpp>
#include <lcmslam/bridge/outbox.hpp>
#include <lcmslam/bridge/token_bucket.hpp>
#include <lcmslam/command_t.hpp>
#include <lcmslam/images_t.hpp>
#include <lcmslam/keyframe_t.hpp>
#include <lcmslam/runtime/node.hpp>
#include "procs/bridge/bridge_settings.hpp"
#include "procs/bridge/incoming.hpp"
#include "procs/bridge/map_tellers.hpp"

namespace lcmslam {

/// What the connection needs of the node.
struct BridgeEnds {
  bridge::Broker broker;
  bridge::Topics topics;
  std::vector<std::string> receive;  ///< channels
  bridge::Outbox& outbox;
  /// What goes now, see Outbox.
  std::function<std::optional<bridge::Outgoing>(bridge::Time)> next;
  /// From any thread, and quick where the bus takes what came before: what came on a topic of a channel;
  /// `kept`: from the broker's memory.
  std::function<void(const std::string& channel, const std::uint8_t* data, std::size_t size, bool kept)> take;
  /// How often the keyframes that the broker keeps were wanted again.
  std::function<std::int64_t()> recalls;
};
using MakeLink = std::function<std::unique_ptr<bridge::BrokerLink>(const BridgeEnds&)>;

class BridgeNode : public Node {
 public:
  using Settings = BridgeSettings;
  static Settings read(const ConfigNode& config);

  BridgeNode(const ConfigNode& config, Publisher& publisher, const MakeLink& make_link);
  BridgeNode(const Settings& settings, Publisher& publisher, const MakeLink& make_link);
  ~BridgeNode() override;

  void connect(Inputs& inputs) override;
  std::optional<Duration> work() override;
  void finish() override;
  NodeReport report() const override;

 private:
  using Clock = std::chrono::steady_clock;

  void subscribe(Inputs& inputs, const bridge::ChannelRule& rule);
  void on_keyframe(const keyframe_t& message);
  void on_camera(const images_t& message);
  void on_order(const command_t& message);
  std::optional<bridge::Outgoing> next(bridge::Time now);
  void keep(const std::string& channel, const std::string& key, const std::vector<std::uint8_t>& bytes,
            Utime utime, std::int64_t version);
  void keep_snapshot(const std::string& channel, const std::string& key,
                     const std::vector<std::uint8_t>& bytes, Utime utime);
  std::vector<bridge::Outbox::Piece> in_pieces(const std::string& channel, const std::string& key,
                                               const std::vector<std::uint8_t>& bytes, Utime utime);
  void tell_maps();
  void take_incoming(const std::string& channel, const std::uint8_t* data, std::size_t size, bool kept);
  void take_what_waited(Clock::time_point now);
  void into_inbox(Incoming::Message message);
  std::deque<Incoming::Message> what_may_go();
  void hand_on();
  void let_the_link_go();
  void ask_for_what_lacks();

  /// When a map that is told in changes is told whole again.
  struct Snapshots {
    std::int64_t connection = -1;
    Clock::time_point next{};
  };
  template <class Teller>
  void tell(const std::string& channel, Teller& teller, Snapshots& snapshots);

  Settings settings_;
  Publisher& publisher_;
  std::vector<bridge::ChannelRule> rules_;
  mutable bridge::Outbox outbox_;
  std::set<std::string> thinned_;  // channels of which messages are left out
  LandmarkTeller landmarks_;
  GraphRelay graph_;
  Snapshots landmark_snapshots_, graph_snapshots_;
  std::map<std::pair<std::string, std::int64_t>, std::int64_t> numbers_;  // by channel and sender
  std::int64_t pieces_ = 0, split_ = 0;
  const Input* keyframes_ = nullptr;
  std::int64_t keyframes_lost_ = 0, asked_ = 0;
  Clock::time_point next_request_{};
  bool carries_maps_ = false, told_ = false;
  Clock::time_point next_recall_{};
  Clock::duration recall_pause_{};
  std::atomic<std::int64_t> recalls_{0};
  bridge::TokenBucket bus_;  // bytes that go on the bus

  mutable std::mutex mutex_;  // for what follows
  Incoming incoming_;
  std::deque<Incoming::Message> inbox_;
  std::size_t inbox_bytes_ = 0;
  bool is_ending_ = false;  // the link waits for nothing any more
  std::condition_variable room_;
  std::int64_t inbox_drops_ = 0, handed_on_ = 0;
  std::unique_ptr<bridge::BrokerLink> link_;  // last: its thread ends first
};

}  // namespace lcmslam
