#include <lcmslam/bridge/broker.hpp>

#include <sys/stat.h>
#include <fstream>
#include <stdexcept>

namespace lcmslam::bridge {

bool is_this_machine(const std::string& host) {
  const auto only = [&](const char* allowed) { return host.find_first_not_of(allowed) == std::string::npos; };
  return host == "localhost" || host == "::1" || (host.rfind("127.", 0) == 0 && only("0123456789."));
}

std::string objection(const Broker& broker) {
  if (is_this_machine(broker.host)) return {};
  if (broker.certificates.empty())
    return "what goes to " + broker.host +
           " would be readable and forgeable on its way: name the certificates that are trusted "
           "(bridge.tls.certificates: /etc/ssl/certs, port 8883), or allow it (bridge.insecure: true)";
  if (broker.user.empty() && broker.certificate.empty())
    return "nothing would tell " + broker.host +
           " who this bridge is: give bridge.user and bridge.password_file, or bridge.tls.certificate and "
           "bridge.tls.key, or allow it (bridge.insecure: true)";
  return {};
}

std::string read_password(const std::filesystem::path& file) {
  const std::string where = "the broker's password file " + file.string() + " ";
  struct stat state {};
  std::ifstream in(file);
  std::string password;
  if (stat(file.c_str(), &state) != 0 || !in || !std::getline(in, password))
    throw std::invalid_argument(where + "cannot be read or is empty");
  if ((state.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    throw std::invalid_argument(where + "may be read by others; it must be its owner's alone: chmod 600 " +
                                file.string());
  return password;
}

}  // namespace lcmslam::bridge
