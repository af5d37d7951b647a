#include "procs/bridge/mqtt/mqtt_connection.hpp"

#include <mosquitto.h>
#include <mqtt_protocol.h>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <stdexcept>

namespace lcmslam {
namespace {

constexpr int keep_alive = 10;  // s; after half as much again of silence each side gives the other up

/// Properties of one packet.
class Properties {
 public:
  ~Properties() { mosquitto_property_free_all(&list_); }
  Properties() = default;
  Properties(const Properties&) = delete;
  Properties& operator=(const Properties&) = delete;
  void add(int identifier, std::uint32_t value) { mosquitto_property_add_int32(&list_, identifier, value); }
  const mosquitto_property* get() const { return list_; }

 private:
  mosquitto_property* list_ = nullptr;
};

mosquitto* make_client(const std::string& id, void* owner) {
  static const int initialised = mosquitto_lib_init();
  mosquitto* client = initialised == MOSQ_ERR_SUCCESS ? mosquitto_new(id.c_str(), true, owner) : nullptr;
  if (client == nullptr) throw std::runtime_error("libmosquitto gives no client");
  return client;
}

}  // namespace

/// Called from C: nothing may be thrown through it.
struct MqttConnection::Callbacks {
  template <class Action>
  static void guarded(void* owner, const Action& action) {
    auto& self = *static_cast<MqttConnection*>(owner);
    try {
      action(self);
    } catch (const std::exception& error) {
      if (self.ended_.empty()) self.ended_ = error.what();
    }
  }
  static void connected(mosquitto*, void* owner, int reason, int, const mosquitto_property*) {
    guarded(owner, [&](MqttConnection& self) {
      if (reason != 0)
        self.ended_ = std::string("the broker refuses: ") + mosquitto_reason_string(reason);
      else
        self.events_.connected();
    });
  }
  static void disconnected(mosquitto*, void* owner, int reason, const mosquitto_property*) {
    guarded(owner, [&](MqttConnection& self) {
      if (!self.ended_.empty()) return;
      self.ended_ = reason == 0    ? "closed"
                    : reason < 128 ? mosquitto_strerror(reason)
                                   : std::string("the broker left: ") + mosquitto_reason_string(reason);
    });
  }
  static void published(mosquitto*, void* owner, int message, int reason, const mosquitto_property*) {
    guarded(owner, [&](MqttConnection& self) {
      if (reason >= 128) ++self.refused_;
      self.events_.acknowledged(message);
    });
  }
  static void subscribed(mosquitto*, void* owner, int message, int n, const int* granted,
                         const mosquitto_property*) {
    guarded(owner, [&](MqttConnection& self) {
      const auto asked = self.asked_.find(message);
      if (asked == self.asked_.end()) return;
      const std::string filter = asked->second;
      self.asked_.erase(asked);
      if (n > 0 && granted[0] >= 128) self.events_.unsubscribed(filter, mosquitto_reason_string(granted[0]));
    });
  }
  static void came(mosquitto*, void* owner, const mosquitto_message* message, const mosquitto_property*) {
    guarded(owner, [&](MqttConnection& self) {
      self.events_.came(message->topic, static_cast<const std::uint8_t*>(message->payload),
                        static_cast<std::size_t>(std::max(message->payloadlen, 0)), message->retain);
    });
  }
};

MqttConnection::MqttConnection(const bridge::Broker& broker, const std::string& presence, Events events)
    : events_(std::move(events)), client_(make_client(broker.id, this), mosquitto_destroy) {
  mosquitto* client = client_.get();
  mosquitto_int_option(client, MOSQ_OPT_PROTOCOL_VERSION, MQTT_PROTOCOL_V5);
  mosquitto_int_option(client, MOSQ_OPT_TCP_NODELAY, 1);
  if (!broker.certificates.empty()) {
    const bool folder = std::filesystem::is_directory(broker.certificates);
    const auto named = [](const std::string& file) { return file.empty() ? nullptr : file.c_str(); };
    check(mosquitto_tls_set(client, folder ? nullptr : broker.certificates.c_str(),
                            folder ? broker.certificates.c_str() : nullptr, named(broker.certificate),
                            named(broker.key), nullptr),
          "the certificates cannot be used");
  }
  if (!broker.user.empty())
    check(mosquitto_username_pw_set(client, broker.user.c_str(), broker.password.c_str()), "user");
  if (!presence.empty())
    check(mosquitto_will_set_v5(client, presence.c_str(), 1, "0", 1, true, nullptr), "last will");
  mosquitto_connect_v5_callback_set(client, &Callbacks::connected);
  mosquitto_disconnect_v5_callback_set(client, &Callbacks::disconnected);
  mosquitto_publish_v5_callback_set(client, &Callbacks::published);
  mosquitto_subscribe_v5_callback_set(client, &Callbacks::subscribed);
  mosquitto_message_v5_callback_set(client, &Callbacks::came);
  check(mosquitto_connect_bind_async(client, broker.host.c_str(), broker.port, keep_alive, nullptr),
        "no connection");
}

MqttConnection::~MqttConnection() = default;

void MqttConnection::check(int result, const char* what) const {
  if (!ended_.empty()) throw std::runtime_error(ended_);
  if (result == MOSQ_ERR_SUCCESS) return;
  const std::string why = result == MOSQ_ERR_ERRNO ? std::strerror(errno) : mosquitto_strerror(result);
  throw std::runtime_error(std::string(what) + ": " + why);
}

void MqttConnection::loop(std::chrono::milliseconds wait) {
  check(mosquitto_loop(client_.get(), static_cast<int>(wait.count()), 1), "no connection");
}

int MqttConnection::publish(const std::string& topic, const void* data, std::size_t size, bool kept,
                            double lives) {
  Properties properties;
  if (lives > 0)
    properties.add(MQTT_PROP_MESSAGE_EXPIRY_INTERVAL, static_cast<std::uint32_t>(std::ceil(lives)));
  int message = 0;
  check(mosquitto_publish_v5(client_.get(), &message, topic.c_str(), static_cast<int>(size), data, 1, kept,
                             properties.get()),
        "not sent");
  return message;
}

void MqttConnection::subscribe(const std::string& filter, bool with_kept) {
  const int options = with_kept ? MQTT_SUB_OPT_SEND_RETAIN_ALWAYS : MQTT_SUB_OPT_SEND_RETAIN_NEVER;
  int message = 0;
  check(mosquitto_subscribe_v5(client_.get(), &message, filter.c_str(), 1, options, nullptr),
        "no subscription");
  asked_[message] = filter;
}

void MqttConnection::disconnect() {
  mosquitto_disconnect_v5(client_.get(), 0, nullptr);
}

}  // namespace lcmslam
