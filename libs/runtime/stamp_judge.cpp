#include <lcmslam/runtime/stamp_judge.hpp>

#include <algorithm>
#include <cstdlib>

namespace lcmslam {
namespace {

constexpr std::size_t most_runs = 4;                 // of a channel: several strangers at once
constexpr Utime far_away = 100'000'000'000'000'000;  // us, 3000 years: differences do not overflow
constexpr Utime latest = 1'000'000;                  // us that a message may be behind its channel
constexpr Utime longest_latency = 10'000'000;        // us that a channel's first message may be behind others
constexpr Utime longest_step = 10'000'000;           // us between two messages of a run

Utime us(double seconds) {
  return static_cast<Utime>(1e6 * seconds);
}

}  // namespace

StampJudge::StampJudge(const StampJudgeSettings& settings) : settings_(settings) {}

StampVerdict StampJudge::judge(const std::string& channel, std::int64_t sender, Utime utime) {
  Voice& voice = voices_[channel];
  if (utime < -far_away || utime > far_away) {
    ++refused_, ++voice.refused;
    return StampVerdict::refused;
  }
  const bool kept = !voice.speaks || sender == voice.sender || is_silent(voice);
  if (!kept || !goes_on(voice, utime)) return doubt(voice, sender, utime);
  if (voice.speaks && utime <= voice.newest) return StampVerdict::late;
  return take(voice, sender, utime);
}

Utime StampJudge::usual_silence(const Voice& voice) const {
  return static_cast<Utime>(settings_.patience * static_cast<double>(voice.period));
}

Utime StampJudge::tolerance(const Voice& voice) const {
  return std::max(us(settings_.tolerance), usual_silence(voice));
}

std::optional<Utime> StampJudge::others_newest(const Voice& voice) const {
  std::optional<Utime> newest;
  for (const auto& [channel, other] : voices_)
    if (other.speaks && &other != &voice) newest = newest ? std::max(*newest, other.newest) : other.newest;
  return newest;
}

// Others may vouch for a stamp that is ahead of its channel, never for one that is behind it.
bool StampJudge::goes_on(const Voice& voice, Utime utime) const {
  const std::optional<Utime> others = others_newest(voice);
  const bool vouched = others && utime <= *others + tolerance(voice);
  if (!voice.speaks) return !others || (vouched && utime >= *others - longest_latency);
  const Utime ahead = utime - voice.newest;
  return ahead > -std::max(latest, usual_silence(voice)) && (ahead <= tolerance(voice) || vouched);
}

bool StampJudge::is_silent(const Voice& voice) const {
  const std::optional<Utime> others = others_newest(voice);
  return others && *others - voice.newest > tolerance(voice);
}

// A voice that speaks refutes who speaks in its place, and who tells another time.
StampVerdict StampJudge::take(Voice& voice, std::int64_t sender, Utime utime) {
  const Utime step = utime - voice.newest;
  if (voice.speaks && step <= tolerance(voice))
    voice.period = voice.period == 0 ? step : voice.period + (step - voice.period) / 8;
  voice.speaks = true;
  voice.sender = sender;
  if (voice.last_foreign == sender) voice.foreign = 0;  // no stranger: he has come after who was kept
  voice.newest = utime;
  voice.others = others_newest(voice);
  voice.runs.clear();
  const auto is_refuted = [&](const Run& run) { return std::abs(run.newest - utime) > tolerance(voice); };
  for (auto& [channel, other] : voices_)
    other.runs.erase(std::remove_if(other.runs.begin(), other.runs.end(), is_refuted), other.runs.end());
  return StampVerdict::take;
}

StampVerdict StampJudge::doubt(Voice& voice, std::int64_t sender, Utime utime) {
  const Run& run = run_of(voice, sender, utime);
  const bool begins_anew = run.newest < now() - std::max(latest, usual_silence(voice));
  const bool ahead = !voice.speaks || run.newest > voice.newest;
  if ((begins_anew || ahead) && is_believed(run, voice)) return follow(voice, run, begins_anew);
  if (succeeds(run, voice)) return follow(voice, run, false);
  if (voice.speaks && sender != voice.sender) {
    ++foreign_, ++voice.foreign;
    voice.last_foreign = sender;
    return StampVerdict::foreign;
  }
  ++refused_, ++voice.refused;
  return StampVerdict::refused;
}

// The one that this message goes on from, or a new one in the place of the shortest.
const StampJudge::Run& StampJudge::run_of(Voice& voice, std::int64_t sender, Utime utime) const {
  const bool is_known = voice.period > 0;
  const Utime longest_regular = is_known ? usual_silence(voice) : longest_step;
  for (Run& run : voice.runs) {
    const Utime ahead = utime - run.newest;
    if (run.sender != sender || ahead < 0 || ahead > longest_step) continue;
    if (ahead > 0) {
      run.regular = run.regular && ahead <= longest_regular;
      run.newest = utime;
      ++run.count;
    }
    return run;
  }
  if (voice.runs.size() == most_runs)
    voice.runs.erase(std::min_element(voice.runs.begin(), voice.runs.end(),
                                      [](const Run& a, const Run& b) { return a.count < b.count; }));
  voice.runs.push_back({sender, utime, utime, 1, true});
  return voice.runs.back();
}

// Long enough, and nobody else would have kept silent: not the kept publisher of its channel, and no other
// channel, unless that tells the same time.
bool StampJudge::is_believed(const Run& run, const Voice& own) const {
  const Utime span = run.newest - run.first;
  const int agreeing = run.regular ? settings_.agreeing : settings_.agreeing_irregular;
  // One who begins after his predecessor's silence has that for him, too. (Each message that is taken ends
  // all runs of its channel.)
  const bool comes_after =
      run.sender != own.sender && own.speaks && run.first - own.newest >= us(settings_.shortest_silence);
  const double shortest = comes_after ? settings_.shortest_silence : settings_.shortest_run;
  if (run.count < agreeing || span < us(shortest)) return false;
  return std::all_of(voices_.begin(), voices_.end(), [&](const auto& entry) {
    const Voice& voice = entry.second;
    const auto agrees = [&](Utime newest) { return std::abs(newest - run.newest) <= tolerance(voice); };
    const bool joined = &voice != &own &&
                        (agrees(voice.newest) || std::any_of(voice.runs.begin(), voice.runs.end(),
                                                             [&](const Run& r) { return agrees(r.newest); }));
    const bool silent = span >= usual_silence(voice);
    return !voice.speaks || joined || silent;
  });
}

// His stamps alone prove nothing (they may be ahead, or his predecessor's late), and nor do the others' alone
// (they may have been late themselves).
bool StampJudge::succeeds(const Run& run, const Voice& voice) const {
  const std::optional<Utime> others = others_newest(voice);
  const bool known = voice.speaks && voice.period > 0 && others && voice.others;
  if (!known || run.sender == voice.sender || run.count < settings_.agreeing_successor || !run.regular)
    return false;
  const Utime silence = std::min(run.newest - voice.newest, *others - *voice.others);
  return silence >= std::max(us(settings_.shortest_silence), usual_silence(voice)) &&
         run.newest <= *others + tolerance(voice);
}

StampVerdict StampJudge::follow(Voice& voice, const Run& believed, bool anew) {
  const Run run = believed;
  if (anew) {
    for (auto& [channel, other] : voices_) other = Voice{};
    ++sessions_;
  }
  take(voice, run.sender, run.newest);
  voice.period = (run.newest - run.first) / (run.count - 1);
  return anew ? StampVerdict::new_session : StampVerdict::take;
}

Utime StampJudge::now() const {
  return others_newest(Voice{}).value_or(0);
}

std::int64_t StampJudge::kept_sender(const std::string& channel) const {
  const auto voice = voices_.find(channel);
  return voice != voices_.end() ? voice->second.sender : 0;
}

std::string StampJudge::trouble() const {
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : "; ") + what; };
  for (const auto& [channel, voice] : voices_) {
    if (voice.foreign > 0)
      add(channel + ": " + std::to_string(voice.foreign) + " messages of another sender (" +
          std::to_string(voice.last_foreign) + ") left out, " + std::to_string(voice.sender) + " is kept");
    if (voice.refused > 0) add(channel + ": " + std::to_string(voice.refused) + " stamps refused");
  }
  return text;
}

}  // namespace lcmslam
