// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

#include "core/text.hpp"
#include "sim/mesh_file.hpp"

namespace cmm::sim {

using core::ErrorCode;
using core::fail;
using core::Result;
using core::Status;

namespace {

enum class Scalar : std::uint8_t { i8, u8, i16, u16, i32, u32, f32, f64 };
enum class Format : std::uint8_t { ascii, little, big };

std::optional<Scalar> scalar_named(std::string_view name) {
    struct Name {
        std::string_view text;
        Scalar scalar;
    };
    constexpr Name names[] = {
        {"char", Scalar::i8},   {"int8", Scalar::i8},     {"uchar", Scalar::u8},   {"uint8", Scalar::u8},
        {"short", Scalar::i16}, {"int16", Scalar::i16},   {"ushort", Scalar::u16}, {"uint16", Scalar::u16},
        {"int", Scalar::i32},   {"int32", Scalar::i32},   {"uint", Scalar::u32},   {"uint32", Scalar::u32},
        {"float", Scalar::f32}, {"float32", Scalar::f32}, {"double", Scalar::f64}, {"float64", Scalar::f64}};
    for (const auto& candidate : names) {
        if (candidate.text == name) return candidate.scalar;
    }
    return std::nullopt;
}

struct Property {
    std::string name;
    Scalar type = Scalar::f32;
    std::optional<Scalar> list_length;  // a list: type of its length
};

struct Element {
    std::string name;
    std::size_t count = 0;
    std::vector<Property> properties;
};

struct Header {
    Format format = Format::ascii;
    std::vector<Element> elements;
    std::size_t end = 0;  // offset of the first byte after it
    std::size_t lines = 0;
};

template <class T>
T load(const char* bytes, bool swap) {
    std::array<char, sizeof(T)> copy;
    std::memcpy(copy.data(), bytes, sizeof(T));
    if (swap) std::reverse(copy.begin(), copy.end());
    return std::bit_cast<T>(copy);
}

/// Reads numbers one after another, whatever the format; the first failure sticks and everything after it is 0.
class Numbers {
  public:
    Numbers(std::string_view content, const Header& header, const std::string& name)
        : content_(content), at_(header.end), line_(header.lines + 1), format_(header.format), name_(name) {}

    double next(Scalar type) {
        if (!error_.empty()) return 0.0;
        return format_ == Format::ascii ? next_text() : next_binary(type);
    }
    bool good() const { return error_.empty(); }
    const std::string& error() const { return error_; }
    void complain(const std::string& what) {
        if (error_.empty()) error_ = place() + ": " + what;
    }

  private:
    std::string place() const {
        return format_ == Format::ascii ? name_ + ":" + std::to_string(line_) : name_ + ": byte " + std::to_string(at_);
    }
    double next_text() {
        while (at_ < content_.size() && std::strchr(" \t\r\n", content_[at_]) != nullptr) {
            if (content_[at_] == '\n') ++line_;
            ++at_;
        }
        const std::size_t end = std::min(content_.find_first_of(" \t\r\n", at_), content_.size());
        const std::string_view word = content_.substr(at_, end - at_);
        at_ = end;
        if (word.empty()) {
            complain("the file ends before all elements are there");
            return 0.0;
        }
        const auto value = core::parse_number(word);
        if (!value) complain("not a number: '" + std::string(word.substr(0, 40)) + "'");
        return value.value_or(0.0);
    }
    double next_binary(Scalar type) {
        constexpr std::array<std::size_t, 8> sizes{1, 1, 2, 2, 4, 4, 4, 8};
        const std::size_t size = sizes[static_cast<std::size_t>(type)];
        if (content_.size() - at_ < size) {
            complain("the file ends before all elements are there");
            return 0.0;
        }
        const char* bytes = content_.data() + at_;
        const bool swap = (format_ == Format::big) != (std::endian::native == std::endian::big);
        at_ += size;
        switch (type) {
            case Scalar::i8:
                return load<std::int8_t>(bytes, swap);
            case Scalar::u8:
                return load<std::uint8_t>(bytes, swap);
            case Scalar::i16:
                return load<std::int16_t>(bytes, swap);
            case Scalar::u16:
                return load<std::uint16_t>(bytes, swap);
            case Scalar::i32:
                return load<std::int32_t>(bytes, swap);
            case Scalar::u32:
                return load<std::uint32_t>(bytes, swap);
            case Scalar::f32:
                return static_cast<double>(load<float>(bytes, swap));
            case Scalar::f64:
                break;
        }
        return load<double>(bytes, swap);
    }

    std::string_view content_;
    std::size_t at_;
    std::size_t line_;
    Format format_;
    const std::string& name_;
    std::string error_;
};

/// One word list of the header into `header`; the text of what is wrong, or nothing.
std::string read_header_line(const std::vector<std::string_view>& words, Header& header) {
    if (words[0] == "comment" || words[0] == "obj_info") return {};
    if (words[0] == "format" && words.size() == 3) {
        if (words[1] == "ascii")
            header.format = Format::ascii;
        else if (words[1] == "binary_little_endian")
            header.format = Format::little;
        else if (words[1] == "binary_big_endian")
            header.format = Format::big;
        else
            return "unknown format '" + std::string(words[1]) + "'";
        return {};
    }
    if (words[0] == "element" && words.size() == 3) {
        const auto count = core::parse_number(words[2]);
        if (!count || *count < 0.0 || *count > 4e9 || *count != std::floor(*count)) return "bad element count";
        header.elements.push_back({std::string(words[1]), static_cast<std::size_t>(*count), {}});
        return {};
    }
    if (words[0] == "property" && !header.elements.empty() &&
        (words.size() == 3 || (words.size() == 5 && words[1] == "list"))) {
        Property property{std::string(words.back()), Scalar::f32, std::nullopt};
        const auto type = scalar_named(words[words.size() - 2]);
        if (words.size() == 5) property.list_length = scalar_named(words[2]);
        if (!type || (words.size() == 5 && !property.list_length)) return "unknown property type";
        property.type = *type;
        header.elements.back().properties.push_back(property);
        return {};
    }
    return "unknown header line";
}

Result<Header> read_header(std::string_view content, const std::string& name) {
    Header header;
    while (header.end < content.size()) {
        const std::size_t end = std::min(content.find('\n', header.end), content.size());
        const std::string_view line = core::trim(content.substr(header.end, end - header.end));
        header.end = std::min(end + 1, content.size());
        ++header.lines;
        if (line == "end_header") return header;
        if (line.empty() || (header.lines == 1 && line == "ply")) continue;
        if (const auto what = read_header_line(core::split(line, ' '), header); !what.empty()) {
            std::string text = name + ":" + std::to_string(header.lines) + ": " + what;
            text.append(": '").append(line.substr(0, 60)).append("'");
            return fail(ErrorCode::input_invalid, std::move(text));
        }
    }
    return fail(ErrorCode::input_invalid,
                name + ":" + std::to_string(header.lines) + ": PLY header without end_header");
}

void read_vertices(const Element& element, Numbers& numbers, TriangleMesh& mesh) {
    for (std::size_t i = 0; i < element.count && numbers.good(); ++i) {
        Eigen::Vector3d p = Eigen::Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
        for (const auto& property : element.properties) {
            const double items = property.list_length ? numbers.next(*property.list_length) : 1.0;
            for (double k = 0.0; k < items && numbers.good(); ++k) {
                const double value = numbers.next(property.type);
                if (property.name.size() == 1 && property.name[0] >= 'x' && property.name[0] <= 'z')
                    p[property.name[0] - 'x'] = value;
            }
        }
        if (numbers.good() && !p.allFinite())
            numbers.complain("vertex " + std::to_string(i) + " has no finite x, y and z");
        mesh.vertices.push_back(p);
    }
}

void add_polygon(const std::vector<double>& corners, std::size_t vertices, Numbers& numbers, TriangleMesh& mesh) {
    std::vector<std::uint32_t> index;
    for (const double corner : corners) {
        if (!(corner >= 0.0 && corner < static_cast<double>(vertices))) {
            numbers.complain("a face uses vertex " + core::fixed(corner, 0) + " of " + std::to_string(vertices));
            return;
        }
        index.push_back(static_cast<std::uint32_t>(corner));
    }
    for (std::size_t k = 2; k < index.size(); ++k) {
        if (index[0] != index[k - 1] && index[k - 1] != index[k] && index[k] != index[0]) {
            mesh.triangles.push_back({index[0], index[k - 1], index[k]});
        }
    }
}

void read_faces(const Element& element, std::size_t vertices, Numbers& numbers, TriangleMesh& mesh) {
    std::vector<double> list;
    for (std::size_t i = 0; i < element.count && numbers.good(); ++i) {
        for (const auto& property : element.properties) {
            const double items = property.list_length ? numbers.next(*property.list_length) : 1.0;
            list.clear();
            for (double k = 0.0; k < items && numbers.good(); ++k)
                list.push_back(numbers.next(property.type));
            const bool corners = property.name == "vertex_indices" || property.name == "vertex_index";
            if (corners && property.list_length && numbers.good()) add_polygon(list, vertices, numbers, mesh);
        }
    }
}

void skip(const Element& element, Numbers& numbers) {
    for (std::size_t i = 0; i < element.count && numbers.good(); ++i) {
        for (const auto& property : element.properties) {
            const double items = property.list_length ? numbers.next(*property.list_length) : 1.0;
            for (double k = 0.0; k < items && numbers.good(); ++k)
                numbers.next(property.type);
        }
    }
}

}  // namespace

Result<TriangleMesh> parse_ply(std::string_view content, const std::string& name) {
    const auto header = read_header(content, name);
    if (!header) return tl::unexpected(header.error());
    std::size_t vertices = 0;
    for (const auto& element : header->elements) {
        if (element.name == "vertex") vertices = element.count;
    }
    Numbers numbers(content, *header, name);
    TriangleMesh mesh;
    for (const auto& element : header->elements) {
        if (element.name == "vertex")
            read_vertices(element, numbers, mesh);
        else if (element.name == "face")
            read_faces(element, vertices, numbers, mesh);
        else
            skip(element, numbers);
        if (!numbers.good()) {
            return fail(ErrorCode::input_invalid, numbers.error() + " (element " + element.name + ")");
        }
    }
    if (mesh.triangles.empty()) return fail(ErrorCode::input_invalid, name + ": no triangles in it");
    return mesh;
}

}  // namespace cmm::sim
