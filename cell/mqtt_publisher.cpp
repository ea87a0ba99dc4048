// SPDX-License-Identifier: Apache-2.0
#include "cell/mqtt_publisher.hpp"

#include <mosquitto.h>
#include <netdb.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>
#include <utility>

#include "cell/mqtt_queue.hpp"

namespace cmm::cell {
namespace {

constexpr std::size_t most_under_way = 20;
constexpr int keepalive_s = 20;
constexpr unsigned first_pause_s = 1, longest_pause_s = 30;
constexpr auto look_again = std::chrono::seconds(5);  // for a name that is not known yet
constexpr auto farewell = std::chrono::milliseconds(500);
constexpr int at_least_once = 1;

/// libmosquitto begins once in a process.
void begin_library() {
    static const int begun = mosquitto_lib_init();
    static_cast<void>(begun);
}

/// Numeric, so that libmosquitto never gives up because of a name server; empty: not known.
std::string numeric(const std::string& host) {
    addrinfo wanted{};
    wanted.ai_family = AF_UNSPEC;
    wanted.ai_socktype = SOCK_STREAM;
    addrinfo* found = nullptr;
    if (::getaddrinfo(host.c_str(), nullptr, &wanted, &found) != 0) return {};
    std::array<char, NI_MAXHOST> text{};
    const int code =
        ::getnameinfo(found->ai_addr, found->ai_addrlen, text.data(), text.size(), nullptr, 0, NI_NUMERICHOST);
    ::freeaddrinfo(found);
    return code == 0 ? std::string(text.data()) : std::string();
}

}  // namespace

struct MqttPublisher::Impl {
    Impl(MqttOptions the_options, std::function<void(const std::string&)> the_notice)
        : options(std::move(the_options)), notice(std::move(the_notice)) {}
    ~Impl();

    core::Status start();
    void pump();
    void send(std::unique_lock<std::mutex>& lock);
    bool connect();
    void connected_with(int code);
    void disconnected();
    void delivered(int message);

    MqttOptions options;
    std::function<void(const std::string&)> notice;
    mosquitto* client = nullptr;
    mutable std::mutex mutex;
    std::condition_variable changed;
    MqttQueue queue;
    std::set<int> under_way;  // message ids that the broker has not confirmed
    std::set<int> early;      // confirmed before their id was known here
    bool connected = false, ending = false, told = false, told_drop = false;
    std::uint64_t published = 0;
    std::thread thread;
};

core::Status MqttPublisher::Impl::start() {
    begin_library();
    const std::string id = "cmmlive-" + std::to_string(::getpid());
    client = mosquitto_new(id.c_str(), true, this);
    if (client == nullptr) return core::fail(core::ErrorCode::internal, "libmosquitto made no client");
    const std::string online = options.prefix + "/online";
    mosquitto_will_set(client, online.c_str(), 1, "0", at_least_once, true);
    if (!options.user.empty()) mosquitto_username_pw_set(client, options.user.c_str(), options.password.c_str());
    mosquitto_reconnect_delay_set(client, first_pause_s, longest_pause_s, true);
    mosquitto_max_inflight_messages_set(client, most_under_way);
    mosquitto_connect_callback_set(
        client, [](mosquitto*, void* self, int code) { static_cast<Impl*>(self)->connected_with(code); });
    mosquitto_disconnect_callback_set(client,
                                      [](mosquitto*, void* self, int) { static_cast<Impl*>(self)->disconnected(); });
    mosquitto_publish_callback_set(
        client, [](mosquitto*, void* self, int message) { static_cast<Impl*>(self)->delivered(message); });
    thread = std::thread([this] { pump(); });
    return {};
}

MqttPublisher::Impl::~Impl() {
    bool stands = false;
    {
        std::unique_lock lock(mutex);
        changed.wait_for(lock, farewell, [this] { return !connected || (queue.size() == 0 && under_way.empty()); });
        ending = true;
        stands = connected;
    }
    changed.notify_all();
    if (thread.joinable()) thread.join();
    if (client == nullptr) return;
    if (stands) {
        const std::string online = options.prefix + "/online";
        mosquitto_publish(client, nullptr, online.c_str(), 1, "0", 0, true);
    }
    mosquitto_disconnect(client);
    // Without a broker its thread may be waiting for a connection for minutes: it is not waited for.
    mosquitto_loop_stop(client, !stands);
    mosquitto_destroy(client);
}

/// False: the name is not known.
bool MqttPublisher::Impl::connect() {
    const std::string address = numeric(options.host);
    if (address.empty()) return false;
    // Refused or not there: its thread tries again.
    mosquitto_loop_start(client);
    mosquitto_connect_async(client, address.c_str(), options.port, keepalive_s);
    return true;
}

void MqttPublisher::Impl::pump() {
    std::unique_lock lock(mutex);
    for (bool begun = false; !ending && !begun;) {
        lock.unlock();
        begun = connect();
        lock.lock();
        if (!begun) changed.wait_for(lock, look_again, [this] { return ending; });
    }
    while (!ending) {
        changed.wait(lock,
                     [this] { return ending || (connected && queue.size() > 0 && under_way.size() < most_under_way); });
        if (!ending) send(lock);
    }
}

void MqttPublisher::Impl::send(std::unique_lock<std::mutex>& lock) {
    auto message = queue.pop();
    if (!message) return;
    const std::string topic = options.prefix + "/" + message->topic;
    int id = 0;
    lock.unlock();
    const int code = mosquitto_publish(client, &id, topic.c_str(), static_cast<int>(message->payload.size()),
                                       message->payload.data(), at_least_once, message->retained);
    lock.lock();
    if (code != MOSQ_ERR_SUCCESS) {
        connected = false;  // until it says otherwise
        queue.put_back(std::move(*message));
    } else if (early.erase(id) == 0) {
        under_way.insert(id);
    }
}

void MqttPublisher::Impl::connected_with(int code) {
    std::string text;
    {
        const std::lock_guard guard(mutex);
        connected = code == 0;
        if (connected) queue.push({"online", "1", true});
        if (connected || !std::exchange(told, true))
            text = connected ? "there" : std::string("refuses: ") + mosquitto_connack_string(code);
        if (connected) told = false;
    }
    changed.notify_all();
    if (!text.empty()) notice("mqtt: the broker " + (code == 0 ? "is " + text : text));
}

void MqttPublisher::Impl::disconnected() {
    bool was = false;
    {
        const std::lock_guard guard(mutex);
        was = std::exchange(connected, false) && !ending;
    }
    changed.notify_all();
    if (was) notice("mqtt: the broker is gone; the cell goes on");
}

void MqttPublisher::Impl::delivered(int message) {
    {
        const std::lock_guard guard(mutex);
        if (under_way.erase(message) == 0) early.insert(message);
        ++published;
    }
    changed.notify_all();
}

MqttPublisher::MqttPublisher(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
MqttPublisher::~MqttPublisher() = default;

core::Result<std::unique_ptr<MqttPublisher>> MqttPublisher::start(const MqttOptions& options,
                                                                  std::function<void(const std::string&)> notice) {
    auto impl = std::make_unique<Impl>(options, std::move(notice));
    if (auto status = impl->start(); !status) return tl::unexpected(status.error());
    return std::unique_ptr<MqttPublisher>(new MqttPublisher(std::move(impl)));
}

void MqttPublisher::publish(const std::string& topic, std::string payload, bool retained) {
    bool first_drop = false;
    {
        const std::lock_guard guard(impl_->mutex);
        const auto before = impl_->queue.dropped();
        impl_->queue.push({topic, std::move(payload), retained});
        first_drop = impl_->queue.dropped() > before && !std::exchange(impl_->told_drop, true);
    }
    impl_->changed.notify_all();
    if (first_drop) impl_->notice("mqtt: the queue is full, messages are dropped (and counted in /metrics)");
}

MqttCounts MqttPublisher::counts() const {
    const std::lock_guard guard(impl_->mutex);
    return {impl_->connected, impl_->published, impl_->queue.dropped(), impl_->queue.size()};
}

}  // namespace cmm::cell
