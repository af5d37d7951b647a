#include <lcmslam/files/atomic_file.hpp>

#include <fcntl.h>
#include <unistd.h>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

void write_part(const FilePlace& file, const std::function<void(PartFile&)>& write) {
  try {
    PartFile part(file);
    write(part);
    part.flush();
    part.take_name();
  } catch (const std::exception& error) {
    throw std::runtime_error("cannot save " + file.path().string() + ": " + error.what());
  }
  fsync(file.folder.descriptor());  // the new name itself; the content is safe already
}

void write_all(int descriptor, const std::string& bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t written = write(descriptor, bytes.data() + done, bytes.size() - done);
    if (written >= 0)
      done += static_cast<std::size_t>(written);
    else if (errno != EINTR)
      throw std::runtime_error(std::strerror(errno));
  }
}

}  // namespace

void write_atomically(const FilePlace& file, const std::function<void(const fs::path&)>& write) {
  write_part(file, [&](PartFile& part) { write(part.path()); });
}

void write_atomically(const FilePlace& file, const std::string& bytes) {
  write_part(file, [&](PartFile& part) { write_all(part.descriptor(), bytes); });
}

}  // namespace lcmslam
