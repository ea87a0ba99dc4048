// SPDX-License-Identifier: Apache-2.0
#include "web/server/token.hpp"

#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>

#include "core/text.hpp"

namespace cmm::web {
namespace {

constexpr std::size_t shortest = 16, longest = 128;

bool well_formed(std::string_view token) {
    constexpr std::string_view letters = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
    return token.size() >= shortest && token.size() <= longest &&
           token.find_first_not_of(letters) == std::string_view::npos;
}

}  // namespace

core::Result<std::string> new_token() {
    std::array<std::uint8_t, 16> bytes{};
    if (::getrandom(bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size()))
        return core::fail(core::ErrorCode::internal, "the system has no random numbers for a token");
    std::string token;
    for (const unsigned byte : bytes) {
        token += "0123456789abcdef"[byte >> 4U];
        token += "0123456789abcdef"[byte & 15U];
    }
    return token;
}

core::Result<std::string> read_token_file(const std::string& file) {
    struct stat about {};
    if (::stat(file.c_str(), &about) != 0 || !S_ISREG(about.st_mode))
        return core::fail(core::ErrorCode::input_missing, file + ": there is no such token file");
    if ((about.st_mode & (S_IRWXG | S_IRWXO)) != 0 || (about.st_uid != ::geteuid() && about.st_uid != 0)) {
        return core::fail(core::ErrorCode::config_invalid,
                          file + ": others may read this token file; make it yours alone: chmod 600 " + file);
    }
    const auto text = core::read_file(file);
    if (!text) return tl::unexpected(text.error());
    const std::string token(core::trim(*text));
    if (!well_formed(token)) {
        return core::fail(core::ErrorCode::config_invalid,
                          file + ": a token is 16 to 128 letters, digits, '-' and '_' on one line, and nothing else");
    }
    return token;
}

bool same_token(std::string_view known, std::string_view shown) noexcept {
    // Always over the whole length of the one shown; an empty known token lets nobody in.
    unsigned difference = known.size() == shown.size() && !known.empty() ? 0U : 1U;
    for (std::size_t i = 0; i < shown.size(); ++i) {
        const char expected = known.empty() ? '\0' : known[i % known.size()];
        difference |=
            static_cast<unsigned char>(static_cast<unsigned char>(shown[i]) ^ static_cast<unsigned char>(expected));
    }
    return difference == 0U;
}

}  // namespace cmm::web
