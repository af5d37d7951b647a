#pragma once
// What one client is sent next. Its queue is what it has not seen of the board: as long as the board, however
// slow the client.

#include <map>
#include <set>
#include <string>
#include <tuple>

#include <lcmslam/web/board.hpp>
#include <lcmslam/web/link_rate.hpp>

namespace lcmslam {

class ClientQueue {
 public:
  /// `parts`: the client puts messages together that come in parts. What is urgent need not wait then until
  /// a large one is through.
  explicit ClientQueue(const Board& board, bool parts = false) : board_(board), parts_(parts) {}

  // What the browser says; `now` s, of a clock that goes on.
  void eye(const std::array<float, 3>& place);
  /// Of the optional channels those that it shows; all at first.
  void want(const std::set<std::string>& channels);
  void acknowledged(std::uint64_t bytes, double now) { link_.acknowledged(bytes, now); }

  /// What is to go out now, and is under way from then on; null: nothing, or the link is full.
  Board::Message next(double now);

  /// Once, when all that was on the board at the first look has gone out (or is gone): the message that says
  /// so. What the client has of an earlier connection and was not sent again is no more.
  Board::Message whole(double now);

  const LinkRate& link() const { return link_; }
  /// Messages that it lacks.
  std::size_t waiting() const { return waiting_.size(); }

  /// Channels that a browser may do without.
  static const std::set<std::string>& optional_channels();

 private:
  using Rank = std::tuple<Haste, int, float, std::int64_t>;  // haste, urgency, m^2 from the eye, version
  /// A message of which parts have gone out.
  struct Begun {
    Board::EntryPointer entry;
    std::size_t at = 0;  // bytes of it that have gone out
  };
  /// Of a message that has gone out to its end.
  struct Sent {
    std::int64_t version = 0;
    std::uint64_t end = 0;  // bulk_bytes_ after it
  };
  void look();
  Rank rank(const Board::Entry& entry) const;
  void enqueue(const Board::EntryPointer& entry);
  bool may_go(Haste haste, double now);
  bool rests(const Board::Entry& entry) const;
  Board::EntryPointer take_first(Haste haste);
  Board::Message advance(Haste haste, double now);
  void count(const std::string& message, double now);
  bool is_wanted(const std::string& channel) const { return unwanted_.count(channel) == 0; }

  const Board& board_;
  const bool parts_;
  LinkRate link_;
  std::int64_t seen_ = 0;               // version of the board
  std::map<Board::Name, Rank> places_;  // of what waits
  std::map<Rank, Board::EntryPointer> waiting_;
  std::map<Haste, Begun> begun_;
  std::map<Board::Name, Sent> sent_;
  std::set<Board::Name> first_;  // what of the first look has not gone out
  bool has_looked_ = false, is_told_whole_ = false;
  std::set<std::string> unwanted_;
  std::array<float, 3> eye_{};
  std::uint64_t sent_bytes_ = 0, picture_end_ = 0, bulk_bytes_ = 0;
};

}  // namespace lcmslam
