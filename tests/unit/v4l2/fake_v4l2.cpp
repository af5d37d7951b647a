#include "tests/unit/v4l2/fake_v4l2.hpp"

#include <dlfcn.h>
#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdarg>
#include <cstring>
#include <ctime>
#include <deque>
#include <memory>
#include <opencv2/imgcodecs.hpp>
#include <thread>

#include "tests/support/written_head.hpp"

namespace lcmslam::testing {
namespace {

constexpr unsigned buffers = 4;
constexpr std::size_t buffer_size = 1280 * 960 * 3;
constexpr std::uint32_t formats[] = {V4L2_PIX_FMT_BGR24, V4L2_PIX_FMT_Y16};

std::atomic<int> handle{-1};
char* memory = nullptr;  // the buffers, which the camera's owner maps by the same handle
std::deque<unsigned> queued;
bool streaming = false;
std::int64_t next_capture = 0;

std::int64_t now() {
  using namespace std::chrono;
  return duration_cast<microseconds>(steady_clock::now().time_since_epoch()).count();
}

template <class F>
F real(const char* function) {
  return reinterpret_cast<F>(dlsym(RTLD_NEXT, function));
}

int fail(int error) {
  errno = error;
  return -1;
}

bool is_ready() {
  return streaming && !fake_v4l2().silent && now() >= next_capture + FakeV4l2::delay;
}

int set_format(v4l2_format& format) {
  FakeV4l2& camera = fake_v4l2();
  v4l2_pix_format& pixels = format.fmt.pix;
  camera.size = camera.only_size.area() > 0 ? camera.only_size
                                            : cv::Size(static_cast<int>(std::min(pixels.width, 1280U)),
                                                       static_cast<int>(std::min(pixels.height, 960U)));
  const bool jpeg = camera.has_jpeg && pixels.pixelformat == V4L2_PIX_FMT_MJPEG;
  if (!jpeg && std::find(std::begin(formats), std::end(formats), pixels.pixelformat) == std::end(formats))
    pixels.pixelformat = formats[0];
  camera.format = pixels.pixelformat;
  pixels.width = static_cast<unsigned>(camera.size.width);
  pixels.height = static_cast<unsigned>(camera.size.height);
  pixels.bytesperline = pixels.width * (camera.format == V4L2_PIX_FMT_Y16 ? 2 : 3);
  pixels.sizeimage = pixels.bytesperline * pixels.height;
  return 0;
}

int dequeue(v4l2_buffer& buffer) {
  FakeV4l2& camera = fake_v4l2();
  if (queued.empty() || !is_ready()) return fail(EAGAIN);
  buffer.index = queued.front();
  queued.pop_front();
  const cv::Mat image = camera.format == V4L2_PIX_FMT_Y16 ? numbered_depth(camera.size, ++camera.number)
                                                          : numbered_colour(camera.size, ++camera.number);
  std::size_t bytes = image.total() * image.elemSize();
  char* const to = memory + buffer.index * buffer_size;
  if (camera.format == V4L2_PIX_FMT_MJPEG) {
    cv::imencode(".jpg", image, camera.jpeg);
    bytes = camera.jpeg.size() - std::min(camera.jpeg.size(), camera.cut_off.load());
    std::memset(to, 0, buffer_size);
    std::memcpy(to, camera.jpeg.data(), bytes);
  } else {
    std::memcpy(to, image.data, bytes);
  }
  camera.captured = next_capture - camera.waited;
  buffer.length = buffer_size;
  buffer.bytesused = static_cast<unsigned>(bytes);
  buffer.timestamp = {camera.captured / 1'000'000, camera.captured % 1'000'000};
  const std::int64_t period = 1'000'000 / camera.rate;
  next_capture += period;
  // What nobody fetched is overwritten.
  while (next_capture + 3 * period < now()) next_capture += period;
  return 0;
}

int control(v4l2_control& c, bool set) {
  FakeV4l2& camera = fake_v4l2();
  int* value = c.id == V4L2_CID_EXPOSURE_AUTO       ? &camera.exposure_mode
               : c.id == V4L2_CID_EXPOSURE_ABSOLUTE ? &camera.exposure
                                                    : nullptr;
  if (value == nullptr) return fail(EINVAL);
  (set ? *value : c.value) = set ? c.value : *value;
  return 0;
}

int answer(unsigned long request, void* argument) {
  FakeV4l2& camera = fake_v4l2();
  if (!camera.plugged) return fail(ENODEV);
  switch (request) {
    case VIDIOC_QUERYCAP:
      static_cast<v4l2_capability*>(argument)->capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
      return 0;
    case VIDIOC_S_FMT:
    case VIDIOC_G_FMT:
      return set_format(*static_cast<v4l2_format*>(argument));
    case VIDIOC_S_PARM:
      camera.rate =
          static_cast<int>(static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe.denominator);
      return 0;
    case VIDIOC_G_PARM:
      static_cast<v4l2_streamparm*>(argument)->parm.capture.timeperframe = {
          1, static_cast<unsigned>(camera.rate)};
      return 0;
    case VIDIOC_REQBUFS: {
      auto& wanted = *static_cast<v4l2_requestbuffers*>(argument);
      wanted.count = std::min(wanted.count, buffers);
      queued.clear();
      return 0;
    }
    case VIDIOC_QUERYBUF: {
      auto& buffer = *static_cast<v4l2_buffer*>(argument);
      buffer.length = buffer_size;
      buffer.m.offset = static_cast<unsigned>(buffer.index * buffer_size);
      return 0;
    }
    case VIDIOC_QBUF:
      queued.push_back(static_cast<v4l2_buffer*>(argument)->index);
      return 0;
    case VIDIOC_DQBUF:
      return dequeue(*static_cast<v4l2_buffer*>(argument));
    case VIDIOC_STREAMON:
      streaming = true;
      next_capture = now();
      return 0;
    case VIDIOC_STREAMOFF:
      streaming = false;
      return 0;
    case VIDIOC_QUERYCTRL: {
      auto& query = *static_cast<v4l2_queryctrl*>(argument);
      if (query.id != V4L2_CID_EXPOSURE_AUTO && query.id != V4L2_CID_EXPOSURE_ABSOLUTE) return fail(EINVAL);
      query.minimum = 0;
      query.maximum = 10'000;
      query.flags = 0;
      return 0;
    }
    case VIDIOC_G_CTRL:
      return control(*static_cast<v4l2_control*>(argument), false);
    case VIDIOC_S_CTRL:
      return control(*static_cast<v4l2_control*>(argument), true);
    default:
      return fail(ENOTTY);
  }
}

/// Waits for an image or until the time is over; gives poll()'s events.
short wait_for_image(std::int64_t microseconds) {
  const std::int64_t end = now() + microseconds;
  while (true) {
    if (!fake_v4l2().plugged) return POLLERR;
    if (is_ready() && !queued.empty()) return POLLIN | POLLRDNORM;
    if (now() >= end) return 0;
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
}

}  // namespace

std::atomic<std::int64_t> wall_clock_set{0};

static std::unique_ptr<FakeV4l2>& only_one() {
  static auto camera = std::make_unique<FakeV4l2>();
  return camera;
}

FakeV4l2& fake_v4l2() {
  return *only_one();
}

void reset_fake_v4l2() {
  only_one() = std::make_unique<FakeV4l2>();
  wall_clock_set = 0;
}

}  // namespace lcmslam::testing

using lcmslam::testing::answer;
using lcmslam::testing::fail;
using lcmslam::testing::fake_v4l2;
using lcmslam::testing::handle;
using lcmslam::testing::real;
using lcmslam::testing::wait_for_image;
using lcmslam::testing::wall_clock_set;

extern "C" {

int open(const char* path, int flags, ...) {
  va_list arguments;
  va_start(arguments, flags);
  const mode_t mode = (flags & O_CREAT) != 0 ? va_arg(arguments, mode_t) : 0;
  va_end(arguments);
  if (std::strcmp(path, lcmslam::testing::FakeV4l2::name) != 0)
    return real<int (*)(const char*, int, ...)>("open")(path, flags, mode);
  if (!fake_v4l2().plugged) return fail(ENOENT);
  const std::size_t bytes = lcmslam::testing::buffers * lcmslam::testing::buffer_size;
  const int file = memfd_create("camera", 0);
  if (file < 0 || ftruncate(file, static_cast<off_t>(bytes)) != 0) return -1;
  lcmslam::testing::memory =
      static_cast<char*>(mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, file, 0));
  lcmslam::testing::streaming = false;
  ++fake_v4l2().opened;
  handle = file;
  return file;
}

int close(int file) {
  if (file >= 0 && file == handle) {
    handle = -1;
    ++fake_v4l2().closed;
    munmap(lcmslam::testing::memory, lcmslam::testing::buffers * lcmslam::testing::buffer_size);
  }
  return real<int (*)(int)>("close")(file);
}

int ioctl(int file, unsigned long request, ...) noexcept {
  va_list arguments;
  va_start(arguments, request);
  void* argument = va_arg(arguments, void*);
  va_end(arguments);
  if (file >= 0 && file == handle) return answer(request, argument);
  return real<int (*)(int, unsigned long, ...)>("ioctl")(file, request, argument);
}

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"  // glibc declares that poll() only writes
int poll(pollfd* files, nfds_t count, int timeout) {
  if (count != 1 || files[0].fd < 0 || files[0].fd != handle)
    return real<int (*)(pollfd*, nfds_t, int)>("poll")(files, count, timeout);
  files[0].revents = wait_for_image(timeout * 1000LL);
  return files[0].revents != 0 ? 1 : 0;
}
#pragma GCC diagnostic pop

int clock_gettime(clockid_t clock, timespec* time) noexcept {
  static const auto real_one = real<int (*)(clockid_t, timespec*)>("clock_gettime");
  const int status = real_one(clock, time);
  if (clock != CLOCK_REALTIME || wall_clock_set == 0) return status;
  const std::int64_t nanoseconds = time->tv_sec * 1'000'000'000LL + time->tv_nsec + 1000 * wall_clock_set;
  *time = {nanoseconds / 1'000'000'000, nanoseconds % 1'000'000'000};
  return status;
}

int select(int count, fd_set* read, fd_set* write, fd_set* except, timeval* timeout) {
  const int camera = handle;
  if (camera < 0 || read == nullptr || count != camera + 1 || !FD_ISSET(camera, read))
    return real<int (*)(int, fd_set*, fd_set*, fd_set*, timeval*)>("select")(count, read, write, except,
                                                                             timeout);
  return wait_for_image(timeout->tv_sec * 1'000'000LL + timeout->tv_usec) != 0 ? 1 : 0;
}

}  // extern "C"
