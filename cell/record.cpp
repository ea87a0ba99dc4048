// SPDX-License-Identifier: Apache-2.0
#include "cell/record.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "cell/registers.hpp"
#include "core/text.hpp"

namespace cmm::cell {
namespace {

using nlohmann::json;

constexpr std::array<std::string_view, 3> phases{"cleared", "measuring", "done"};

core::Status force_to_disk(const std::string& path) {
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    const bool done = fd >= 0 && ::fsync(fd) == 0;
    const int code = errno;
    if (fd >= 0) ::close(fd);
    if (done) return {};
    return core::fail(core::ErrorCode::journal_io, path + ": cannot be forced to the disk: " + std::strerror(code));
}

core::Result<CellRecord> parse(const std::string& text, const std::string& file) {
    const auto document = json::parse(text, nullptr, false);
    CellRecord record;
    try {
        const auto phase = std::find(phases.begin(), phases.end(), document.at("phase").get<std::string>());
        const auto result = document.at("result").get<std::uint16_t>();
        record.order.run = document.at("run").get<std::uint32_t>();
        record.order.program = document.at("program").get<std::uint16_t>();
        record.order.serial = document.at("serial").get<std::string>();
        record.outcome.reason = static_cast<Reason>(document.at("reason").get<std::uint16_t>());
        record.outcome.may_be_moving = document.at("may_be_moving").get<bool>();
        if (phase != phases.end() && result <= static_cast<std::uint16_t>(CellResult::measured) &&
            is_serial(record.order.serial) && record.order.serial.size() <= longest_serial) {
            record.phase = static_cast<CellRecord::Phase>(phase - phases.begin());
            record.outcome.result = static_cast<CellResult>(result);
            return record;
        }
    } catch (const json::exception&) {
        // Told below, as any other damage.
    }
    return core::fail(core::ErrorCode::input_invalid,
                      file + ": is not what the cell wrote there; if no part is waiting for its result, remove it");
}

}  // namespace

core::Result<CellRecord> load_record(const std::string& file) {
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored)) return CellRecord();
    const auto text = core::read_file(file);
    if (!text) return tl::unexpected(text.error());
    return parse(*text, file);
}

core::Status save_record(const std::string& file, const CellRecord& record) {
    const json document{{"phase", phases.at(static_cast<std::size_t>(record.phase))},
                        {"run", record.order.run},
                        {"program", record.order.program},
                        {"serial", record.order.serial},
                        {"result", static_cast<std::uint16_t>(record.outcome.result)},
                        {"reason", static_cast<std::uint16_t>(record.outcome.reason)},
                        {"may_be_moving", record.outcome.may_be_moving}};
    const std::string beside = file + ".new";
    if (auto status = core::write_file(beside, document.dump() + "\n"); !status) return status;
    if (auto status = force_to_disk(beside); !status) return status;
    if (std::rename(beside.c_str(), file.c_str()) != 0)
        return core::fail(core::ErrorCode::journal_io, file + ": cannot be written: " + std::strerror(errno));
    const auto folder = std::filesystem::path(file).parent_path();
    return force_to_disk(folder.empty() ? "." : folder.string());
}

}  // namespace cmm::cell
