#include <lcmslam/messages/schema.hpp>

#include <lcmslam/messages/wire_reader.hpp>

namespace lcmslam {
namespace {

constexpr int max_depth = 16;

using Kind = MessageField::Kind;

std::size_t element_size(const MessageField& field) {
  return field.kind == Kind::nested ? field.nested->fixed_size : value_size(field.kind);
}

class LayoutWalker {
 public:
  explicit LayoutWalker(WireReader& reader) : reader_(reader) {}

  /// The first `members` of it.
  void walk(const MessageType& type, std::size_t members, int depth) {
    if (depth > max_depth) throw DecodeError(type.name + ": nested too deeply");
    std::vector<std::int64_t> lengths(members, 0);
    for (std::size_t i = 0; i < members; ++i) {
      const MessageField& field = type.fields[i];
      if (field.dimensions.empty() && is_integer(field.kind))
        lengths[i] = reader_.integer(value_size(field.kind), field.name);
      else
        walk_array(field, 0, lengths, depth);
    }
  }

 private:
  void walk_array(const MessageField& field, std::size_t dimension, const std::vector<std::int64_t>& lengths,
                  int depth) {
    if (dimension == field.dimensions.size()) return walk_value(field, depth);
    const auto& d = field.dimensions[dimension];
    const std::int64_t n = d.length_field < 0 ? static_cast<std::int64_t>(d.fixed)
                                              : lengths[static_cast<std::size_t>(d.length_field)];
    if (n < 0) throw DecodeError(field.name + ": length " + std::to_string(n) + " is negative");
    // Every element takes at least one byte: a length beyond the rest of the message is a lie.
    if (static_cast<std::uint64_t>(n) > reader_.left())
      throw DecodeError(field.name + ": length " + std::to_string(n) + " exceeds the message");
    const bool last = dimension + 1 == field.dimensions.size();
    if (const std::size_t size = element_size(field); last && size > 0)
      return reader_.skip(static_cast<std::size_t>(n), size, field.name);
    for (std::int64_t k = 0; k < n; ++k) walk_array(field, dimension + 1, lengths, depth);
  }

  void walk_value(const MessageField& field, int depth) {
    if (field.kind == Kind::text)
      reader_.text(field.name);
    else if (field.kind == Kind::nested)
      walk(*field.nested, field.nested->fields.size(), depth + 1);
    else
      reader_.skip(1, value_size(field.kind), field.name);
  }

  WireReader& reader_;
};

/// A type's fingerprint from before members were renamed or appended: old logs have it. It had the first
/// `members` of today's, under other names perhaps; those after it are numbers and arrays, and 0 means what
/// their absence did.
struct FormerFingerprint {
  std::uint64_t fingerprint;
  const char* type;
  std::size_t members;
};
constexpr FormerFingerprint former_fingerprints[] = {
    {0x440ef967ce91c74a, "graph_t", 9},  // its edges' members were keywords of languages that lcm-gen writes
    {0x3e49193e24115fdc, "graph_t", 9},  // each message was the whole graph
};

const FormerFingerprint* former(std::uint64_t fingerprint, const MessageType& type) {
  for (const FormerFingerprint& known : former_fingerprints)
    if (fingerprint == known.fingerprint && type.package == "lcmslam" && type.name == known.type)
      return &known;
  return nullptr;
}

std::uint64_t fingerprint_of(WireReader& reader) {
  return static_cast<std::uint64_t>(reader.integer(8, "fingerprint"));
}

template <class Predicate>
const MessageType* find_if(Predicate predicate) {
  for (const auto* types : {&MessageType::all(), &MessageType::foreign()})
    for (const MessageType* type : *types)
      if (predicate(*type)) return type;
  return nullptr;
}

}  // namespace

const std::vector<const MessageType*>& MessageType::all() {
  static const std::vector<const MessageType*> types = parse_definitions({
#include "lcm_definitions.inc"
  });
  return types;
}

const std::vector<const MessageType*>& MessageType::foreign() {
  all();  // the parser's storage takes one at a time
  static const std::vector<const MessageType*> types = parse_definitions({
#include "lcm_foreign_definitions.inc"
  });
  return types;
}

const MessageType* MessageType::find(const std::string& name) {
  return find_if([&](const MessageType& type) { return type.name == name; });
}

const MessageType* MessageType::find(std::uint64_t fingerprint) {
  return find_if([&](const MessageType& type) {
    return fingerprint == type.fingerprint || former(fingerprint, type) != nullptr;
  });
}

void check_layout(const MessageType& type, const std::uint8_t* data, std::size_t size) {
  WireReader reader(data, size);
  const std::uint64_t fingerprint = fingerprint_of(reader);
  const FormerFingerprint* old = former(fingerprint, type);
  if (fingerprint != type.fingerprint && old == nullptr) {
    const MessageType* other = MessageType::find(fingerprint);
    throw DecodeError("is not a " + type.name + (other ? " but a " + other->name : ": unknown fingerprint"));
  }
  LayoutWalker(reader).walk(type, old != nullptr ? old->members : type.fields.size(), 0);
  if (reader.left() > 0)
    throw DecodeError(type.name + ": " + std::to_string(reader.left()) + " bytes too many");
}

std::optional<std::vector<std::uint8_t>> completed(const MessageType& type, const std::uint8_t* data,
                                                   std::size_t size) {
  WireReader reader(data, size);
  const FormerFingerprint* old = former(fingerprint_of(reader), type);
  if (old == nullptr) return std::nullopt;
  std::size_t zeros = 0;  // of numbers alone: arrays of length 0 have no bytes
  for (std::size_t i = old->members; i < type.fields.size(); ++i)
    if (type.fields[i].dimensions.empty()) zeros += element_size(type.fields[i]);
  std::vector<std::uint8_t> bytes(data, data + size);
  bytes.resize(size + zeros, 0);
  for (std::size_t i = 0; i < 8; ++i) bytes[i] = static_cast<std::uint8_t>(type.fingerprint >> (56 - 8 * i));
  return bytes;
}

}  // namespace lcmslam
