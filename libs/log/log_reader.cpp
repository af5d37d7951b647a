#include <lcmslam/log/log_reader.hpp>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

namespace lcmslam {

using log_format::Bytes;
using log_format::Header;

/// A file in memory, read only: pages come when they are read and go when memory is short.
class LogReader::Mapping {
 public:
  explicit Mapping(const std::string& file) {
    const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe shall not hang us
    if (descriptor < 0) throw std::runtime_error(file + ": cannot be opened: " + std::strerror(errno));
    struct stat status {};
    const bool known = fstat(descriptor, &status) == 0;
    std::string wrong;
    if (known && S_ISDIR(status.st_mode))
      wrong = "is a folder; an LCM log is a file";
    else if (!known || !S_ISREG(status.st_mode))
      wrong = "is not a regular file; copy the LCM log into one";
    else if (status.st_size == 0)
      wrong = "is empty; an LCM log has at least one event";
    if (wrong.empty()) {
      size_ = static_cast<std::size_t>(status.st_size);
      data_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
      if (data_ == MAP_FAILED) wrong = std::string("cannot be read: ") + std::strerror(errno);
    }
    close(descriptor);
    if (!wrong.empty()) throw std::runtime_error(file + ": " + wrong);
    madvise(data_, size_, MADV_SEQUENTIAL);
  }
  ~Mapping() { munmap(data_, size_); }
  Mapping(const Mapping&) = delete;
  Mapping& operator=(const Mapping&) = delete;

  Bytes bytes() const { return {static_cast<const std::uint8_t*>(data_), size_}; }

 private:
  void* data_ = nullptr;
  std::size_t size_ = 0;
};

LogReader::LogReader(const std::string& file, WholenessCheck check)
    : mapping_(std::make_unique<Mapping>(file)), bytes_(mapping_->bytes()), judge_(bytes_, std::move(check)) {
  if (log_format::find_sync(bytes_, 0, bytes_.size) == bytes_.size)
    throw std::runtime_error(file + ": is no LCM log: no event begins in it (bytes ED A1 DA 01)");
}

LogReader::LogReader(const std::uint8_t* data, std::size_t size, WholenessCheck check)
    : bytes_{data, size}, judge_(bytes_, std::move(check)) {}

LogReader::~LogReader() = default;

std::optional<LogEvent> LogReader::next() {
  const auto event = next_view();
  return event ? std::optional(event->copy()) : std::nullopt;
}

std::optional<LogEventView> LogReader::next_view() {
  while (at_ < bytes_.size) {
    const auto header = header_at(bytes_, at_);
    if (!header || header->end() > bytes_.size) {
      skip_damage();
      continue;
    }
    const EventJudge::Verdict verdict = judge_.judge(*header, contiguous_);
    if (verdict.whole) {
      accept(*header);
      return view(bytes_, *header);
    }
    lose(verdict.resume, "event " + std::to_string(header->number) + ": " + verdict.reason, verdict.framed);
  }
  return std::nullopt;
}

void LogReader::skip_damage() {
  const std::uint64_t next = log_format::find_sync(bytes_, at_ + 1, bytes_.size);
  const auto header = header_at(bytes_, at_);
  std::string reason = "no event begins here";
  if (header)
    reason = "event " + std::to_string(header->number) + ": claims " +
             std::to_string(header->end() - header->offset) + " bytes, the file ends after " +
             std::to_string(bytes_.size - at_);
  else if (log_format::find_sync(bytes_, at_, at_ + 1) == at_)
    reason = bytes_.size - at_ < log_format::header_size ? "the file ends within a header"
                                                         : "a header with impossible values";
  lose(next, reason, false);
}

void LogReader::lose(std::uint64_t end, const std::string& reason, bool framed) {
  const std::uint64_t begin = std::exchange(at_, end);
  contiguous_.reset();
  if (begin < passed_) return;
  passed_ = end;
  const bool joins =
      !framed && damages_.size() > counted_ && damages_.back().end == begin && damages_.back().lost < 0;
  if (joins)
    damages_.back().end = end;
  else
    damages_.push_back({begin, end, reason, framed ? 1 : -1});
}

void LogReader::accept(const Header& header) {
  // The numbers on both sides tell how many events the damage between took.
  if (counted_ < damages_.size() && header.offset >= damages_.back().end) {
    std::int64_t known = 0;
    LogDamage* unknown = nullptr;
    for (std::size_t i = counted_; i < damages_.size(); ++i) {
      if (damages_[i].lost >= 0)
        known += damages_[i].lost;
      else
        unknown = &damages_[i];
    }
    // A number that is damaged itself, or a new session, tells nothing.
    if (unknown != nullptr && last_ && header.number > *last_) {
      const auto missing = static_cast<std::uint64_t>(header.number) - static_cast<std::uint64_t>(*last_) - 1;
      if (missing < 1U << 31)
        unknown->lost = std::max<std::int64_t>(0, static_cast<std::int64_t>(missing) - known);
    }
    counted_ = damages_.size();
  }
  judge_.accepted(view(bytes_, header));
  last_ = contiguous_ = header.number;
  at_ = header.end();
}

void LogReader::rewind() {
  at_ = 0;
  last_.reset();
  contiguous_.reset();
}

void LogReader::seek(Utime timestamp) {
  rewind();
  while (const auto event = next_view()) {
    if (event->timestamp < timestamp) continue;
    at_ = event->offset;
    last_.reset();
    contiguous_.reset();
    return;
  }
}

}  // namespace lcmslam
