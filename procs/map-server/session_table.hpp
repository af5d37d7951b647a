#pragma once
// The maps of one kind of mapper, a session each: what one process made under one frame. A new process or a
// new frame begins another session; the old one stays as it is. The table is bounded, and whoever merely
// sends map messages cannot take it over: once a mapper's poses have been heard, only its sender begins
// sessions, and sessions of senders that were never heard make room for it.

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <lcmslam/messages/followed_graph.hpp>

namespace lcmslam {

struct SessionKey {
  std::int64_t sender = 0;
  std::string frame;
  bool operator==(const SessionKey& other) const { return sender == other.sender && frame == other.frame; }
};

template <class Map>
class SessionTable {
 public:
  struct Session {
    SessionKey key;
    Map map;
    std::int64_t heard = 0;     ///< the higher, the later its mapper began to speak; 0: never heard
    FollowedGraph graph;        ///< of ICP_GRAPH
    std::string evidence = {};  ///< what says where it lies in the file's map; empty: nothing yet
  };

  /// Each session's map begins as a copy of `blank`.
  SessionTable(std::size_t most, Map blank)
      : most_(std::max<std::size_t>(most, 1)), blank_(std::move(blank)) {}

  /// The mapper that is alive, from a pose of it. True when it is another one, or in another frame, than
  /// before.
  bool hear(const SessionKey& key) {
    const bool is_new = speakers_ == 0 || !(key == speaker_);
    if (is_new) ++speakers_;
    speaker_ = key;
    if (Session* session = find(key)) session->heard = speakers_;
    return is_new;
  }

  Session* find(const SessionKey& key) {
    const auto found =
        std::find_if(sessions_.begin(), sessions_.end(), [&](const Session& s) { return s.key == key; });
    return found != sessions_.end() ? &*found : nullptr;
  }

  /// The session of this key, begun when there is none; nullptr when it is refused.
  Session* session(const SessionKey& key) {
    if (Session* known = find(key)) return known;
    const bool speaks = speakers_ > 0 && key == speaker_;
    if (is_stranger(key) || !has_room(speaks)) {
      ++refused_;
      return nullptr;
    }
    sessions_.push_back({key, blank_, speaks ? speakers_ : 0, {}, {}});
    return &sessions_.back();
  }

  /// Another process speaks as the mapper: a second one, or the next one, whose poses are not believed yet.
  bool is_stranger(const SessionKey& key) const { return speakers_ > 0 && key.sender != speaker_.sender; }

  /// Keeps a map that a message would take the most of, as a session that nobody adds to. False when the
  /// table is full: the message is to be refused.
  bool keep_beside(const SessionKey& key, Map map) {
    if (!has_room(false)) {
      ++refused_;
      return false;
    }
    sessions_.push_back(
        {{key.sender, key.frame + "-kept-" + std::to_string(++kept_)}, std::move(map), 0, {}, {}});
    return true;
  }

  /// Index of the one that is told and saved first: of the mapper that is alive, or was last, or came first.
  std::size_t current() const {
    std::size_t best = 0;
    for (std::size_t i = 1; i < sessions_.size(); ++i)
      if (sessions_[i].heard > sessions_[best].heard) best = i;
    return best;
  }
  const Map* current_map() const { return sessions_.empty() ? nullptr : &sessions_[current()].map; }

  /// "fastslam" for the current one, the others with their number; `before` of earlier runs come first.
  std::string name(const std::string& mapper, std::size_t index, std::size_t before = 0) const {
    return index == current() ? mapper : mapper + "-session" + std::to_string(before + index + 1);
  }

  /// The first one goes. Not for the current one.
  void drop_first() { sessions_.erase(sessions_.begin()); }

  const std::vector<Session>& all() const { return sessions_; }
  bool empty() const { return sessions_.empty(); }
  std::size_t size() const { return sessions_.size(); }
  /// Sessions that were not begun, or made room.
  std::int64_t refused() const { return refused_; }

 private:
  /// For the mapper that speaks, the newest session that was never heard goes.
  bool has_room(bool speaks) {
    if (sessions_.size() < most_) return true;
    if (!speaks) return false;
    for (auto session = sessions_.rbegin(); session != sessions_.rend(); ++session) {
      if (session->heard > 0) continue;
      sessions_.erase(std::next(session).base());
      ++refused_;
      return true;
    }
    return false;
  }

  std::size_t most_;
  Map blank_;
  std::vector<Session> sessions_;  // in the order in which they began
  SessionKey speaker_;
  std::int64_t speakers_ = 0;
  std::int64_t refused_ = 0, kept_ = 0;
};

}  // namespace lcmslam
