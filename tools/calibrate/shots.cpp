#include "tools/calibrate/shots.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <iostream>
#include <opencv2/imgcodecs.hpp>
#include <set>
#include <stdexcept>

#include <lcmslam/imaging/io/codec.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include <lcmslam/runtime/options.hpp>
#include <lcmslam/runtime/stop_signal.hpp>
#include "tools/above_zero.hpp"
#include "tools/log/message_reader.hpp"
#include "tools/output_file.hpp"
#include "tools/spy/bus_listener.hpp"

namespace lcmslam {
namespace fs = std::filesystem;
namespace {

using ShotHandler = std::function<bool(const Shot&)>;

std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file()) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// Counts of a sensor as 8 bits: few use a good part of 16, so what 1 % and 99 % of the pixels do not reach
/// is black and white.
cv::Mat stretched(const cv::Mat& counts) {
  cv::Mat values;
  counts.convertTo(values, CV_32F);
  cv::patchNaNs(values, 0);
  std::vector<float> sorted(values.begin<float>(), values.end<float>());
  std::sort(sorted.begin(), sorted.end());
  const std::size_t margin = sorted.size() / 100;
  const double black = sorted[margin], white = sorted[sorted.size() - 1 - margin];
  const double scale = white > black ? 255 / (white - black) : 0;
  cv::Mat grey;
  values.convertTo(grey, CV_8U, scale, -scale * black);
  return grey;
}

/// OpenCV alone would divide 16 bits by 256, which leaves little of an infrared image.
cv::Mat load_grey(const fs::path& file) {
  const cv::Mat image = cv::imread(file.string(), cv::IMREAD_ANYDEPTH | cv::IMREAD_GRAYSCALE);
  return image.empty() || image.depth() == CV_8U ? image : stretched(image);
}

cv::Mat load_depth(const fs::path& file) {
  return cv::imread(file.string(), cv::IMREAD_UNCHANGED);
}

/// The file of the same name, whatever its extension.
cv::Mat load_beside(const fs::path& folder, const fs::path& name, cv::Mat (*load)(const fs::path&)) {
  if (!fs::is_directory(folder)) return {};
  for (const fs::path& file : files_of(folder))
    if (file.stem() == name.stem()) return load(file);
  return {};
}

void read_folder(const fs::path& folder, const ShotHandler& use) {
  const bool several = fs::is_directory(folder / "colour") || fs::is_directory(folder / "amplitude");
  const fs::path first = !several                              ? folder
                         : fs::is_directory(folder / "colour") ? folder / "colour"
                                                               : folder / "amplitude";
  int images = 0;
  for (const fs::path& file : files_of(first)) {
    throw_when_stopped();
    Shot shot;
    shot.name = file.filename();
    if (several) {
      shot.colour = load_beside(folder / "colour", file, load_grey);
      shot.amplitude = load_beside(folder / "amplitude", file, load_grey);
      shot.depth = load_beside(folder / "depth", file, load_depth);
    } else {
      shot.colour = load_grey(file);
    }
    if (shot.colour.empty() && shot.amplitude.empty()) continue;
    ++images;
    if (!use(shot)) return;
  }
  if (images == 0) throw std::runtime_error(folder.string() + ": no file in it is an image");
}

/// CAMERA and CAMERA_CALIBRATION, from wherever they come.
class MessageShots {
 public:
  MessageShots(double every, const ShotHandler& use) : period_(static_cast<Utime>(1e6 * every)), use_(use) {}

  /// False: enough. Throws what the handler throws.
  bool take(std::string_view channel, const std::uint8_t* data, std::size_t size) {
    std::optional<Shot> shot;
    try {
      if (channel == "CAMERA_CALIBRATION" && !calibration)
        calibration = from_message(decode_message<camera_calibration_t>(data, size));
      if (channel == "CAMERA") shot = decoded(decode_message<images_t>(data, size));
    } catch (const std::runtime_error& error) {
      if (damaged++ == 0) first_damage = error.what();  // what cannot be read is no view
    }
    if (!shot) return true;
    ++images;
    return use_(*shot);
  }

  std::optional<RgbdCalibration> calibration;
  /// ": 3 damaged, the first: ..." or nothing.
  std::string damage() const {
    return damaged == 0 ? "" : fmt::format(": {} damaged, the first: {}", damaged, first_damage);
  }

  int images = 0, damaged = 0;
  std::string first_damage;

 private:
  /// Nothing where the one before it was taken a moment ago.
  std::optional<Shot> decoded(const images_t& message) {
    if (message.utime < next_ && message.utime > next_ - 10 * period_) return std::nullopt;
    next_ = message.utime + period_;
    const EncodedFrame encoded = from_message(message);
    Shot shot;
    shot.name = "image " + std::to_string(encoded.seq);
    shot.colour = decode_gray(encoded.colour);
    if (encoded.amplitude.coding != ImageCoding::none) shot.amplitude = decode_gray(encoded.amplitude);
    shot.depth = decode_depth(encoded.depth);
    return shot;
  }

  Utime period_, next_ = 0;
  const ShotHandler& use_;
};

std::optional<RgbdCalibration> read_log(const ShotInput& input, const ShotHandler& use) {
  MessageShots shots(input.every, use);
  MessageReader reader(input.path);
  while (const auto event = reader.next()) {
    throw_when_stopped();
    if (!shots.take(event->channel, event->data, event->size)) break;
  }
  if (shots.images == 0)
    throw std::runtime_error(input.path + ": no image of CAMERA in it can be read" + shots.damage());
  return shots.calibration;
}

std::optional<RgbdCalibration> listen(const ShotInput& input, const ShotHandler& use) {
  MessageShots shots(input.every, use);
  PartJoiner joiner;
  bool enough = false;
  const std::string url = input.lcm_url.empty() ? lcm_url_from_environment() : input.lcm_url;
  BusListener listener(url, "CAMERA(_CALIBRATION|_PART)?",
                       [&](const std::string& channel, const std::uint8_t* data, std::size_t size) {
                         if (enough) return;
                         const LogEventView event{0, 0, channel, data, size, 0, 0};
                         if (!PartJoiner::is_piece(event)) {
                           enough = !shots.take(channel, data, size);
                         } else if (const auto whole = joiner.add(event)) {
                           enough = !shots.take(whole->channel, whole->data.data(), whole->data.size());
                         }
                       });
  const auto start = std::chrono::steady_clock::now();
  listener.run([&] {
    const std::chrono::duration<double> time = std::chrono::steady_clock::now() - start;
    return enough || stop_requested() || (input.seconds > 0 && time.count() > input.seconds);
  });
  if (shots.images == 0)
    throw std::runtime_error(shots.damaged == 0 ? "no image came on CAMERA: is a camera running?"
                                                : "no image of CAMERA can be read" + shots.damage());
  return shots.calibration;
}

}  // namespace

void ShotInput::add_to(CLI::App& app) {
  auto* source = app.add_option("input", path, "a folder of images, or an .lcmlog")->check(CLI::ExistingPath);
  app.add_flag(
         "--live", live,
         "instead of that: what comes on CAMERA, until Ctrl-C (camera and tof: until the views are enough)")
      ->excludes(source);
  app.add_option("--seconds", seconds, "with --live: end after this time")->check(above_zero());
  app.add_option("--every", every, "s between images of a log or the bus (0.25)")->check(above_zero());
  app.add_option("--lcm-url", lcm_url, "LCM provider; default LCM_DEFAULT_URL");
}

bool ShotInput::is_sequence() const {
  return live || !fs::is_directory(path);
}

void OneCamera::check(const std::string& name, const cv::Size& size) {
  if (size_.empty()) size_ = size;
  if (size == size_) return;
  throw std::runtime_error(fmt::format("{} is {}x{}, the images before it are {}x{}: one camera at a time",
                                       name, size.width, size.height, size_.width, size_.height));
}

void tell_views(std::size_t views) {
  std::cout << fmt::format("{} view{}\n", views, views == 1 ? "" : "s") << std::flush;
}

std::optional<RgbdCalibration> read_shots(const ShotInput& input,
                                          const std::function<bool(const Shot&)>& use) {
  if (input.live) return listen(input, use);
  if (input.path.empty())
    throw std::runtime_error("give a folder of images, an .lcmlog, or --live for the running camera");
  if (!fs::is_directory(input.path)) return read_log(input, use);
  read_folder(input.path, use);
  return std::nullopt;
}

}  // namespace lcmslam
