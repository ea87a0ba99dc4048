// SPDX-License-Identifier: Apache-2.0
#include "acquisition/svg.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "core/text.hpp"

namespace cmm::acquisition::svg {
namespace {

std::string at(const Vector2d& p) {
    return number(p.x()) + " " + number(p.y());
}

double distance_to_chord(const Vector2d& p, const Vector2d& a, const Vector2d& b) {
    const Vector2d along = b - a;
    const double length = along.squaredNorm();
    const double t = length > 0.0 ? std::clamp((p - a).dot(along) / length, 0.0, 1.0) : 0.0;
    return (p - a - t * along).norm();
}

/// Douglas and Peucker 1973, with a stack of its own instead of recursion.
std::vector<Vector2d> thinned(std::span<const Vector2d> points, double thinning_px) {
    if (points.size() < 3) return {points.begin(), points.end()};
    std::vector<bool> keep(points.size(), false);
    keep.front() = keep.back() = true;
    std::vector<std::pair<std::size_t, std::size_t>> open{{0, points.size() - 1}};
    while (!open.empty()) {
        const auto [first, last] = open.back();
        open.pop_back();
        double farthest = thinning_px;
        std::size_t split = first;
        for (std::size_t i = first + 1; i < last; ++i) {
            const double distance = distance_to_chord(points[i], points[first], points[last]);
            if (distance > farthest) {
                farthest = distance;
                split = i;
            }
        }
        if (split == first) continue;
        keep[split] = true;
        open.emplace_back(first, split);
        open.emplace_back(split, last);
    }
    std::vector<Vector2d> kept;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (keep[i]) kept.push_back(points[i]);
    }
    return kept;
}

std::string_view word(Anchor anchor) {
    constexpr std::array<std::string_view, 3> words{"start", "middle", "end"};
    return words[static_cast<std::size_t>(anchor)];
}

}  // namespace

std::string escape(std::string_view text) {
    std::string out;
    out.reserve(text.size());
    for (const char c : text) {
        switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            case '\'':
                out += "&#39;";
                break;
            default:
                if (static_cast<unsigned char>(c) >= 0x20 || c == '\n' || c == '\t') out += c;
        }
    }
    return out;
}

std::string number(double pixels) {
    std::string text = core::fixed(pixels, 2);
    while (text.back() == '0')
        text.pop_back();
    if (text.back() == '.') text.pop_back();
    return text.empty() || text == "-" ? "0" : text;
}

std::string polyline(std::span<const Vector2d> pixels, bool closed, double thinning_px) {
    if (pixels.empty()) return {};
    std::vector<Vector2d> ring(pixels.begin(), pixels.end());
    if (closed) ring.push_back(ring.front());
    const auto kept = thinned(ring, thinning_px);
    std::string data = "M" + at(kept.front());
    const std::size_t count = closed ? kept.size() - 1 : kept.size();
    for (std::size_t i = 1; i < count; ++i)
        data += "L" + at(kept[i]);
    return closed ? data + "Z" : data;
}

std::string dots(std::span<const Vector2d> pixels) {
    std::string data;
    for (const auto& p : pixels)
        data += "M" + at(p) + "h0";
    return data;
}

std::string crosses(std::span<const Vector2d> pixels, double half_px) {
    const auto down = "l" + number(2 * half_px) + " " + number(2 * half_px);
    const auto up = "l" + number(2 * half_px) + " " + number(-2 * half_px);
    std::string data;
    for (const auto& p : pixels) {
        data.append("M").append(at(p - Vector2d(half_px, half_px))).append(down);
        data.append("M").append(at(p + Vector2d(-half_px, half_px))).append(up);
    }
    return data;
}

double round_down(double value) {
    if (!(value > 0.0) || !std::isfinite(value)) return 1.0;
    const double power = std::pow(10.0, std::floor(std::log10(value)));
    for (const double factor : {5.0, 2.0}) {
        if (factor * power <= value * (1.0 + 1e-9)) return factor * power;
    }
    return power;
}

Ticks ticks(double low, double high, int about) {
    Ticks out;
    if (!(high > low)) return out;
    const double raw = (high - low) / about;
    double step = round_down(raw);
    if (raw / step > 1.6) step = round_down(step * 2.5);
    out.digits = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
    const double first = std::ceil(low / step - 1e-9);
    const double last = std::floor(high / step + 1e-9);
    for (double k = first; k <= last; k += 1.0)
        out.values.push_back(k * step);
    return out;
}

Picture::Picture(double width_px, double height_px, std::string_view description)
    : width_px_(width_px), height_px_(height_px), description_(escape(description)) {}

void Picture::path(std::string_view css, const std::string& data, double stroke_px) {
    if (data.empty()) return;
    body_.append("<path class=\"").append(css).append("\"");
    if (stroke_px > 0.0) body_.append(" stroke-width=\"" + number(stroke_px) + "\"");
    body_.append(" d=\"").append(data).append("\"/>\n");
}

void Picture::fill(std::string_view colour, const std::string& data) {
    if (data.empty()) return;
    body_.append("<path style=\"fill:").append(colour).append(";stroke:none\" d=\"").append(data).append("\"/>\n");
}

void Picture::line(std::string_view css, const Vector2d& from, const Vector2d& to) {
    path(css, "M" + at(from) + "L" + at(to));
}

void Picture::box(std::string_view css, const Vector2d& corner, const Vector2d& size) {
    body_.append("<rect class=\"").append(css).append("\" x=\"" + number(corner.x()) + "\" y=\"" + number(corner.y()));
    body_.append("\" width=\"" + number(size.x()) + "\" height=\"" + number(size.y()) + "\"/>\n");
}

void Picture::circle(std::string_view css, const Vector2d& centre, double radius_px) {
    body_.append("<circle class=\"").append(css).append("\" cx=\"" + number(centre.x()) + "\" cy=\"");
    body_.append(number(centre.y()) + "\" r=\"" + number(radius_px) + "\"/>\n");
}

void Picture::text(std::string_view css, const Vector2d& at_px, Anchor anchor, std::string_view words, bool upwards) {
    body_.append("<text class=\"").append(css).append("\" text-anchor=\"").append(word(anchor)).append("\"");
    if (upwards) {
        body_.append(" transform=\"translate(" + at(at_px) + ") rotate(-90)\">");
    } else {
        body_.append(" x=\"" + number(at_px.x()) + "\" y=\"" + number(at_px.y()) + "\">");
    }
    body_.append(escape(words)).append("</text>\n");
}

void Picture::clip(const Vector2d& corner, const Vector2d& size) {
    const auto place = "x=\"" + number(corner.x()) + "\" y=\"" + number(corner.y()) + "\" width=\"" + number(size.x()) +
                       "\" height=\"" + number(size.y()) + "\"";
    const auto view = number(corner.x()) + " " + number(corner.y()) + " " + number(size.x()) + " " + number(size.y());
    body_.append("<svg overflow=\"hidden\" " + place + " viewBox=\"" + view + "\">\n");
}

void Picture::unclip() {
    body_ += "</svg>\n";
}

std::string Picture::finish() const {
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"fig\" role=\"img\" viewBox=\"0 0 " + number(width_px_) +
           " " + number(height_px_) + "\">\n<title>" + description_ + "</title>\n" + body_ + "</svg>\n";
}

std::string_view figure_style() {
    return R"css(
.fig{--paper:#fff;--ink:#1c2127;--soft:#5d6874;--rule:#dfe3e8;--nominal:#8a95a1;--side:#1f66ad;--edge:#7a4fa3;
--out:#c22f26;--good:#1d7d4d;--open:#a06400;--zone:#1f66ad14;--band:#e3f1e9;
font-family:system-ui,-apple-system,"Segoe UI",Roboto,"Helvetica Neue",Arial,sans-serif;background:var(--paper)}
@media (prefers-color-scheme:dark){.fig{--paper:#15191e;--ink:#e4e8ec;--soft:#98a3af;--rule:#2e353d;--nominal:#7d8894;
--side:#6cabec;--edge:#bd93e6;--out:#ff7b70;--good:#55c08a;--open:#e0a63f;--zone:#6cabec1c;--band:#1d3127}}
.fig path{fill:none;stroke-linejoin:round}
.fig text{font-size:11px;fill:var(--soft);font-variant-numeric:tabular-nums}
.fig text.strong{fill:var(--ink);font-weight:600}
.fig text.on{paint-order:stroke;stroke:var(--paper);stroke-width:4px;stroke-linejoin:round}
.fig text.tag{font-size:10px;letter-spacing:.06em}
.fig .frame{fill:none;stroke:var(--rule)}
.fig .grid{stroke:var(--rule);stroke-width:.6}
.fig .zero{stroke:var(--soft);stroke-width:.9}
.fig .limit{stroke:var(--good);stroke-width:1.1;stroke-dasharray:5 3}
.fig .nominal{stroke:var(--nominal);stroke-width:1.1}
.fig .measured{stroke:var(--side);stroke-width:1.4}
.fig .dot{stroke:var(--side);stroke-width:2.6;stroke-linecap:round;opacity:.75}
.fig .reject{stroke:var(--out);stroke-width:1.3}
.fig .arc{stroke:var(--edge);stroke-width:.9;stroke-dasharray:3 3;fill:none}
.fig .centre{stroke:var(--edge);stroke-width:1}
.fig path.band{fill:var(--band);stroke:none}
.fig .tolerance{stroke:var(--band)}
.fig .whisker-side{stroke:var(--side);stroke-width:.8}
.fig .whisker-edge{stroke:var(--edge);stroke-width:.8}
.fig .whisker-out{stroke:var(--out);stroke-width:.9}
.fig .envelope{stroke:var(--ink);stroke-width:.7;opacity:.65}
.fig .zone{fill:var(--zone);stroke:none}
.fig path.sure{fill:var(--side);opacity:.22;stroke:none}
.fig .bar{stroke:var(--ink);stroke-width:1.2}
.fig path.unknown{fill:var(--nominal);opacity:.45;stroke:none}
.fig .trend{stroke:var(--side);stroke-width:1;opacity:.6}
.fig .error{stroke:var(--soft);stroke-width:1}
.fig circle.reported{fill:var(--side)}.fig circle.accept{fill:var(--good)}.fig circle.reject{fill:var(--out);stroke:none}
.fig circle.undecided{fill:var(--open)}
.fig circle.by-0{fill:var(--side)}.fig circle.by-1{fill:var(--edge)}.fig circle.by-2{fill:var(--open)}.fig circle.by-3{fill:var(--nominal)}
)css";
}

namespace {

std::string with_style(const std::string& picture, const std::string& style) {
    const std::string_view end = "</title>\n";
    const auto at = picture.find(end) + end.size();
    return picture.substr(0, at) + "<style>" + style + "</style>\n" + picture.substr(at);
}

/// The light colours, the first "--name:value;" of each, put in place of "var(--name)"; the dark ones go.
std::string light_style() {
    std::string style(figure_style());
    const auto dark = style.find("@media"), after = style.find("}}", dark) + 2;
    style.erase(dark, after - dark);
    const auto head_end = style.find('}');
    std::string head = style.substr(0, head_end);
    for (auto at = head.find("--"); at != std::string::npos; at = head.find("--", at + 2)) {
        const auto colon = head.find(':', at), end = head.find(';', at);
        if (colon == std::string::npos || end == std::string::npos) break;
        const std::string used = "var(" + head.substr(at, colon - at) + ")";
        const std::string value = head.substr(colon + 1, end - colon - 1);
        for (auto place = style.find(used); place != std::string::npos; place = style.find(used))
            style.replace(place, used.size(), value);
    }
    return style;
}

}  // namespace

std::string standalone(const std::string& picture) {
    return with_style(picture, std::string(figure_style()));
}

std::string on_paper(const std::string& picture) {
    static const std::string style = light_style();
    return with_style(picture, style);
}

}  // namespace cmm::acquisition::svg
