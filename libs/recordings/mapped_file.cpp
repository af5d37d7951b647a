#include <lcmslam/recordings/mapped_file.hpp>

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cerrno>
#include <stdexcept>

namespace lcmslam {

MappedFile::MappedFile(const std::string& file) {
  const int descriptor = open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);  // a pipe shall not hang us
  if (descriptor < 0) throw std::runtime_error(file + ": cannot be opened: " + std::strerror(errno));
  struct stat status {};
  std::string wrong;
  if (fstat(descriptor, &status) != 0 || !S_ISREG(status.st_mode)) {
    wrong = "is not a regular file";
  } else if (status.st_size == 0) {
    wrong = "is empty";
  } else {
    size_ = static_cast<std::size_t>(status.st_size);
    data_ = mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
    if (data_ == MAP_FAILED) wrong = std::string("cannot be read: ") + std::strerror(errno);
  }
  close(descriptor);
  if (!wrong.empty()) throw std::runtime_error(file + ": " + wrong);
}

MappedFile::~MappedFile() {
  munmap(data_, size_);
}

}  // namespace lcmslam
