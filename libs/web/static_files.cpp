#include <lcmslam/web/static_files.hpp>

#include <libdeflate.h>
#include <sodium.h>
#include <fstream>
#include <iterator>
#include <stdexcept>

namespace lcmslam {
namespace {

const char* type_of(const std::string& ending) {
  static const std::map<std::string, const char*> types = {{".html", "text/html; charset=utf-8"},
                                                           {".js", "text/javascript; charset=utf-8"},
                                                           {".css", "text/css; charset=utf-8"},
                                                           {".json", "application/json"},
                                                           {".webmanifest", "application/manifest+json"},
                                                           {".svg", "image/svg+xml"},
                                                           {".png", "image/png"},
                                                           {".txt", "text/plain; charset=utf-8"}};
  const auto type = types.find(ending);
  return type != types.end() ? type->second : "application/octet-stream";
}

std::string gzip(const std::string& bytes) {
  const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
      libdeflate_alloc_compressor(9), libdeflate_free_compressor);
  std::string packed(bytes.size(), '\0');
  packed.resize(
      libdeflate_gzip_compress(compressor.get(), bytes.data(), bytes.size(), packed.data(), packed.size()));
  return packed;
}

std::string tag_of(const std::string& bytes) {
  unsigned char hash[16];
  crypto_generichash(hash, sizeof(hash), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size(),
                     nullptr, 0);
  char text[2 * sizeof(hash) + 1];
  sodium_bin2hex(text, sizeof(text), hash, sizeof(hash));
  return '"' + std::string(text) + '"';
}

}  // namespace

StaticFiles::StaticFiles(const std::filesystem::path& folder) {
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_regular_file()) continue;
    std::ifstream stream(entry.path(), std::ios::binary);
    StaticFile file{
        type_of(entry.path().extension().string()), {std::istreambuf_iterator<char>(stream), {}}, "", ""};
    file.packed = gzip(file.bytes);
    file.tag = tag_of(file.bytes);
    files_["/" + entry.path().filename().string()] = std::move(file);
  }
  if (files_.count("/index.html") == 0)
    throw std::runtime_error(folder.string() + ": has no index.html, so there is no page to serve");
}

const StaticFile* StaticFiles::find(const std::string& target) const {
  const std::string path = target.substr(0, target.find('?'));
  const auto file = files_.find(path == "/" ? "/index.html" : path);
  return file != files_.end() ? &file->second : nullptr;
}

}  // namespace lcmslam
