#include "tools/page/self_contained_page.hpp"

#include <sodium.h>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace lcmslam {
namespace {

/// The element from `begin` to `end` that holds `mark` becomes `text`.
void replace_element(std::string& page, const std::string& begin, const std::string& mark,
                     const std::string& end, const std::string& text) {
  const std::size_t at = page.find(mark);
  const std::size_t from = at == std::string::npos ? at : page.rfind(begin, at);
  const std::size_t to = at == std::string::npos ? at : page.find(end, at);
  if (from == std::string::npos || to == std::string::npos)
    throw std::runtime_error("the page's index.html has no " + begin + "... " + mark);
  page.replace(from, to + end.size() - from, text);
}

/// A script that holds the end of a script would end there.
std::string safe_in_script(std::string script) {
  for (std::size_t at = script.find("</script"); at != std::string::npos; at = script.find("</script", at))
    script.replace(at, 8, "<\\/script");
  return script;
}

}  // namespace

std::string read_page_file(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  if (!stream) throw std::runtime_error(file.string() + ": is missing from the page");
  return {std::istreambuf_iterator<char>(stream), {}};
}

std::string base64(const std::string& bytes) {
  std::string text(sodium_base64_encoded_len(bytes.size(), sodium_base64_VARIANT_ORIGINAL), '\0');
  sodium_bin2base64(text.data(), text.size(), reinterpret_cast<const unsigned char*>(bytes.data()),
                    bytes.size(), sodium_base64_VARIANT_ORIGINAL);
  text.pop_back();  // its final zero
  return text;
}

std::string self_contained_page(const std::filesystem::path& folder, const std::string& name,
                                const std::string& data) {
  const std::string script = name + ".js", style = name + ".css";
  const auto quoted = [](const std::string& file) { return '"' + file + '"'; };  // as an attribute names it
  std::string page = read_page_file(folder / "index.html");
  replace_element(page, "<link", quoted("icon.svg"), ">", "");
  replace_element(page, "<link", quoted(style), ">", "<style>" + read_page_file(folder / style) + "</style>");
  replace_element(page, "<script", quoted(script), "</script>",
                  data + "\n<script>" + safe_in_script(read_page_file(folder / script)) + "</script>");
  return page;
}

}  // namespace lcmslam
