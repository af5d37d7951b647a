#pragma once
// A bus in memory: what one node publishes is delivered to all, in order, and kept.

#include <deque>
#include <memory>

#include <lcmslam/runtime/node.hpp>
#include "tests/unit/runtime/capturing_publisher.hpp"

namespace lcmslam::testing {

class TestBus {
 public:
  /// Makes a node that publishes on this bus and hears all that is delivered.
  template <class N>
  N& add(const ConfigNode& config = {}, std::int64_t sender = 0) {
    members_.push_back(std::make_unique<Member>());
    Member& member = *members_.back();
    member.publisher = std::make_unique<CapturingPublisher>(
        sender != 0 ? sender : static_cast<std::int64_t>(members_.size()));
    auto node = std::make_unique<N>(config, *member.publisher);
    N& result = *node;
    member.node = std::move(node);
    member.node->connect(member.inputs);
    return result;
  }

  /// Delivers the bytes, then all that the nodes answer.
  void deliver(const std::string& channel, const std::vector<std::uint8_t>& bytes) {
    std::deque<Published> waiting = {{channel, bytes, 0}};
    while (!waiting.empty()) {
      const Published message = std::move(waiting.front());
      waiting.pop_front();
      for (const auto& member : members_) {
        member->inputs.deliver(message.channel, message.bytes.data(), message.bytes.size());
        collect(*member, waiting);
      }
    }
  }
  template <class M>
  void deliver(const std::string& channel, const M& message) {
    deliver(channel, encode_message(message));
  }

  /// What finish() of the nodes publishes is kept but not delivered.
  void finish() {
    std::deque<Published> nobody_listens;
    for (const auto& member : members_) {
      member->node->finish();
      collect(*member, nobody_listens);
    }
  }
  /// What nodes do when no message comes; what they publish is delivered.
  void work() {
    std::deque<Published> answers;
    for (const auto& member : members_) {
      member->node->work();
      collect(*member, answers);
    }
    for (const Published& answer : answers) deliver(answer.channel, answer.bytes);
  }
  /// A COMMAND to all nodes.
  void command(const std::string& name) {
    command_t message;
    message.name = name;
    std::deque<Published> answers;
    for (const auto& member : members_) {
      member->node->command(message);
      collect(*member, answers);
    }
    for (const Published& answer : answers) deliver(answer.channel, answer.bytes);
  }

  const std::vector<Published>& published() const { return published_; }
  template <class M>
  std::vector<M> on(const std::string& channel) const {
    std::vector<M> messages;
    for (const Published& p : published_)
      if (p.channel == channel) messages.push_back(decode_message<M>(p.bytes.data(), p.bytes.size()));
    return messages;
  }
  std::size_t count(const std::string& channel) const {
    std::size_t n = 0;
    for (const Published& p : published_) n += p.channel == channel;
    return n;
  }
  /// Of the node that was added `index`-th.
  const Input& input(std::size_t index, const std::string& channel) const {
    for (const auto& input : members_.at(index)->inputs.all())
      if (input->channel() == channel) return *input;
    throw std::invalid_argument("nobody listens to " + channel);
  }
  /// What the node that was added `index`-th thinks of its messages' stamps.
  const StampJudge& stamps(std::size_t index) const { return members_.at(index)->inputs.stamps(); }
  std::int64_t decode_errors() const {
    std::int64_t sum = 0;
    for (const auto& member : members_)
      for (const auto& input : member->inputs.all()) sum += input->decode_errors;
    return sum;
  }

 private:
  struct Member {
    std::unique_ptr<CapturingPublisher> publisher;
    std::unique_ptr<Node> node;
    Inputs inputs;
  };

  void collect(Member& member, std::deque<Published>& waiting) {
    for (Published& p : member.publisher->all) {
      published_.push_back(p);
      waiting.push_back(std::move(p));
    }
    member.publisher->all.clear();
  }

  std::vector<std::unique_ptr<Member>> members_;
  std::vector<Published> published_;
};

/// A node's own value in STATUS.
inline double value_of(const Node& node, const std::string& name) {
  for (const auto& [key, value] : node.report().values)
    if (key == name) return value;
  throw std::invalid_argument("no value " + name);
}

}  // namespace lcmslam::testing
