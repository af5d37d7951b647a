#include "tools/log/log_edit.hpp"

#include <filesystem>
#include <stdexcept>

#include <lcmslam/log/log_writer.hpp>
#include "tools/log/message_reader.hpp"

namespace lcmslam {
namespace {

const std::string calibration_channel = "CAMERA_CALIBRATION";

void check_output(const std::string& input, const LogOutput& output) {
  std::error_code ignored;
  if (!std::filesystem::exists(output.file, ignored)) return;
  if (std::filesystem::equivalent(input, output.file, ignored))
    throw std::runtime_error(output.file + ": is the input; name another file");
  if (!output.overwrite) throw std::runtime_error(output.file + ": exists; --force overwrites it");
  if (!std::filesystem::is_regular_file(output.file, ignored))
    throw std::runtime_error(output.file + ": is no file");
}

LogEdit close(const MessageReader& reader, LogWriter& writer, const std::string& nothing) {
  if (writer.events() == 0) throw std::runtime_error(nothing);
  writer.close();
  return {reader.read(), writer.events(), reader.joined(), reader.incomplete(), reader.damages()};
}

}  // namespace

LogEdit repair_log(const std::string& input, const LogOutput& output) {
  check_output(input, output);
  MessageReader reader(input);
  LogWriter writer(output.file);
  while (const auto event = reader.next())
    writer.write(event->timestamp, event->channel, event->data, event->size);
  return close(reader, writer, input + ": no event in it is whole");
}

LogEdit cut_log(const std::string& input, const LogOutput& output, const LogSelection& selection) {
  selection.check();
  check_output(input, output);
  const LogContents contents = scan_log(input);
  selection.check_channels(contents.channels, input);
  MessageReader reader(input);
  LogWriter writer(output.file);
  std::optional<LogEvent> calibration;
  while (const auto event = reader.next()) {
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

}  // namespace lcmslam
