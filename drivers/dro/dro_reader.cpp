// SPDX-License-Identifier: Apache-2.0
#include "drivers/dro/dro_reader.hpp"

#include <boost/asio/post.hpp>
#include <future>
#include <utility>

namespace cmm::drivers::dro {
namespace {

// Bytes that come sooner after the port was opened may be the tail of a line.
constexpr core::Duration quiet_before_line = std::chrono::milliseconds(100);

}  // namespace

DroReader::DroReader(const SerialSettings& serial, LineFormat format, const core::Clock& clock)
    : format_(std::move(format)),
      clock_(clock),
      wire_(io_, serial, log_, {[this](auto bytes) { take(bytes); }, [this] { lost_ = true; }}) {
    thread_ = std::thread([this] { io_.run(); });
}

DroReader::~DroReader() {
    io_.stop();
    thread_.join();
}

core::Status DroReader::open() {
    std::promise<std::string> opened;
    boost::asio::post(io_, [this, &opened] {
        opened_ = clock_.now();
        first_bytes_ = true;
        std::string why = wire_.open();
        lost_ = !why.empty();
        opened.set_value(std::move(why));
    });
    const std::string why = opened.get_future().get();
    if (why.empty()) return {};
    return core::fail(core::ErrorCode::transport_connect, why, core::Motion::not_concerned);
}

void DroReader::take(std::span<const std::uint8_t> bytes) {
    const core::Duration now = clock_.now();
    if (first_bytes_) splitter_.restart(format_.begins_with_text() || now - opened_ >= quiet_before_line);
    first_bytes_ = false;
    lines_.clear();
    splitter_.feed(bytes, lines_);
    for (const auto& line : lines_) {
        Heard heard{format_.read(line.text), line.text, now};
        if (!line.whole) {
            heard.content.kind = LineContent::Kind::garbled;
            heard.content.why =
                line.text.size() < LineSplitter::longest ? "its beginning may have been missed" : "too long for a line";
        }
        const bool garbled = heard.content.kind == LineContent::Kind::garbled;
        log_.count([garbled](LinkStats& stats) { ++(garbled ? stats.invalid : stats.ok); });
        const std::lock_guard lock(mutex_);
        heard_.push_back(std::move(heard));
    }
}

std::optional<Heard> DroReader::next() {
    const std::lock_guard lock(mutex_);
    if (heard_.empty()) return std::nullopt;
    Heard heard = std::move(heard_.front());
    heard_.pop_front();
    return heard;
}

void DroReader::forget() {
    const std::lock_guard lock(mutex_);
    heard_.clear();
}

void DroReader::send(const std::string& text) {
    boost::asio::post(io_, [this, text] { wire_.send(text, false); });
}

}  // namespace cmm::drivers::dro
