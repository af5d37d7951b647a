#include <lcmslam/messages/message_value.hpp>

#include <algorithm>
#include <limits>
#include <optional>

#include <lcmslam/messages/wire_reader.hpp>

namespace lcmslam {
namespace {

using FieldKind = MessageField::Kind;
using Kind = MessageValue::Kind;

/// Reads what check_layout has found sound: lengths are within the message and not negative.
class ValueReader {
 public:
  ValueReader(WireReader& reader, const MessageLimits& limits) : reader_(reader), limits_(limits) {}

  /// What is not kept is read all the same: it must be stepped over.
  MessageValue record(const MessageType& type, bool keep = true) {
    MessageValue value;
    value.type_name = type.name;
    std::vector<std::size_t> lengths(type.fields.size(), 0);
    for (std::size_t i = 0; i < type.fields.size(); ++i) {
      const MessageField& field = type.fields[i];
      MessageValue member = array(field, 0, lengths, keep);
      if (field.dimensions.empty() && is_integer(field.kind))
        lengths[i] = static_cast<std::size_t>(member.integer);
      if (!keep) continue;
      member.name = field.name;
      value.items.push_back(std::move(member));
    }
    return value;
  }

 private:
  MessageValue array(const MessageField& field, std::size_t dimension,
                     const std::vector<std::size_t>& lengths, bool keep) {
    if (dimension == field.dimensions.size()) return single(field, keep);
    const auto& d = field.dimensions[dimension];
    const std::size_t n = d.length_field < 0 ? d.fixed : lengths[static_cast<std::size_t>(d.length_field)];
    const bool last = dimension + 1 == field.dimensions.size();
    MessageValue value;
    value.type_name = field.type_name;
    value.length = n;
    if (last && field.kind == FieldKind::byte) {
      value.kind = Kind::bytes;
      value.text = reader_.bytes(keep ? std::min(n, limits_.bytes) : 0, field.name);
      reader_.skip(n - value.text.size(), 1, field.name);
      return value;
    }
    value.kind = Kind::array;
    const bool flat = last && field.kind != FieldKind::nested;
    const std::size_t kept = keep ? std::min(n, flat ? limits_.elements : limits_.records) : 0;
    for (std::size_t k = 0; k < kept; ++k) value.items.push_back(array(field, dimension + 1, lengths, true));
    const std::size_t size = last ? wire_size(field) : 0;
    if (size > 0)
      reader_.skip(n - kept, size, field.name);
    else
      for (std::size_t k = kept; k < n; ++k) array(field, dimension + 1, lengths, false);
    return value;
  }

  static std::size_t wire_size(const MessageField& field) {
    return field.kind == FieldKind::nested ? field.nested->fixed_size : value_size(field.kind);
  }

  MessageValue single(const MessageField& field, bool keep) {
    if (field.kind == FieldKind::nested) return record(*field.nested, keep);
    MessageValue value;
    value.type_name = field.type_name;
    switch (field.kind) {
      case FieldKind::text:
        value.kind = Kind::text;
        value.text = reader_.text(field.name);
        value.length = value.text.size();
        if (value.length > limits_.text) value.text.resize(whole_characters(value.text, limits_.text));
        break;
      case FieldKind::float32:
        value.kind = Kind::real32;
        value.real = reader_.real32(field.name);
        break;
      case FieldKind::float64:
        value.kind = Kind::real64;
        value.real = reader_.real64(field.name);
        break;
      case FieldKind::boolean:
        value.kind = Kind::boolean;
        value.integer = reader_.integer(1, field.name) != 0;
        break;
      case FieldKind::byte:
        value.kind = Kind::integer;
        value.integer = reader_.integer(1, field.name) & 0xff;
        break;
      default:
        value.kind = Kind::integer;
        value.integer = reader_.integer(value_size(field.kind), field.name);
    }
    return value;
  }

  /// At most `size` bytes without a part of an UTF-8 character at the end.
  static std::size_t whole_characters(const std::string& text, std::size_t size) {
    const auto continues = [&](std::size_t i) {
      return (static_cast<unsigned char>(text[i]) & 0xc0) == 0x80;
    };
    std::size_t cut = size;
    while (cut > 0 && size - cut < 3 && continues(cut)) --cut;
    return cut;
  }

  WireReader& reader_;
  const MessageLimits& limits_;
};

/// An integer of image_metadata_t; nothing when it is not of 8 bytes.
std::optional<std::int64_t> metadata_integer(const MessageValue& entry) {
  const MessageValue* value = member(entry, "value");
  if (value == nullptr || value->kind != Kind::bytes || value->text.size() != 8 || value->length != 8)
    return std::nullopt;
  std::uint64_t bits = 0;
  for (std::size_t i = 8; i-- > 0;) bits = bits << 8 | static_cast<unsigned char>(value->text[i]);
  return static_cast<std::int64_t>(bits);
}

Origin metadata_origin(const MessageValue& images) {
  Origin result;
  if (images.items.empty()) return result;
  const MessageValue* metadata = member(images.items.front(), "metadata");
  if (metadata == nullptr) return result;
  for (const MessageValue& entry : metadata->items) {
    const MessageValue* key = member(entry, "key");
    const auto value = metadata_integer(entry);
    if (key == nullptr || !value) continue;
    if (key->text == "seq") result.seq = *value;
    if (key->text == "sender") result.sender = *value;
  }
  return result;
}

}  // namespace

MessageLimits MessageLimits::none() {
  constexpr std::size_t most = std::numeric_limits<std::size_t>::max();
  return {most, most, most, most};
}

MessageValue read_message(const MessageType& type, const std::uint8_t* data, std::size_t size,
                          const MessageLimits& limits) {
  check_layout(type, data, size);
  const auto of_today = completed(type, data, size);
  WireReader reader(of_today ? of_today->data() : data, of_today ? of_today->size() : size);
  reader.integer(8, "fingerprint");
  return ValueReader(reader, limits).record(type);
}

const MessageValue* member(const MessageValue& record, const std::string& name) {
  const auto found = std::find_if(record.items.begin(), record.items.end(),
                                  [&](const MessageValue& item) { return item.name == name; });
  return found == record.items.end() ? nullptr : &*found;
}

Origin origin(const MessageValue& message) {
  const MessageValue* seq = member(message, "seq");
  const MessageValue* sender = member(message, "sender");
  // A number without a sender (pointcloud2_t) cannot tell loss from a second sender.
  if (seq != nullptr && sender != nullptr) return {seq->integer, sender->integer};
  const MessageValue* images = member(message, "images");
  return images == nullptr ? Origin() : metadata_origin(*images);
}

}  // namespace lcmslam
