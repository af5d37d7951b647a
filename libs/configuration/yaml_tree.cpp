#include <lcmslam/configuration/yaml_tree.hpp>

#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>
#include <algorithm>
#include <map>
#include <sstream>

#include <lcmslam/configuration/config.hpp>
#include <lcmslam/configuration/utf8.hpp>

namespace lcmslam {
namespace {

constexpr int max_depth = 64;
constexpr std::size_t max_size = 100'000;

[[noreturn]] void fail(const YamlPlace& place, const std::string& problem) {
  throw ConfigError(place.text() + ": " + problem);
}

/// Builds the tree from the parser's events; the open collections stand on a stack.
class TreeBuilder : public YAML::EventHandler {
 public:
  explicit TreeBuilder(std::shared_ptr<const std::string> file) : file_(std::move(file)) {}
  YamlPointer root() const { return root_; }

  void OnDocumentStart(const YAML::Mark&) override {}
  void OnDocumentEnd() override {}

  void OnNull(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    auto value = make(YamlValue::Kind::null, mark);
    finished(value, anchor);
  }

  void OnAlias(const YAML::Mark& mark, YAML::anchor_t anchor) override {
    const auto found = anchors_.find(anchor);
    if (found == anchors_.end()) fail(place(mark), "an alias may not stand inside the value that it names");
    add(found->second, place(mark));
  }

  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t anchor,
                const std::string& text) override {
    auto value = make(YamlValue::Kind::scalar, mark);
    value->text = text;
    value->quoted = tag != "?" && !tag.empty();
    finished(value, anchor);
  }

  void OnSequenceStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                       YAML::EmitterStyle::value) override {
    open(YamlValue::Kind::sequence, mark, anchor);
  }
  void OnSequenceEnd() override { close(); }

  void OnMapStart(const YAML::Mark& mark, const std::string&, YAML::anchor_t anchor,
                  YAML::EmitterStyle::value) override {
    open(YamlValue::Kind::mapping, mark, anchor);
  }
  void OnMapEnd() override { close(); }

 private:
  struct Open {
    std::shared_ptr<YamlValue> value;
    YAML::anchor_t anchor;
    bool has_key = false;
    std::string key;
    YamlPlace key_place;
  };

  YamlPlace place(const YAML::Mark& mark) const { return {file_, mark.line + 1}; }

  std::shared_ptr<YamlValue> make(YamlValue::Kind kind, const YAML::Mark& mark) const {
    auto value = std::make_shared<YamlValue>();
    value->kind = kind;
    value->place = place(mark);
    return value;
  }

  void open(YamlValue::Kind kind, const YAML::Mark& mark, YAML::anchor_t anchor) {
    if (stack_.size() >= max_depth)
      fail(place(mark), "nested more than " + std::to_string(max_depth) + " levels deep");
    stack_.push_back({make(kind, mark), anchor, false, {}, {}});
  }

  void close() {
    Open done = std::move(stack_.back());
    stack_.pop_back();
    finished(done.value, done.anchor);
  }

  void finished(const YamlPointer& value, YAML::anchor_t anchor) {
    if (anchor) anchors_[anchor] = value;
    add(value, value->place);
  }

  /// Puts a finished value into the collection that is open: as item, as key or as value of the key.
  void add(const YamlPointer& value, const YamlPlace& at) {
    if (stack_.empty()) {
      root_ = value;
      return;
    }
    Open& parent = stack_.back();
    YamlValue& target = *parent.value;
    if (target.kind == YamlValue::Kind::mapping && !parent.has_key) {
      if (value->kind != YamlValue::Kind::scalar) fail(at, "a key must be a word, got " + value->phrase());
      if (const YamlEntry* first = target.find(value->text))
        fail(at,
             "key '" + value->text + "' stands twice, first in line " + std::to_string(first->place.line));
      parent.has_key = true;
      parent.key = value->text;
      parent.key_place = at;
      return;
    }
    target.size += value->size;
    target.depth = std::max(target.depth, value->depth + 1);
    if (target.size > max_size) fail(at, "more than " + std::to_string(max_size) + " values");
    if (target.depth > max_depth) fail(at, "nested more than " + std::to_string(max_depth) + " levels deep");
    if (target.kind == YamlValue::Kind::sequence) {
      target.items.push_back(value);
    } else {
      target.entries.push_back({parent.key, parent.key_place, value});
      parent.has_key = false;
    }
  }

  std::shared_ptr<const std::string> file_;
  std::vector<Open> stack_;
  std::map<YAML::anchor_t, YamlPointer> anchors_;
  YamlPointer root_;
};

/// The parser would take a byte of value 0 for the end, and hand on what is no UTF-8 to those who write JSON.
void require_text(const std::string& text, const std::shared_ptr<const std::string>& file) {
  int line = 1;
  for (std::size_t i = 0; i < text.size();) {
    const auto size = utf8_character_size(text, i);
    const auto byte = static_cast<unsigned char>(text[i]);
    if (byte == 0 || !size)
      fail({file, line}, "a byte of value " + std::to_string(byte) + ": must be text in UTF-8");
    if (text[i] == '\n') ++line;
    i += *size;
  }
}

}  // namespace

std::string YamlPlace::text() const {
  return line > 0 ? *file + ":" + std::to_string(line) : *file;
}

const YamlEntry* YamlValue::find(const std::string& key) const {
  for (const YamlEntry& entry : entries)
    if (entry.key == key) return &entry;
  return nullptr;
}

std::string YamlValue::phrase() const {
  constexpr std::size_t longest = 60;
  switch (kind) {
    case Kind::null:
      return "nothing";
    case Kind::sequence:
      return "a list";
    case Kind::mapping:
      return "a mapping";
    case Kind::scalar:
      break;
  }
  return "'" + (text.size() > longest ? text.substr(0, longest) + "..." : text) + "'";
}

YamlPointer parse_yaml(const std::string& text, const std::string& name) {
  const auto file = std::make_shared<const std::string>(name);
  TreeBuilder builder(file);
  require_text(text, file);
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    if (!parser.HandleNextDocument(builder)) {
      auto nothing = std::make_shared<YamlValue>();
      nothing->place = {file, 0};
      return nothing;
    }
    const YamlPointer root = builder.root();
    if (parser.HandleNextDocument(builder)) fail({file, 0}, "has more than one YAML document");
    return root;
  } catch (const ConfigError&) {
    throw;
  } catch (const YAML::Exception& error) {
    std::string problem = "not valid YAML: " + error.msg;
    if (error.msg.find("end of map") != std::string::npos || text.find('\t') != std::string::npos)
      problem += " (check the indentation: spaces, no tabs)";
    fail({file, error.mark.is_null() ? 0 : error.mark.line + 1}, problem);
  } catch (const std::exception& error) {
    fail({file, 0}, std::string("not valid YAML: ") + error.what());
  }
}

}  // namespace lcmslam
