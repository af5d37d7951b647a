#pragma once
// A page's bundle as one file that opens offline.

#include <filesystem>
#include <string>

namespace lcmslam {

/// Throws std::runtime_error that names a file which is missing.
std::string read_page_file(const std::filesystem::path& file);
std::string base64(const std::string& bytes);

/// index.html of `folder` with NAME.css and NAME.js inside, and `data`, an element, before the script. Its
/// icon is left out. Throws std::runtime_error that names what is missing.
std::string self_contained_page(const std::filesystem::path& folder, const std::string& name,
                                const std::string& data);

}  // namespace lcmslam
