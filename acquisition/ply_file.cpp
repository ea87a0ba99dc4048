// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "acquisition/triangle_mesh.hpp"
#include "core/text.hpp"

namespace cmm::acquisition {
namespace {

using core::ErrorCode;
using core::fail;

enum class Format { ascii, little, big };
enum class Type { i8, u8, i16, u16, i32, u32, f32, f64 };

struct Property {
    std::string name;
    Type type = Type::f32;
    std::optional<Type> count_type;  // a list
};

struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

struct Header {
    Format format = Format::ascii;
    std::vector<Element> elements;
    std::size_t size = 0;  // bytes up to the data
};

std::optional<Type> type_named(std::string_view word) {
    constexpr std::pair<std::string_view, Type> names[] = {
        {"char", Type::i8},   {"int8", Type::i8},     {"uchar", Type::u8},   {"uint8", Type::u8},
        {"short", Type::i16}, {"int16", Type::i16},   {"ushort", Type::u16}, {"uint16", Type::u16},
        {"int", Type::i32},   {"int32", Type::i32},   {"uint", Type::u32},   {"uint32", Type::u32},
        {"float", Type::f32}, {"float32", Type::f32}, {"double", Type::f64}, {"float64", Type::f64}};
    for (const auto& [name, type] : names) {
        if (word == name) return type;
    }
    return std::nullopt;
}

std::optional<Property> parse_property(const std::vector<std::string_view>& words) {
    Property property;
    const bool list = words.size() == 5 && words[1] == "list";
    if (!list && words.size() != 3) return std::nullopt;
    const auto type = type_named(words[list ? 3 : 1]);
    if (list) property.count_type = type_named(words[2]);
    if (!type || (list && !property.count_type)) return std::nullopt;
    property.type = *type;
    property.name = std::string(words.back());
    return property;
}

core::Result<Header> read_header(std::string_view content, const std::string& name) {
    Header header;
    std::size_t line_number = 0;
    for (std::size_t at = 0; at < content.size();) {
        const auto end = std::min(content.find('\n', at), content.size());
        const auto words = core::split(core::trim(content.substr(at, end - at)), ' ');
        at = std::min(end + 1, content.size());
        ++line_number;
        const auto broken = [&](const std::string& what) {
            return fail(ErrorCode::input_invalid, name + ":" + std::to_string(line_number) + ":1: " + what);
        };
        if (words.empty() || words[0] == "ply" || words[0] == "comment" || words[0] == "obj_info") continue;
        if (words[0] == "end_header") {
            header.size = at;
            return header;
        }
        if (words[0] == "format" && words.size() == 3) {
            if (words[1] == "ascii")
                header.format = Format::ascii;
            else if (words[1] == "binary_little_endian")
                header.format = Format::little;
            else if (words[1] == "binary_big_endian")
                header.format = Format::big;
            else
                return broken("unknown PLY format '" + std::string(words[1]) + "'");
        } else if (words[0] == "element" && words.size() == 3) {
            const auto count = core::parse_number(words[2]);
            if (!count || *count < 0.0 || *count > 4e9) return broken("the element count is not a number");
            header.elements.push_back({std::string(words[1]), static_cast<std::size_t>(*count), {}});
        } else if (words[0] == "property" && !header.elements.empty()) {
            const auto property = parse_property(words);
            if (!property) return broken("unknown property type");
            header.elements.back().properties.push_back(*property);
        } else {
            return broken("unknown line in the PLY header: '" + std::string(words[0]) + "'");
        }
    }
    return fail(ErrorCode::input_invalid, name + ": the PLY header has no end_header");
}

/// The values behind the header, one after another, whatever the format.
class ValueReader {
  public:
    ValueReader(std::string_view data, Format format) : data_(data), format_(format) {}

    /// False at the end of the data or where no number stands.
    bool read(Type type, double& value) {
        if (format_ == Format::ascii) return read_text(value);
        switch (type) {
            case Type::i8:
                return read_binary<std::int8_t>(value);
            case Type::u8:
                return read_binary<std::uint8_t>(value);
            case Type::i16:
                return read_binary<std::int16_t>(value);
            case Type::u16:
                return read_binary<std::uint16_t>(value);
            case Type::i32:
                return read_binary<std::int32_t>(value);
            case Type::u32:
                return read_binary<std::uint32_t>(value);
            case Type::f32:
                return read_binary<float>(value);
            case Type::f64:
                return read_binary<double>(value);
        }
        return false;
    }

  private:
    bool read_text(double& value) {
        const auto start = data_.find_first_not_of(" \t\r\n");
        if (start == std::string_view::npos) return false;
        const auto end = std::min(data_.find_first_of(" \t\r\n", start), data_.size());
        const auto number = core::parse_number(data_.substr(start, end - start));
        data_.remove_prefix(end);
        value = number.value_or(0.0);
        return number.has_value();
    }

    template <class T>
    bool read_binary(double& value) {
        if (data_.size() < sizeof(T)) return false;
        std::array<char, sizeof(T)> bytes;
        std::copy_n(data_.begin(), sizeof(T), bytes.begin());
        data_.remove_prefix(sizeof(T));
        const bool swap = (format_ == Format::big) == (std::endian::native == std::endian::little);
        if (swap) std::reverse(bytes.begin(), bytes.end());
        T number;
        std::memcpy(&number, bytes.data(), sizeof(T));
        value = static_cast<double>(number);
        return true;
    }

    std::string_view data_;
    Format format_;
};

/// One record of an element: the vertex position or the face go into the mesh, everything else is passed over.
bool read_record(const Element& element, ValueReader& reader, TriangleMesh& mesh) {
    Eigen::Vector3d position = Eigen::Vector3d::Zero();
    std::vector<std::uint32_t> corners;
    for (const auto& property : element.properties) {
        double value = 0.0;
        if (!property.count_type) {
            if (!reader.read(property.type, value)) return false;
            const auto axis = std::string_view("xyz").find(property.name);
            if (property.name.size() == 1 && axis != std::string_view::npos)
                position[static_cast<Eigen::Index>(axis)] = value;
            continue;
        }
        double count = 0.0;
        if (!reader.read(*property.count_type, count) || count < 0.0) return false;
        const bool is_face = property.name == "vertex_indices" || property.name == "vertex_index";
        for (double k = 0.0; k < count; k += 1.0) {
            if (!reader.read(property.type, value)) return false;
            // A negative index is out of every range: the caller's range check reports it.
            if (is_face)
                corners.push_back(value < 0.0 ? std::numeric_limits<std::uint32_t>::max()
                                              : static_cast<std::uint32_t>(value));
        }
    }
    if (element.name == "vertex") mesh.vertices.push_back(position);
    for (std::size_t i = 2; i < corners.size(); ++i)
        mesh.triangles.push_back({corners[0], corners[i - 1], corners[i]});
    return true;
}

}  // namespace

core::Result<TriangleMesh> read_ply(std::string_view content, const std::string& name) {
    const auto header = read_header(content, name);
    if (!header) return tl::unexpected(header.error());
    ValueReader reader(content.substr(header->size), header->format);
    TriangleMesh mesh;
    for (const auto& element : header->elements) {
        for (std::size_t i = 0; i < element.count; ++i) {
            if (read_record(element, reader, mesh)) continue;
            return fail(ErrorCode::input_invalid, name + ": " + element.name + " " + std::to_string(i) + " of " +
                                                      std::to_string(element.count) +
                                                      " cannot be read (truncated or not a number)");
        }
    }
    if (mesh.vertices.empty()) return fail(ErrorCode::input_invalid, name + ": the PLY file has no vertices");
    return mesh;
}

}  // namespace cmm::acquisition
