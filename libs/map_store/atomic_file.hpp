#pragma once
// Files that are either the old one or the whole new one, whatever happens in between.

#include <filesystem>
#include <functional>
#include <string>

namespace lcmslam {

/// Calls `write` with a temporary name in the same folder, flushes that file to disk and renames it to
/// `file`. On any failure the temporary is removed, an existing `file` stays as it was, and
/// std::runtime_error names the file and the reason.
void write_atomically(const std::filesystem::path& file,
                      const std::function<void(const std::filesystem::path& temporary)>& write);

/// The same for bytes that are already in memory.
void write_atomically(const std::filesystem::path& file, const std::string& bytes);

}  // namespace lcmslam
