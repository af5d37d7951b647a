#include "tools/echo/csv_table.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <stdexcept>

#include <lcmslam/messages/print_message.hpp>

namespace lcmslam {
namespace {

std::string in_quotes(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + "\"";
}

/// Numbers exactly, as few digits as that takes.
std::string cell(const MessageValue& value) {
  switch (value.kind) {
    case MessageValue::Kind::real32:
      return fmt::format("{}", static_cast<float>(value.real));
    case MessageValue::Kind::real64:
      return fmt::format("{}", value.real);
    case MessageValue::Kind::text:
      return in_quotes(value.text);
    default:
      return std::to_string(value.integer);
  }
}

struct Row {
  std::string names, cells;

  void add(const std::string& name, const MessageValue& value) {
    names += "," + in_quotes(name);
    cells += "," + cell(value);
  }
  void add_record(const MessageType& type, const MessageValue& record, const std::string& prefix) {
    for (std::size_t i = 0; i < type.fields.size(); ++i) {
      const MessageField& field = type.fields[i];
      const bool varies = std::any_of(field.dimensions.begin(), field.dimensions.end(),
                                      [](const auto& d) { return d.length_field >= 0; });
      if (!varies) add_value(field, record.items[i], prefix + field.name);
    }
  }
  void add_value(const MessageField& field, const MessageValue& value, const std::string& name) {
    if (value.kind == MessageValue::Kind::bytes) return;
    if (value.kind == MessageValue::Kind::record) return add_record(*field.nested, value, name + ".");
    if (value.kind != MessageValue::Kind::array) return add(name, value);
    for (std::size_t i = 0; i < value.items.size(); ++i)
      add_value(field, value.items[i], fmt::format("{}[{}]", name, i));
  }
};

}  // namespace

std::string CsvTable::row(const std::string& channel, const MessageType* type, const std::uint8_t* data,
                          std::size_t size) {
  const std::string where = "channel " + printable(channel);
  if (type == nullptr)
    throw std::runtime_error("--csv: " + where + " carries an unknown type; --definitions makes it known");
  if (type_ != nullptr && type != type_)
    throw std::runtime_error("--csv: a table has rows of one type; " + where + " carries " +
                             display_name(*type) + ", those before " + display_name(*type_) +
                             ": ask for channels of one type");
  Row row;
  row.names = "channel";
  row.cells = in_quotes(channel);
  try {
    row.add_record(*type, read_message(*type, data, size, MessageLimits::none()), "");
  } catch (const DecodeError& error) {
    throw std::runtime_error("--csv: " + where + ": a message does not decode: " + printable(error.what()));
  }
  const bool first = type_ == nullptr;
  type_ = type;
  return (first ? row.names + "\n" : "") + row.cells + "\n";
}

}  // namespace lcmslam
