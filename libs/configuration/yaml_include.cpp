// Files that include files: `include: other.yaml` or a list of them, paths relative to the file that
// includes. Mappings merge key by key; an including file wins over what it includes, a later include
// over an earlier one.

#include <algorithm>
#include <fstream>
#include <iterator>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/configuration/yaml_tree.hpp>

namespace lcmslam {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t max_file_bytes = 4'000'000;
constexpr int max_files = 200;

[[noreturn]] void fail(const YamlPlace& place, const std::string& problem) {
  throw ConfigError(place.text() + ": " + problem);
}

YamlPointer merge(const YamlPointer& base, const YamlPointer& own) {
  if (base->kind != YamlValue::Kind::mapping) return own;
  if (own->kind == YamlValue::Kind::null) return base;  // an empty section says nothing
  if (own->kind != YamlValue::Kind::mapping) return own;
  auto merged = std::make_shared<YamlValue>(*own);
  merged->entries = base->entries;
  for (const YamlEntry& entry : own->entries) {
    const auto found = std::find_if(merged->entries.begin(), merged->entries.end(),
                                    [&](const YamlEntry& e) { return e.key == entry.key; });
    if (found == merged->entries.end())
      merged->entries.push_back(entry);
    else
      *found = {entry.key, entry.place, merge(found->value, entry.value)};
  }
  return merged;
}

std::string read_file(const fs::path& file, const std::string& asked_from) {
  std::error_code error;
  if (!fs::exists(file, error)) throw ConfigError(asked_from + file.string() + ": no such file");
  if (fs::is_directory(file, error))
    throw ConfigError(asked_from + file.string() + ": is a folder, not a YAML file");
  // What is named on the command line may be a pipe; what a file includes could wait for ever.
  if (!asked_from.empty() && !fs::is_regular_file(file, error))
    throw ConfigError(asked_from + file.string() + ": is no ordinary file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw ConfigError(asked_from + file.string() + ": cannot be opened for reading");
  std::string text;
  char block[1 << 14];
  while (stream.read(block, sizeof block) || stream.gcount() > 0) {
    text.append(block, static_cast<std::size_t>(stream.gcount()));
    if (text.size() > max_file_bytes)
      throw ConfigError(asked_from + file.string() + ": larger than " +
                        std::to_string(max_file_bytes / 1'000'000) + " MB, not a configuration");
    if (text.compare(0, 4, "\xED\xA1\xDA\x01") == 0)  // files in the wrong order
      throw ConfigError(asked_from + file.string() + ": is an LCM log, not a configuration (YAML)");
  }
  return text;
}

/// One loading: knows the chain of files that are being read, to see circles.
class Loader {
 public:
  YamlPointer load(const fs::path& file, const std::string& asked_from) {
    std::error_code error;  // names that no file can have, folders that nobody may enter
    const fs::path identity = fs::weakly_canonical(file, error);
    if (error) throw ConfigError(asked_from + file.string() + ": " + error.message());
    if (std::find(chain_.begin(), chain_.end(), identity) != chain_.end())
      throw ConfigError(asked_from + file.string() + ": includes itself in a circle");
    if (++files_ > max_files)
      throw ConfigError(asked_from + file.string() + ": more than " + std::to_string(max_files) +
                        " includes");
    const std::string text = read_file(file, asked_from);
    chain_.push_back(identity);
    YamlPointer result = load_text(text, file.string());
    chain_.pop_back();
    return result;
  }

  YamlPointer load_text(const std::string& text, const std::string& name) {
    YamlPointer own = parse_yaml(text, name);
    if (own->kind == YamlValue::Kind::null) {  // an empty file: nothing set
      auto empty = std::make_shared<YamlValue>(*own);
      empty->kind = YamlValue::Kind::mapping;
      return empty;
    }
    if (own->kind != YamlValue::Kind::mapping)
      fail(own->place, "must be a mapping of keys to values, got " + own->phrase());
    const YamlEntry* include = own->find("include");
    if (!include) return own;

    YamlPointer base;
    for (const YamlPointer& path : included_paths(*include)) {
      const YamlPointer next =
          load(fs::path(name).parent_path() / path->text, include->place.text() + ": includes ");
      base = base ? merge(base, next) : next;
    }
    auto without = std::make_shared<YamlValue>(*own);
    without->entries.erase(without->entries.begin() + (include - own->entries.data()));
    return base ? merge(base, without) : without;
  }

 private:
  static std::vector<YamlPointer> included_paths(const YamlEntry& include) {
    std::vector<YamlPointer> paths = include.value->items;
    if (include.value->kind == YamlValue::Kind::scalar) paths = {include.value};
    const bool list = include.value->kind == YamlValue::Kind::sequence;
    const bool all_text = std::all_of(paths.begin(), paths.end(), [](const YamlPointer& path) {
      return path->kind == YamlValue::Kind::scalar && !path->text.empty();
    });
    if ((paths.empty() && !list) || !all_text)
      fail(include.place, "'include' must be a file name or a list of them, got " + include.value->phrase());
    return paths;
  }

  std::vector<fs::path> chain_;
  int files_ = 0;
};

}  // namespace

YamlPointer load_yaml(const fs::path& file) {
  return Loader().load(file, "");
}

YamlPointer load_yaml_text(const std::string& text, const std::string& name) {
  return Loader().load_text(text, name);
}

}  // namespace lcmslam
