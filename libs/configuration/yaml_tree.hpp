#pragma once
// The YAML file as an immutable tree in which every value knows the file and line it stands in.
// Internal to lcmslam_configuration.
//
// Built from yaml-cpp's events and not from its nodes, because nodes drop what a strict reader needs:
// whether a scalar was quoted, that a key stood there twice, how large an alias grows.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace lcmslam {

/// Where something stands, for messages. Line 0: the whole of it.
struct YamlPlace {
  std::shared_ptr<const std::string> file;
  int line = 0;
  std::string text() const;  ///< "file:line"
};

struct YamlValue;
using YamlPointer = std::shared_ptr<const YamlValue>;

struct YamlEntry {
  std::string key;
  YamlPlace place;  ///< of the key
  YamlPointer value;
};

struct YamlValue {
  enum class Kind { null, scalar, sequence, mapping };
  Kind kind = Kind::null;
  YamlPlace place;
  std::string text;                ///< of a scalar
  bool quoted = false;             ///< a quoted scalar is text, never a number
  std::vector<YamlPointer> items;  ///< of a sequence
  std::vector<YamlEntry> entries;  ///< of a mapping, keys unique, in the file's order
  std::size_t size = 1;            ///< values below, aliases counted each time
  int depth = 1;                   ///< levels below, aliases included

  const YamlEntry* find(const std::string& key) const;
  /// The value as a short phrase for messages: 'many', a list, a mapping, nothing.
  std::string phrase() const;
};

/// Reads one YAML document. Throws ConfigError "name:line: ..." for bytes that are no UTF-8, syntax errors,
/// duplicate keys, keys that are no scalars, a second document, and more than 64 levels or 100000 values.
YamlPointer parse_yaml(const std::string& text, const std::string& name);

/// Parses a whole file and merges the files named by its top-level key `include` under it. The
/// result is a mapping.
YamlPointer load_yaml(const std::filesystem::path& file);

/// The same for text that is already here; `include` is relative to the folder of `name`.
YamlPointer load_yaml_text(const std::string& text, const std::string& name);

}  // namespace lcmslam
