#include <lcmslam/log/log_writer.hpp>

#include <fcntl.h>
#include <cerrno>
#include <cstring>
#include <stdexcept>
#include <utility>

#include <lcmslam/log/log_format.hpp>

namespace lcmslam {

LogWriter::LogWriter(const std::string& file) : file_(file) {
  try {
    part_ = std::make_unique<PartFile>(FilePlace(file));
  } catch (const std::exception& error) {
    throw std::runtime_error(file_ + ": cannot be written: " + error.what());
  }
  stream_ = fdopen(fcntl(part_->descriptor(), F_DUPFD_CLOEXEC, 0), "wb");
  if (stream_ == nullptr) fail();
  std::setvbuf(stream_, nullptr, _IOFBF, 1 << 20);
}

LogWriter::~LogWriter() {
  if (stream_ != nullptr) std::fclose(stream_);
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
  if (std::fclose(std::exchange(stream_, nullptr)) != 0) fail();
  try {
    part_->flush();
    part_->take_name();
  } catch (const std::exception& error) {
    throw std::runtime_error(file_ + ": cannot be written: " + error.what());
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
