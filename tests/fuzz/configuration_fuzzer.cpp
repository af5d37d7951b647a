// Any text as a configuration, read as the processes read theirs. A part after the first NUL is used as an
// override (--set key=value).

#include <string>

#include <lcmslam/configuration/config.hpp>

namespace lcmslam {
namespace {

void read_settings(const ConfigNode& config) {
  config.get("radius", 0.5, Range{0, 10});
  config.get("iterations", 10, Range{1, 1000});
  config.get("enabled", true);
  config.get("name", "none");
  config.get("numbers", std::vector<double>{1, 2});
  config.get("names", std::vector<std::string>{"a"});
  config.choice("solver", "svd", {"svd", "quaternion", "gauss_newton"});
}

void read_all(const ConfigNode& config) {
  read_settings(config);
  for (const char* name : {"camera", "icp", "fastslam"}) {
    const ConfigNode section = config.section(name);
    read_settings(section);
    read_settings(section.section("fine"));
    section.numbers("translation", 3);
    section.text("frame");
    section.number("height", Range{0, 3});
  }
  for (const ConfigNode& item : config.sections("rooms")) read_settings(item);
  for (const std::string& key : config.keys()) config.where(key);
  config.ignore("launch");
  config.finish();
}

/// Whatever reading stops at, the others are tried too.
template <class Function>
void refused_or_read(Function function) {
  try {
    function();
  } catch (const ConfigError&) {
  }
}

}  // namespace
}  // namespace lcmslam

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace lcmslam;
  const std::string input(reinterpret_cast<const char*>(data), size);
  const std::size_t nul = input.find('\0');
  refused_or_read([&] {
    ConfigNode config = ConfigNode::parse(input.substr(0, nul), "/no/such/folder/fuzzed.yaml");
    if (nul != std::string::npos) {
      const std::string text = input.substr(nul + 1);
      const std::size_t equals = text.find('=');
      refused_or_read([&] {
        config.set(text.substr(0, equals), equals == std::string::npos ? "" : text.substr(equals + 1));
      });
    }
    refused_or_read([&] { read_all(config); });
    refused_or_read([&] { read_settings(config); });
    for (const std::string& key : config.keys()) {
      refused_or_read([&] { config.number(key); });
      refused_or_read([&] { config.get(key, true); });
      refused_or_read([&] { config.get(key, std::vector<double>()); });
      refused_or_read([&] { read_all(config.section(key)); });
      refused_or_read([&] { config.sections(key); });
    }
    refused_or_read([&] { config.finish(); });
  });
  return 0;
}
