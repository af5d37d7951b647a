#pragma once
// A log in memory whose messages carry a checksum, and files that live as long as their test.

#include <unistd.h>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include <lcmslam/geometry/random.hpp>
#include <lcmslam/log/event_judge.hpp>

namespace lcmslam::testing {

using Bytes = std::vector<std::uint8_t>;

struct SampleEvent {
  LogEvent event;
  std::size_t begin = 0, end = 0;  // in the log
};
struct SampleLog {
  std::vector<SampleEvent> events;
  Bytes bytes;
};

inline std::uint32_t checksum(std::string_view channel, const std::uint8_t* data, std::size_t size) {
  std::uint32_t sum = 2166136261U;  // FNV-1a
  for (const char c : channel) sum = (sum ^ static_cast<std::uint8_t>(c)) * 16777619U;
  for (std::size_t i = 0; i < size; ++i) sum = (sum ^ data[i]) * 16777619U;
  return sum;
}

/// What a reader that knows the messages would say.
inline Wholeness check_sum(std::string_view channel, const std::uint8_t* data, std::size_t size) {
  std::uint32_t sum = 0;
  if (size < 4) return Wholeness::damaged;
  std::memcpy(&sum, data + size - 4, 4);
  return sum == checksum(channel, data, size - 4) ? Wholeness::whole : Wholeness::damaged;
}

inline std::size_t draw(Random& random, std::size_t n) {
  return static_cast<std::size_t>(random.below(n));
}

inline void append_event(Bytes& bytes, const LogEvent& event) {
  const std::size_t begin = bytes.size();
  bytes.resize(begin + log_format::header_size);
  log_format::write_header(bytes.data() + begin,
                           {0, event.number, event.timestamp, event.channel.size(), event.data.size()});
  bytes.insert(bytes.end(), event.channel.begin(), event.channel.end());
  bytes.insert(bytes.end(), event.data.begin(), event.data.end());
}

/// Channels of one size and of changing size; now and then a sync word in a message.
inline SampleLog make_sample_log(Random& random, int n) {
  SampleLog log;
  const char* const channels[] = {"CAMERA", "ENCODERS", "ODD channel, \xC3\xA4", "X"};
  for (int i = 0; i < n; ++i) {
    const std::size_t kind = draw(random, 4);
    LogEvent event{i + 7, 1'000'000 + 10'000 * i, channels[kind], {}};
    event.data.resize(kind == 1 ? 60 : 8 + draw(random, 200));
    for (auto& byte : event.data) byte = static_cast<std::uint8_t>(draw(random, 256));
    for (std::size_t k = 0; k < 8; ++k) event.data[k] = static_cast<std::uint8_t>(16 * kind + k);
    if (kind == 0 && event.data.size() > 100) {
      const std::uint8_t sync[4] = {0xED, 0xA1, 0xDA, 0x01};
      std::memcpy(event.data.data() + 8 + draw(random, 80), sync, 4);
    }
    const std::uint32_t sum = checksum(event.channel, event.data.data(), event.data.size());
    event.data.resize(event.data.size() + 4);
    std::memcpy(event.data.data() + event.data.size() - 4, &sum, 4);
    const std::size_t begin = log.bytes.size();
    append_event(log.bytes, event);
    log.events.push_back({event, begin, log.bytes.size()});
  }
  return log;
}

class ScratchFile {
 public:
  explicit ScratchFile(const std::string& name = "log") {
    std::string pattern = (std::filesystem::temp_directory_path() / "lcmslam-log-XXXXXX").string();
    if (mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("no temporary folder can be made");
    folder_ = pattern;
    path_ = (folder_ / name).string();
  }
  ~ScratchFile() { std::filesystem::remove_all(folder_); }
  ScratchFile(const ScratchFile&) = delete;
  ScratchFile& operator=(const ScratchFile&) = delete;

  const std::string& path() const { return path_; }
  const std::filesystem::path& folder() const { return folder_; }
  void write(const Bytes& bytes) const {
    std::ofstream(path_, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }

 private:
  std::filesystem::path folder_;
  std::string path_;
};

}  // namespace lcmslam::testing
