// Any bytes as a log: no crash, and events and damages cover them exactly.

#include <cstdlib>

#include <lcmslam/log/log_reader.hpp>

namespace {

/// Decides by the bytes, so that the fuzzer reaches every verdict.
lcmslam::Wholeness check(std::string_view, const std::uint8_t* data, std::size_t size) {
  if (size == 0 || data[size - 1] % 3 == 0) return lcmslam::Wholeness::undecided;
  return data[size - 1] % 3 == 1 ? lcmslam::Wholeness::whole : lcmslam::Wholeness::damaged;
}

void read(lcmslam::LogReader& reader) {
  std::uint64_t covered = 0;
  volatile unsigned sum = 0;  // every byte is read
  while (const auto event = reader.next_view()) {
    covered += 28 + event->channel.size() + event->size + event->seal;
    for (const char c : event->channel) sum = sum + static_cast<unsigned char>(c);
    for (std::size_t i = 0; i < event->size; ++i) sum = sum + event->data[i];
  }
  for (const auto& damage : reader.damages()) covered += damage.end - damage.begin;
  if (covered != reader.size()) std::abort();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lcmslam::LogReader plain(data, size), checked(data, size, check);
  read(plain);
  read(checked);
  checked.seek(size > 0 ? data[0] : 0);
  return 0;
}
