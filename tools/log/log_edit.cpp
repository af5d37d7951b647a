#include "tools/log/log_edit.hpp"

#include <filesystem>
#include <stdexcept>

#include <lcmslam/log/log_writer.hpp>
#include <lcmslam/messages/camera_messages.hpp>
#include <lcmslam/messages/decode.hpp>
#include "tools/log/message_facts.hpp"
#include "tools/log/message_reader.hpp"
#include "tools/output_file.hpp"

namespace lcmslam {
namespace {

const std::string calibration_channel = "CAMERA_CALIBRATION";

void check_output(const std::string& input, const LogOutput& output) {
  std::error_code ignored;
  if (std::filesystem::equivalent(input, output.file, ignored))
    throw std::runtime_error(output.file + ": is the input; name another file");
  check_output_file(output.file, output.overwrite);
}

LogEdit close(const MessageReader& reader, LogWriter& writer, const std::string& nothing) {
  if (writer.events() == 0) throw std::runtime_error(nothing);
  writer.close();
  return {reader.read(), writer.events(), reader.joined(), reader.incomplete(), reader.damages()};
}

std::string joined(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

bool is_images(const LogEventView& event) {
  const MessageType* type = message_type(event.data, event.size);
  return type != nullptr && type->name == "images_t";
}

/// Writes the calibration before the images that want one, and looks whether they fit it.
class Calibrator {
 public:
  explicit Calibrator(const RgbdCalibration& calibration)
      : calibration_(calibration), message_(to_message(calibration)) {
    message_.seq = 0;
    message_.sender = 1;  // as of imported recordings
  }

  void before_images(const LogEventView& event, LogWriter& writer) {
    try {
      const auto images = decode_message<images_t>(event.data, event.size);
      message_.utime = images.utime;
      if (!fits_) checked_images(images, calibration_);
      fits_ = true;
    } catch (const DecodeError& error) {
      misfit_ = error.what();
    }
    const Utime since = last_ ? time_between(*last_, event.timestamp) : period;
    if (since >= 0 && since < period) return;  // earlier than the last: another session
    writer.write(event.timestamp, calibration_channel, encode_message(message_));
    ++message_.seq;
    last_ = event.timestamp;
  }

  bool fits() const { return fits_; }
  const std::string& misfit() const { return misfit_; }

 private:
  static constexpr Utime period = 1'000'000;  // us

  RgbdCalibration calibration_;
  camera_calibration_t message_;
  std::optional<Utime> last_;
  bool fits_ = false;
  std::string misfit_;
};

}  // namespace

LogEdit repair_log(const std::string& input, const LogOutput& output) {
  check_output(input, output);
  MessageReader reader(input);
  LogWriter writer(output.file);
  while (const auto event = reader.next()) {
    throw_when_stopped();
    writer.write(event->timestamp, event->channel, event->data, event->size);
  }
  return close(reader, writer, input + ": no event in it is whole");
}

LogEdit cut_log(const std::string& input, const LogOutput& output, const LogSelection& selection,
                const std::string& robot) {
  selection.check();
  check_output(input, output);
  const LogContents contents = scan_log(input, robot);
  selection.check_channels(contents.channels, input);
  MessageReader reader(input, robot);
  LogWriter writer(output.file);
  std::optional<LogEvent> calibration;
  while (const auto event = reader.next()) {
    throw_when_stopped();
    if (!selection.has_channel(std::string(event->channel))) continue;
    if (selection.has_time(event->timestamp, contents.first)) {
      if (calibration && writer.events() == 0)
        writer.write(event->timestamp, calibration_channel, calibration->data);
      writer.write(event->timestamp, event->channel, event->data, event->size);
    } else if (event->channel == calibration_channel &&
               selection.is_before(event->timestamp, contents.first)) {
      calibration = event->copy();
    }
  }
  return close(reader, writer, input + ": no event lies within the times and channels asked for");
}

LogEdit calibrate_log(const std::string& input, const LogOutput& output, const RgbdCalibration& calibration) {
  check_output(input, output);
  MessageReader reader(input);
  LogWriter writer(output.file);
  Calibrator calibrator(calibration);
  while (const auto event = reader.next()) {
    throw_when_stopped();
    if (event->channel == calibration_channel) continue;
    if (is_images(*event)) calibrator.before_images(*event, writer);
    writer.write(event->timestamp, event->channel, event->data, event->size);
  }
  if (!calibrator.fits() && calibrator.misfit().empty())
    throw std::runtime_error(input + ": has no images (images_t), so there is nothing to calibrate; it has " +
                             joined(scan_log(input).channels));
  if (!calibrator.fits())
    throw std::runtime_error(input +
                             ": no images fit the calibration, the last because: " + calibrator.misfit());
  return close(reader, writer, input + ": no event in it is whole");
}

}  // namespace lcmslam
