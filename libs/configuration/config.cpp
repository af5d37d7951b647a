#include <lcmslam/configuration/config.hpp>

#include <algorithm>
#include <map>
#include <set>

#include <lcmslam/configuration/scalar.hpp>
#include <lcmslam/configuration/yaml_tree.hpp>

namespace lcmslam {

namespace {

YamlPlace nowhere(const std::string& name) {
  return {std::make_shared<const std::string>(name), 0};
}

const std::string of_command_line = "--set ";

/// Of a path that stands there. Who writes one on a command line means the current folder.
std::filesystem::path folder_of(const YamlPlace& place) {
  if (place.file->compare(0, of_command_line.size(), of_command_line) == 0) return {};
  return std::filesystem::path(*place.file).parent_path();
}

}  // namespace

struct ConfigNode::Data {
  struct Entry {
    std::string key;
    YamlPlace place;
    YamlPointer value;
    std::filesystem::path folder = {};
  };

  std::string path;  ///< dotted name of this mapping, empty at the top
  YamlPlace place;
  std::filesystem::path folder;
  std::vector<Entry> entries;

  std::set<std::string> known;    ///< keys that a reader asked for, there or not
  std::set<std::string> read;     ///< keys that need no complaint
  std::set<std::string> ignored;  ///< keys whose sections need none either
  std::map<std::string, std::vector<std::shared_ptr<Data>>> children;  ///< sections made so far

  Data() : place(nowhere("<defaults>")) {}
  Data(const YamlValue& mapping, std::string dotted)
      : path(std::move(dotted)), place(mapping.place), folder(folder_of(mapping.place)) {
    for (const YamlEntry& entry : mapping.entries)  // what was included keeps the folder of its own file
      entries.push_back({entry.key, entry.place, entry.value, folder_of(entry.place)});
  }

  const Entry* find(const std::string& key) const {
    const auto found =
        std::find_if(entries.begin(), entries.end(), [&](const Entry& e) { return e.key == key; });
    return found == entries.end() ? nullptr : &*found;
  }

  /// The entry that a reader asks for; remembers the question.
  const Entry* ask(const std::string& key) {
    known.insert(key);
    read.insert(key);
    return find(key);
  }

  std::string below(const std::string& key) const { return path.empty() ? key : path + "." + key; }

  std::shared_ptr<Data> empty_section(const std::string& key) const {
    auto section = std::make_shared<Data>();
    section->path = below(key);
    section->place = place;
    section->folder = folder;
    return section;
  }

  /// Section under a key, made once so that all readers share the record.
  std::shared_ptr<Data> child(const std::string& key) {
    std::vector<std::shared_ptr<Data>>& made = children[key];
    if (!made.empty()) return made.front();
    const Entry* entry = find(key);
    if (!entry || entry->value->kind == YamlValue::Kind::null) {
      made.push_back(empty_section(key));
      if (entry) made.front()->place = entry->place;
    } else {
      made.push_back(std::make_shared<Data>(*entry->value, below(key)));
      if (entry->value->kind == YamlValue::Kind::mapping) made.front()->place = entry->place;
    }
    return made.front();
  }

  [[noreturn]] void wrong(const Entry& entry, const YamlValue& value, const std::string& must_be) const {
    const YamlPlace& at = &value == entry.value.get() ? entry.place : value.place;
    throw ConfigError(at.text() + ": '" + entry.key + "' must be " + must_be + ", got " + value.phrase());
  }

  const Entry& require(const std::string& key) {
    if (const Entry* entry = ask(key)) return *entry;
    std::vector<std::string> unread;
    for (const Entry& entry : entries)
      if (!known.count(entry.key)) unread.push_back(entry.key);
    const std::string nearest = nearest_word(key, unread, key.size() / 2);
    throw ConfigError(place.text() + ": required key '" + key + "' is missing" +
                      (path.empty() ? "" : " in '" + path + "'") +
                      (nearest.empty() ? "" : " (is '" + nearest + "' meant to be it?)"));
  }

  std::vector<double> read_numbers(const Entry& entry, const std::string& must_be) const {
    if (entry.value->kind != YamlValue::Kind::sequence) wrong(entry, *entry.value, must_be);
    std::vector<double> numbers;
    for (const YamlPointer& item : entry.value->items) {
      const auto number = read_number(*item, {});
      if (!number) wrong(entry, *item, must_be);
      numbers.push_back(*number);
    }
    return numbers;
  }

  void check_all_read() const {
    for (const Entry& entry : entries) {
      if (!read.count(entry.key)) {
        const std::string nearest = nearest_word(entry.key, {known.begin(), known.end()});
        throw ConfigError(entry.place.text() + ": unknown key '" + entry.key + "'" +
                          (path.empty() ? "" : " in '" + path + "'") +
                          (nearest.empty() ? "" : " (did you mean '" + nearest + "'?)"));
      }
      const auto made = children.find(entry.key);
      if (made == children.end() || ignored.count(entry.key)) continue;
      for (const std::shared_ptr<Data>& section : made->second) section->check_all_read();
    }
  }
};

ConfigNode::ConfigNode() : data_(std::make_shared<Data>()) {}
ConfigNode::ConfigNode(std::shared_ptr<Data> data) : data_(std::move(data)) {}

ConfigNode ConfigNode::load(const std::filesystem::path& file) {
  auto data = std::make_shared<Data>(*load_yaml(file), "");
  data->place = nowhere(file.string());
  data->folder = file.parent_path();
  return ConfigNode(std::move(data));
}

ConfigNode ConfigNode::parse(const std::string& text, const std::string& name) {
  auto data = std::make_shared<Data>(*load_yaml_text(text, name), "");
  data->place = nowhere(name);
  return ConfigNode(std::move(data));
}

bool ConfigNode::has(const std::string& key) const {
  data_->known.insert(key);
  return data_->find(key) != nullptr;
}

std::vector<std::string> ConfigNode::keys() const {
  std::vector<std::string> names;
  for (const Data::Entry& entry : data_->entries) names.push_back(entry.key);
  return names;
}

double ConfigNode::get(const std::string& key, double fallback, Range range) const {
  return data_->ask(key) ? number(key, range) : fallback;
}

int ConfigNode::get(const std::string& key, int fallback, Range range) const {
  const Data::Entry* entry = data_->ask(key);
  if (!entry) return fallback;
  const auto value = read_whole_number(*entry->value, range);
  if (!value) data_->wrong(*entry, *entry->value, range_text("a whole number", range));
  return *value;
}

bool ConfigNode::get(const std::string& key, bool fallback) const {
  const Data::Entry* entry = data_->ask(key);
  if (!entry) return fallback;
  const auto value = read_bool(*entry->value);
  if (!value) data_->wrong(*entry, *entry->value, "true or false");
  return *value;
}

std::string ConfigNode::get(const std::string& key, const std::string& fallback) const {
  return data_->ask(key) ? text(key) : fallback;
}

std::string ConfigNode::get(const std::string& key, const char* fallback) const {
  return get(key, std::string(fallback));
}

std::vector<double> ConfigNode::get(const std::string& key, const std::vector<double>& fallback) const {
  const Data::Entry* entry = data_->ask(key);
  return entry ? data_->read_numbers(*entry, "a list of numbers") : fallback;
}

std::vector<std::string> ConfigNode::get(const std::string& key,
                                         const std::vector<std::string>& fallback) const {
  const Data::Entry* entry = data_->ask(key);
  if (!entry) return fallback;
  if (entry->value->kind != YamlValue::Kind::sequence) data_->wrong(*entry, *entry->value, "a list of texts");
  std::vector<std::string> texts;
  for (const YamlPointer& item : entry->value->items) {
    const auto value = read_text(*item);
    if (!value) data_->wrong(*entry, *item, "a list of texts");
    texts.push_back(*value);
  }
  return texts;
}

std::string ConfigNode::choice(const std::string& key, const std::string& fallback,
                               const std::vector<std::string>& choices) const {
  const Data::Entry* entry = data_->ask(key);
  if (!entry) return fallback;
  const auto value = read_text(*entry->value);
  if (value && std::find(choices.begin(), choices.end(), *value) != choices.end()) return *value;
  std::string must_be = "one of";
  for (const std::string& name : choices) must_be += (&name == &choices.front() ? " '" : ", '") + name + "'";
  data_->wrong(*entry, *entry->value, must_be);
}

double ConfigNode::number(const std::string& key, Range range) const {
  const Data::Entry& entry = data_->require(key);
  const auto value = read_number(*entry.value, range);
  if (!value) data_->wrong(entry, *entry.value, range_text("a number", range));
  return *value;
}

std::string ConfigNode::text(const std::string& key) const {
  const Data::Entry& entry = data_->require(key);
  const auto value = read_text(*entry.value);
  if (!value) data_->wrong(entry, *entry.value, "a text");
  return *value;
}

std::vector<double> ConfigNode::numbers(const std::string& key, std::size_t size) const {
  const Data::Entry& entry = data_->require(key);
  const std::string must_be = "a list of " + std::to_string(size) + " numbers";
  std::vector<double> values = data_->read_numbers(entry, must_be);
  if (values.size() != size)
    throw ConfigError(entry.place.text() + ": '" + key + "' must be " + must_be + ", got " +
                      std::to_string(values.size()));
  return values;
}

ConfigNode ConfigNode::section(const std::string& key) const {
  const Data::Entry* entry = data_->ask(key);
  if (entry && entry->value->kind != YamlValue::Kind::mapping && entry->value->kind != YamlValue::Kind::null)
    data_->wrong(*entry, *entry->value, "a mapping");
  return ConfigNode(data_->child(key));
}

std::vector<ConfigNode> ConfigNode::sections(const std::string& key) const {
  const Data::Entry* entry = data_->ask(key);
  if (!entry) return {};
  if (entry->value->kind != YamlValue::Kind::sequence)
    data_->wrong(*entry, *entry->value, "a list of mappings");
  std::vector<std::shared_ptr<Data>>& made = data_->children[key];
  if (made.empty())
    for (const YamlPointer& item : entry->value->items) {
      if (item->kind != YamlValue::Kind::mapping) data_->wrong(*entry, *item, "a list of mappings");
      made.push_back(
          std::make_shared<Data>(*item, data_->below(key) + "[" + std::to_string(made.size()) + "]"));
    }
  std::vector<ConfigNode> nodes;
  nodes.reserve(made.size());
  for (const std::shared_ptr<Data>& item : made) nodes.push_back(ConfigNode(item));
  return nodes;
}

void ConfigNode::set(const std::string& dotted_key, const std::string& value) {
  const std::string name = of_command_line + dotted_key + "=" + value;
  const YamlPointer parsed = parse_yaml(value, name);
  std::shared_ptr<Data> target = data_;
  std::string rest = dotted_key;
  while (true) {
    const std::size_t dot = rest.find('.');
    const std::string key = rest.substr(0, dot);
    if (key.empty()) throw ConfigError(name + ": the key must be names joined by single dots");
    auto found = std::find_if(target->entries.begin(), target->entries.end(),
                              [&](const Data::Entry& entry) { return entry.key == key; });
    if (dot == std::string::npos) {
      const bool is_section =
          found != target->entries.end() &&
          (found->value->kind == YamlValue::Kind::mapping || found->value->kind == YamlValue::Kind::null);
      if (is_section && parsed->kind == YamlValue::Kind::null) return;  // an empty section says nothing
      target->children.erase(key);
      if (found == target->entries.end()) found = target->entries.insert(found, Data::Entry{});
      *found = {key, nowhere(name), parsed, {}};
      return;
    }
    if (found == target->entries.end()) {
      auto mapping = std::make_shared<YamlValue>();
      mapping->kind = YamlValue::Kind::mapping;
      mapping->place = {target->place.file, 0};
      found = target->entries.insert(found, {key, nowhere(name), mapping, target->folder});
    } else if (found->value->kind != YamlValue::Kind::mapping &&
               found->value->kind != YamlValue::Kind::null) {
      throw ConfigError(name + ": '" + target->below(key) + "' is " + found->value->phrase() +
                        " and has no keys below it");
    }
    target = target->child(key);
    rest = rest.substr(dot + 1);
  }
}

void ConfigNode::ignore(const std::string& key) const {
  data_->ask(key);
  data_->ignored.insert(key);
}

void ConfigNode::finish() const {
  data_->check_all_read();
}

std::filesystem::path ConfigNode::folder(const std::string& key) const {
  const Data::Entry* entry = key.empty() ? nullptr : data_->find(key);
  return entry ? entry->folder : data_->folder;
}

std::string ConfigNode::where(const std::string& key) const {
  const Data::Entry* entry = key.empty() ? nullptr : data_->find(key);
  return (entry ? entry->place : data_->place).text();
}

void ConfigNode::fail(const std::string& key, const std::string& problem) const {
  throw ConfigError(where(key) + ": " + problem);
}

}  // namespace lcmslam
