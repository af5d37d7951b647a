// Parser for LCM's type definitions, and LCM's fingerprint of a type.

#include <cctype>
#include <map>
#include <memory>
#include <set>

#include <lcmslam/messages/schema.hpp>

namespace lcmslam {
namespace {

using Kind = MessageField::Kind;

const std::map<std::string, Kind>& primitives() {
  static const std::map<std::string, Kind> kinds = {
      {"int8_t", Kind::int8},   {"int16_t", Kind::int16},   {"int32_t", Kind::int32},
      {"int64_t", Kind::int64}, {"float", Kind::float32},   {"double", Kind::float64},
      {"string", Kind::text},   {"boolean", Kind::boolean}, {"byte", Kind::byte}};
  return kinds;
}

/// Words, numbers and single signs; comments are left out.
std::vector<std::string> tokenize(const std::string& text) {
  std::vector<std::string> tokens;
  const auto in_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '.' || c == '-' || c == '+';
  };
  for (std::size_t i = 0; i < text.size();) {
    if (std::isspace(static_cast<unsigned char>(text[i]))) {
      ++i;
    } else if (text.compare(i, 2, "//") == 0) {
      i = std::min(text.find('\n', i), text.size());
    } else if (text.compare(i, 2, "/*") == 0) {
      i = text.find("*/", i + 2);
      if (i == std::string::npos) throw std::invalid_argument("a comment is not closed");
      i += 2;
    } else if (in_word(text[i])) {
      const std::size_t start = i;
      while (i < text.size() && in_word(text[i])) ++i;
      tokens.push_back(text.substr(start, i - start));
    } else {
      tokens.emplace_back(1, text[i++]);
    }
  }
  return tokens;
}

class Parser {
 public:
  explicit Parser(const std::string& text) : tokens_(tokenize(text)) {}

  void parse(std::vector<std::unique_ptr<MessageType>>& types) {
    std::string package;
    while (at_ < tokens_.size()) {
      const std::string word = next();
      if (word == "package") {
        package = next();
        expect(";");
      } else if (word == "struct") {
        types.push_back(parse_struct());
        types.back()->package = package;
      } else {
        throw std::invalid_argument("expected 'package' or 'struct', got '" + word + "'");
      }
    }
  }

 private:
  std::string next() {
    if (at_ == tokens_.size()) throw std::invalid_argument("definition ends early");
    return tokens_[at_++];
  }
  bool accept(const std::string& token) {
    if (at_ == tokens_.size() || tokens_[at_] != token) return false;
    ++at_;
    return true;
  }
  void expect(const std::string& token) {
    if (const std::string word = next(); word != token)
      throw std::invalid_argument("expected '" + token + "', got '" + word + "'");
  }

  std::unique_ptr<MessageType> parse_struct() {
    auto type = std::make_unique<MessageType>();
    type->name = next();
    expect("{");
    while (!accept("}")) {
      const std::string word = next();
      if (word == "const") {
        while (next() != ";") {
        }
        continue;
      }
      do {
        type->fields.push_back(parse_field(word, *type));
      } while (accept(","));
      expect(";");
    }
    return type;
  }

  MessageField parse_field(const std::string& type_name, const MessageType& type) {
    MessageField field;
    field.type_name = type_name;
    field.name = next();
    const auto primitive = primitives().find(type_name);
    field.kind = primitive == primitives().end() ? Kind::nested : primitive->second;
    while (accept("[")) {
      MessageField::Dimension dimension;
      dimension.written = next();
      if (std::isdigit(static_cast<unsigned char>(dimension.written[0])))
        dimension.fixed = fixed_length(field.name, dimension.written);
      else
        dimension.length_field = index_of(dimension.written, type);
      field.dimensions.push_back(dimension);
      expect("]");
    }
    return field;
  }

  static std::size_t fixed_length(const std::string& field, const std::string& written) {
    const bool digits = written.size() <= 9 && written.find_first_not_of("0123456789") == std::string::npos;
    const std::size_t length = digits ? std::stoul(written) : 0;
    if (length == 0)
      throw std::invalid_argument(field + ": array length '" + written + "' is no positive number");
    return length;
  }

  static int index_of(const std::string& name, const MessageType& type) {
    for (std::size_t i = 0; i < type.fields.size(); ++i) {
      const MessageField& field = type.fields[i];
      if (field.name != name) continue;
      if (!is_integer(field.kind) || !field.dimensions.empty())
        throw std::invalid_argument(type.name + ": array length '" + name + "' is no integer");
      return static_cast<int>(i);
    }
    throw std::invalid_argument(type.name + ": array length '" + name + "' is not a member before it");
  }

  std::vector<std::string> tokens_;
  std::size_t at_ = 0;
};

// LCM's hash: over member names, primitive type names and dimensions, not the type's own name.
class Fingerprint {
 public:
  static std::uint64_t of(const MessageType& type) { return of(type, {}); }

 private:
  static std::uint64_t of(const MessageType& type, std::set<const MessageType*> parents) {
    if (!parents.insert(&type).second) return 0;
    std::int64_t v = 0x12345678;
    std::uint64_t nested = 0;
    for (const MessageField& field : type.fields) {
      update(v, field.name);
      if (field.kind != Kind::nested) update(v, field.type_name);
      update(v, static_cast<char>(field.dimensions.size()));
      for (const auto& d : field.dimensions) {
        update(v, static_cast<char>(d.length_field >= 0));
        update(v, d.written);
      }
      if (field.kind == Kind::nested) nested += of(*field.nested, parents);
    }
    const std::uint64_t sum = static_cast<std::uint64_t>(v) + nested;
    return (sum << 1) + ((sum >> 63) & 1);
  }
  static void update(std::int64_t& v, char c) {
    const auto shifted = static_cast<std::uint64_t>(v) << 8;
    v = static_cast<std::int64_t>((shifted ^ static_cast<std::uint64_t>(v >> 55)) +
                                  static_cast<std::uint64_t>(static_cast<std::int64_t>(c)));
  }
  static void update(std::int64_t& v, const std::string& text) {
    update(v, static_cast<char>(text.size()));
    for (const char c : text) update(v, c);
  }
};

/// 0 when the size varies, which it does where a type contains itself.
std::size_t fixed_size(const MessageType& type, std::set<const MessageType*> parents = {}) {
  if (!parents.insert(&type).second) return 0;
  std::size_t total = 0;
  for (const MessageField& field : type.fields) {
    std::size_t size =
        field.kind == Kind::nested ? fixed_size(*field.nested, parents) : value_size(field.kind);
    if (size == 0) return 0;
    for (const auto& d : field.dimensions) {
      if (d.length_field >= 0) return 0;
      size *= d.fixed;
    }
    total += size;
  }
  return total;
}

using TypesByName = std::map<std::string, const MessageType*>;

std::string full_name(const std::string& package, const std::string& name) {
  return package.empty() ? name : package + "." + name;
}

/// Packages may have types of one name: that of the own package or as it is written, else the only one whose
/// name without package it is; nullptr when there is none.
const MessageType* find_type(const TypesByName& types, const std::string& package,
                             const std::string& written) {
  for (const std::string& name : {full_name(package, written), written})
    if (const auto found = types.find(name); found != types.end()) return found->second;
  const std::string plain = written.substr(written.rfind('.') + 1);
  const MessageType* only = nullptr;
  for (const auto& [name, type] : types) {
    if (type->name != plain) continue;
    if (only != nullptr) throw std::invalid_argument(written + ": several packages have such a type");
    only = type;
  }
  return only;
}

}  // namespace

bool is_integer(Kind kind) {
  return kind == Kind::int8 || kind == Kind::int16 || kind == Kind::int32 || kind == Kind::int64;
}

std::size_t value_size(MessageField::Kind kind) {
  switch (kind) {
    case Kind::int8:
    case Kind::boolean:
    case Kind::byte:
      return 1;
    case Kind::int16:
      return 2;
    case Kind::int32:
    case Kind::float32:
      return 4;
    case Kind::int64:
    case Kind::float64:
      return 8;
    case Kind::text:
    case Kind::nested:
      return 0;
  }
  return 0;
}

std::vector<const MessageType*> parse_definitions(const std::vector<std::string>& texts) {
  // Types live as long as the program: messages are checked until its end.
  static std::vector<std::unique_ptr<MessageType>> storage;
  std::vector<std::unique_ptr<MessageType>> types;
  for (const auto& text : texts) Parser(text).parse(types);

  TypesByName by_name;
  for (const auto& type : types)
    if (!by_name.emplace(full_name(type->package, type->name), type.get()).second)
      throw std::invalid_argument(full_name(type->package, type->name) + " is defined twice");
  for (auto& type : types)
    for (auto& field : type->fields) {
      if (field.kind != Kind::nested) continue;
      field.nested = find_type(by_name, type->package, field.type_name);
      if (field.nested == nullptr)
        throw std::invalid_argument(type->name + ": unknown type " + field.type_name);
    }

  std::vector<const MessageType*> result;
  for (auto& type : types) {
    type->fingerprint = Fingerprint::of(*type);
    type->fixed_size = fixed_size(*type);
    result.push_back(type.get());
    storage.push_back(std::move(type));
  }
  return result;
}

}  // namespace lcmslam
