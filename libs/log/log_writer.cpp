#include <lcmslam/log/log_writer.hpp>

#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <lcmslam/log/log_format.hpp>

namespace lcmslam {

LogWriter::LogWriter(const std::string& file)
    : file_(file), part_(file + ".part" + std::to_string(getpid())) {
  stream_ = std::fopen(part_.c_str(), "wbe");
  if (stream_ == nullptr) fail();
  std::setvbuf(stream_, nullptr, _IOFBF, 1 << 20);
}

LogWriter::~LogWriter() {
  if (stream_ == nullptr) return;
  std::fclose(stream_);
  std::remove(part_.c_str());
}

void LogWriter::write(Utime timestamp, std::string_view channel, const std::uint8_t* data, std::size_t size) {
  const bool readable = !channel.empty() && channel.size() <= log_format::longest_channel &&
                        channel.find('\0') == std::string_view::npos && size <= log_format::largest_data;
  if (!readable)
    throw std::invalid_argument(file_ + ": channel '" + std::string(channel) + "' with " +
                                std::to_string(size) +
                                " bytes: a channel has 1 to 999 bytes, a message at most 2^28");
  std::uint8_t header[log_format::header_size];
  log_format::write_header(header, {0, events_, timestamp, channel.size(), size});
  write_bytes(header, sizeof header);
  write_bytes(channel.data(), channel.size());
  write_bytes(data, size);
  ++events_;
}

void LogWriter::close() {
  if (std::fclose(std::exchange(stream_, nullptr)) != 0 || std::rename(part_.c_str(), file_.c_str()) != 0) {
    const int error = errno;
    std::remove(part_.c_str());
    errno = error;
    fail();
  }
}

void LogWriter::write_bytes(const void* data, std::size_t size) {
  if (size > 0 && std::fwrite(data, 1, size, stream_) != size) fail();
  bytes_ += static_cast<std::int64_t>(size);
}

void LogWriter::fail() {
  throw std::runtime_error(file_ + ": cannot be written: " + std::strerror(errno));
}

}  // namespace lcmslam
