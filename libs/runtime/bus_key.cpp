#include <lcmslam/runtime/bus_key.hpp>

#include <sodium.h>
#include <sys/stat.h>
#include <cstdlib>
#include <fstream>
#include <stdexcept>

namespace lcmslam {

BusKey read_bus_key(const std::string& file) {
  const std::string where = "the bus's key " + file + " (LCMSLAM_BUS_KEY) ";
  struct stat state {};
  std::ifstream in(file);
  std::string digits;
  if (stat(file.c_str(), &state) != 0 || !in || !(in >> digits))
    throw std::invalid_argument(where + "cannot be read; make one: (umask 077; openssl rand -hex 32 > " +
                                file + ")");
  if ((state.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    throw std::invalid_argument(where + "may be read by others; it must be its owner's alone: chmod 600 " +
                                file);
  BusKey key{};
  std::size_t size = 0;
  const int wrong =
      sodium_hex2bin(key.data(), key.size(), digits.data(), digits.size(), nullptr, &size, nullptr);
  if (wrong != 0 || size != key.size() || digits.size() != 2 * key.size())
    throw std::invalid_argument(where + "has " + std::to_string(digits.size()) +
                                " characters that are no key; 64 hexadecimal digits are one");
  return key;
}

std::optional<BusKey> bus_key() {
  const char* file = std::getenv("LCMSLAM_BUS_KEY");
  if (file == nullptr || *file == '\0') return std::nullopt;
  return read_bus_key(file);
}

}  // namespace lcmslam
