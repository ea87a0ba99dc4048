// SPDX-License-Identifier: Apache-2.0
#include "app/mqtt_login.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include "core/text.hpp"

namespace cmm::app {

core::Result<cell::MqttOptions> mqtt_options(const std::string& url, const std::string& login_file) {
    auto options = cell::MqttOptions::parse(url);
    if (!options || login_file.empty()) return options;
    const auto text = core::read_file(login_file);
    if (!text) return tl::unexpected(text.error());
    struct stat about {};
    if (::stat(login_file.c_str(), &about) != 0 || (about.st_mode & (S_IRWXG | S_IRWXO)) != 0) {
        return core::fail(core::ErrorCode::config_invalid,
                          login_file + ": others may read this password: chmod 600 " + login_file);
    }
    const auto line = text->find('\n');
    options->user = core::trim(std::string_view(*text).substr(0, line));
    if (line != std::string::npos) options->password = core::trim(std::string_view(*text).substr(line + 1));
    if (!options->user.empty() && !options->password.empty()) return options;
    return core::fail(core::ErrorCode::config_invalid, login_file + ": wants a user and a password, a line each");
}

}  // namespace cmm::app
