#pragma once
// An order to a running graph: who carries it out, what is sent to them, and what came of it. Knows no bus.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/command_t.hpp>
#include <lcmslam/map_reply_t.hpp>
#include <lcmslam/map_request_t.hpp>
#include <lcmslam/status_t.hpp>

namespace lcmslam {

/// What `lcmslam send` can say; command_t's names, but "export", which is a map_request_t.
struct OrderWord {
  std::string name;
  std::vector<std::string> processes;  ///< who carries it out
  std::string meaning;
};
const std::vector<OrderWord>& order_words();

class Order {
 public:
  /// `to`: these processes alone; empty: all that carry the word out. `sender` marks what is sent. Throws
  /// std::invalid_argument for an unknown word and for a process that does not carry it out.
  Order(const std::string& word, const std::vector<std::string>& to, std::int64_t sender);

  /// STATUS: before sent() of who is there, after it of what they did. A process is known by its sender, so
  /// one that starts meanwhile is not taken for one that has heard the order.
  void hear(const status_t& status);
  void hear(const map_reply_t& reply);

  /// Everybody that is to carry it out is there.
  bool complete() const;
  /// It goes to all in one message, which each of them would count as a wrong one if it did not confirm it.
  bool concerns_all() const;
  /// Why there is nobody to send it to, in words; empty when there is somebody.
  std::string nobody() const;

  bool is_request() const { return word_->name == "export"; }
  /// One to everybody, or one for each of `to`, with the confirmations that they need.
  std::vector<command_t> commands() const;
  /// EXPORT of the maps into `folder` below map-server's own.
  map_request_t request(const std::string& folder, const std::string& formats) const;
  /// From now on what is heard are answers.
  void sent();

  struct Answer {
    std::string process;
    bool good = false;
    std::string text;
  };
  bool all_answered() const;
  /// Of each that was to carry it out; for who has not answered that it has not, after this time (s).
  std::vector<Answer> answers(double seconds) const;

 private:
  bool is_to_all() const;

  struct Member {
    std::string process;
    bool asked = false;  // it is to carry the order out
    status_t before, now;
    std::optional<Answer> answer;
  };
  bool heard(const status_t& status) const;
  std::optional<Answer> judge(const Member& member) const;
  command_t command(const std::string& target) const;

  const OrderWord* word_;
  std::vector<std::string> to_;         // as asked; empty: all
  std::vector<std::string> processes_;  // that are to carry it out
  std::int64_t sender_;
  bool sent_ = false;
  std::map<std::int64_t, Member> members_;  // by their senders
};

}  // namespace lcmslam
