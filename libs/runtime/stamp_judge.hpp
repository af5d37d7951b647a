#pragma once
// What a message's stamp means: decided here, for every process alike.
//
// Each channel is a voice: the publisher that is kept, the newest stamp that was taken from it, its usual
// period. A stamp is believed when it goes on from its own channel, or keeps up with the others after a
// silence. What disagrees with both is refused, and starts a run: messages of one sender that agree with each
// other. A run is believed when it lasts so long that every voice which tells another time, or another
// publisher of its channel, would have spoken meanwhile. So one wrong stamp, or a hundred between right ones,
// change nothing, and a real jump costs a few messages:
//
//   forward   a gap: time went on and nobody measured; the map stays
//   backward  time began anew (a log that loops): a new session, beside whatever the old one made
//   another sender, its predecessor silent: the process restarted
//
// How long a predecessor has been silent is told best by the other channels: where they say so, a successor
// is believed sooner than his own messages alone would be.
//
// Message time only, never the wall clock: the same messages give the same verdicts.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <lcmslam/geometry/transform.hpp>

namespace lcmslam {

enum class StampVerdict {
  take,         ///< goes on
  late,         ///< came late or twice: its time is past
  refused,      ///< contradicts its channel and the others
  foreign,      ///< of a second publisher while the kept one is alive
  new_session,  ///< time began anew; to be taken, as the first of a new session
};

struct StampJudgeSettings {
  double tolerance = 2;  ///< s; recordings pause for a second now and then, and no stamp is late by two
  double patience = 3;   ///< usual periods after which a voice would have spoken
  int agreeing = 3;      ///< messages of a run at least, where they come as regularly as the channel's did
  int agreeing_irregular = 10;  ///< the same for others
  double shortest_run = 0.5;    ///< s, by its own stamps
  // Of a successor, when the others and he agree on how long his predecessor has been silent:
  int agreeing_successor = 2;
  double shortest_silence = 0.3;  ///< s; a process starts no faster, and one that is busy may pause so long
};

class StampJudge {
 public:
  explicit StampJudge(const StampJudgeSettings& settings = {});

  /// Messages of one channel come in the order of their arrival. `sender`: see status_t.
  StampVerdict judge(const std::string& channel, std::int64_t sender, Utime utime);

  /// The newest time that is believed; 0 before the first message.
  Utime now() const;
  /// The publisher whose messages of a channel are taken; 0: none yet, or one that does not tell.
  std::int64_t kept_sender(const std::string& channel) const;
  std::int64_t refused() const { return refused_; }
  std::int64_t foreign() const { return foreign_; }
  std::int64_t sessions() const { return sessions_; }
  /// Which channel has a second publisher, or stamps that are not believed, in words; empty: none since the
  /// session began.
  std::string trouble() const;

 private:
  /// Messages that contradict what is known but not each other.
  struct Run {
    std::int64_t sender = 0;
    Utime first = 0, newest = 0;
    int count = 0;
    bool regular = true;  // no step longer than the channel's usual ones
  };
  struct Voice {
    bool speaks = false;  // in this session
    std::int64_t sender = 0;
    Utime newest = 0;
    std::optional<Utime> others = {};  // newest of the others when it spoke last
    Utime period = 0;                  // usual, us
    std::vector<Run> runs;
    std::int64_t refused = 0, foreign = 0, last_foreign = 0;  // in this session
  };

  Utime usual_silence(const Voice& voice) const;
  Utime tolerance(const Voice& voice) const;
  std::optional<Utime> others_newest(const Voice& voice) const;
  bool goes_on(const Voice& voice, Utime utime) const;
  bool is_silent(const Voice& voice) const;
  StampVerdict take(Voice& voice, std::int64_t sender, Utime utime);
  StampVerdict doubt(Voice& voice, std::int64_t sender, Utime utime);
  const Run& run_of(Voice& voice, std::int64_t sender, Utime utime) const;
  bool is_believed(const Run& run, const Voice& own) const;
  bool succeeds(const Run& run, const Voice& voice) const;
  StampVerdict follow(Voice& voice, const Run& believed, bool anew);

  StampJudgeSettings settings_;
  std::map<std::string, Voice> voices_;  // by channel
  std::int64_t refused_ = 0, foreign_ = 0, sessions_ = 1;
};

/// Whether a CAMERA_CALIBRATION is a second camera's: the one in use came with the images that are taken.
inline bool is_of_another_camera(std::int64_t sender, std::int64_t in_use, const StampJudge& stamps) {
  const std::int64_t kept = stamps.kept_sender("CAMERA");
  return kept != 0 && in_use == kept && sender != kept;
}

}  // namespace lcmslam
