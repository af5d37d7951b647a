// Any sequence of stamps, poses and map messages: within a session a channel's time only goes on, the table
// of sessions stays bounded, and no message takes away a map that a living mapper made.

#include <cstdlib>

#include <lcmslam/map_store/landmark_map.hpp>
#include <lcmslam/runtime/stamp_judge.hpp>
#include "procs/map-server/session_table.hpp"

namespace lcmslam {
namespace {

void require(bool condition) {
  if (!condition) std::abort();
}

class Input {
 public:
  Input(const std::uint8_t* data, std::size_t size) : data_(data), left_(size) {}
  bool empty() const { return left_ == 0; }
  int next() { return left_ == 0 ? 0 : (--left_, *data_++); }

 private:
  const std::uint8_t* data_;
  std::size_t left_;
};

/// Steps of a sensor mostly, sometimes far jumps and the limits.
Utime stamp(Input& input, Utime now) {
  const int byte = input.next();
  if (byte < 200) return now + 1000 * byte;
  if (byte < 250) return now + 1'000'000 * (byte - 225);
  return byte < 253 ? byte - 251 : (byte == 253 ? INT64_MAX : INT64_MIN);
}

class Session {
 public:
  void take(Input& input) {
    const int what = input.next();
    const char* const channels[] = {"FASTSLAM_POSE", "ICP_POSE"};
    const std::string channel = channels[what & 1];
    const SessionKey key{1 + (what >> 1) % 3, (what >> 3) % 8 == 0 ? "map-2" : "map"};
    if (what < 128)
      pose(channel, key, stamp(input, judge_.now()));
    else
      landmarks(key, input.next());
    require(table_.size() <= most);
    for (const SessionKey& heard : made_) require(table_.find(heard) != nullptr);
    require(judge_.trouble().size() < 1000);
  }

 private:
  static constexpr std::size_t most = 4;

  void pose(const std::string& channel, const SessionKey& key, Utime utime) {
    const Utime before = judge_.now();
    const std::int64_t sessions = judge_.sessions();
    const StampVerdict verdict = judge_.judge(channel, key.sender, utime);
    require((judge_.sessions() > sessions) == (verdict == StampVerdict::new_session));
    const bool taken = verdict == StampVerdict::take || verdict == StampVerdict::new_session;
    if (verdict == StampVerdict::new_session) newest_.clear();
    if (!taken) return require(judge_.now() == before);
    require(newest_.count(channel) == 0 || newest_[channel] < utime);
    newest_[channel] = utime;
    require(judge_.kept_sender(channel) == key.sender);
    if (channel != "FASTSLAM_POSE") return;
    table_.hear(key);
    speaker_ = key;
    if (table_.find(key) != nullptr) note(key);
  }

  void landmarks(const SessionKey& key, int id) {
    auto* session = table_.session(key);
    if (session == nullptr) return;
    Landmark landmark;
    landmark.id = id;
    session->map.apply({session->map.revision() + 1, session->map.revision(), {landmark}, {}});
    if (key == speaker_) note(key);
  }

  void note(const SessionKey& key) {
    if (std::find(made_.begin(), made_.end(), key) == made_.end()) made_.push_back(key);
  }

  StampJudge judge_;
  SessionTable<LandmarkMap> table_{most, LandmarkMap(50)};
  std::map<std::string, Utime> newest_;
  SessionKey speaker_{-1, ""};
  std::vector<SessionKey> made_;  // by mappers whose poses were taken
};

}  // namespace
}  // namespace lcmslam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  Input input(data, size);
  Session session;
  while (!input.empty()) try {
      session.take(input);
    } catch (const std::invalid_argument&) {  // a full map
    }
  return 0;
}
