// SPDX-License-Identifier: Apache-2.0
#include "pdf/pages.hpp"

#include <cairo-pdf.h>
#include <pango/pangocairo.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pdf/svg_picture.hpp"

namespace cmm::pdf {
namespace {

// Points of 1/72 inch.
constexpr double page_width = 595.28, page_height = 841.89;
constexpr double margin = 45.0, foot_height = 24.0;
constexpr double text_width = page_width - 2.0 * margin, bottom = page_height - margin - foot_height;
constexpr double body_size = 8.5, small_size = 7.5, heading_size = 13.0, title_size = 20.0;
constexpr double line_gap = 2.0, block_gap = 10.0, cell_padding = 2.5, picture_gap = 12.0;

struct Colour {
    double red, green, blue;
};
constexpr Colour rule_colour{0.87, 0.89, 0.91};

Colour colour_of(Ink ink) {
    switch (ink) {
        case Ink::plain:
            return {0.11, 0.13, 0.15};
        case Ink::soft:
            return {0.36, 0.41, 0.46};
        case Ink::good:
            return {0.11, 0.49, 0.30};
        case Ink::bad:
            return {0.76, 0.18, 0.15};
        case Ink::open:
            return {0.63, 0.39, 0.00};
    }
    return {0.0, 0.0, 0.0};
}

using Layout = std::unique_ptr<PangoLayout, Unref<PangoLayout>>;

struct Text {
    double size = body_size;
    bool bold = false;
    Ink ink = Ink::plain;
    bool right = false;
};

cairo_status_t append(void* closure, const unsigned char* data, unsigned int length) {
    static_cast<std::string*>(closure)->append(reinterpret_cast<const char*>(data), length);
    return CAIRO_STATUS_SUCCESS;
}

}  // namespace

struct Pages::Work {
    std::string bytes;
    About about;
    cairo_surface_t* surface = nullptr;
    cairo_t* cairo = nullptr;
    double y = margin;
    int page = 1;
    std::optional<core::Error> error;

    explicit Work(const About& what) : about(what) {
        surface = cairo_pdf_surface_create_for_stream(append, &bytes, page_width, page_height);
        cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_TITLE, about.title.c_str());
        cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATOR, "cmmlive");
        if (!about.created_utc.empty())
            cairo_pdf_surface_set_metadata(surface, CAIRO_PDF_METADATA_CREATE_DATE, about.created_utc.c_str());
        cairo = cairo_create(surface);
    }
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;
    ~Work() {
        cairo_destroy(cairo);
        cairo_surface_destroy(surface);
    }

    void ink(const Colour& colour) { cairo_set_source_rgb(cairo, colour.red, colour.green, colour.blue); }

    Layout layout(const std::string& words, const Text& text, double width) {
        Layout out(pango_cairo_create_layout(cairo));
        PangoFontDescription* font = pango_font_description_from_string("sans-serif");
        pango_font_description_set_absolute_size(font, text.size * PANGO_SCALE);
        if (text.bold) pango_font_description_set_weight(font, PANGO_WEIGHT_BOLD);
        pango_layout_set_font_description(out.get(), font);
        pango_font_description_free(font);
        pango_layout_set_width(out.get(), static_cast<int>(width * PANGO_SCALE));
        pango_layout_set_wrap(out.get(), PANGO_WRAP_WORD_CHAR);
        if (text.right) pango_layout_set_alignment(out.get(), PANGO_ALIGN_RIGHT);
        pango_layout_set_text(out.get(), words.c_str(), static_cast<int>(words.size()));
        return out;
    }

    static double height_of(PangoLayout* layout) {
        int height = 0;
        pango_layout_get_size(layout, nullptr, &height);
        return static_cast<double>(height) / PANGO_SCALE;
    }

    void show(PangoLayout* layout, double x, double at, Ink colour) {
        ink(colour_of(colour));
        cairo_move_to(cairo, x, at);
        pango_cairo_show_layout(cairo, layout);
    }

    /// Returns its height.
    double write(const std::string& words, const Text& text, double x, double at, double width) {
        const Layout out = layout(words, text, width);
        show(out.get(), x, at, text.ink);
        return height_of(out.get());
    }

    void rule(double at) {
        ink(rule_colour);
        cairo_set_line_width(cairo, 0.6);
        cairo_move_to(cairo, margin, at);
        cairo_line_to(cairo, page_width - margin, at);
        cairo_stroke(cairo);
    }

    void foot() {
        const double at = page_height - margin - 4.0;
        rule(at - 4.0);
        write(about.foot, {small_size, false, Ink::soft, false}, margin, at, text_width - 60.0);
        write(std::to_string(page), {small_size, false, Ink::soft, true}, margin + text_width - 60.0, at, 60.0);
    }

    void new_page() {
        foot();
        cairo_show_page(cairo);
        ++page;
        y = margin;
    }

    /// True when a new page was begun.
    bool need(double height) {
        if (y + height <= bottom || y <= margin) return false;
        new_page();
        return true;
    }

    double row_height(const std::vector<Layout>& cells) {
        double height = 0.0;
        for (const Layout& cell : cells)
            height = std::max(height, height_of(cell.get()));
        return height + 2.0 * cell_padding;
    }

    void draw_picture(const Picture& picture, const Svg& svg, double x, double width, double height) {
        const double caption =
            picture.caption.empty()
                ? 0.0
                : write(picture.caption, {small_size, false, Ink::soft, false}, x, y, width) + line_gap;
        const RsvgRectangle box{x, y + caption, width, height};
        GError* why = nullptr;
        if (rsvg_handle_render_document(svg.get(), cairo, &box, &why) == FALSE) {
            refuse(taken(why));
            return;
        }
    }

    void refuse(const std::string& text) {
        if (!error) error = core::Error{core::ErrorCode::internal, "PDF: a picture is no SVG: " + text, {}, {}};
    }

    Svg parse(const Picture& picture) {
        std::string why;
        Svg svg = parse_svg(picture.svg, why);
        if (!svg) refuse(why);
        return svg;
    }
};

Pages::Pages(std::unique_ptr<Work> work) : work_(std::move(work)) {}
Pages::Pages(Pages&& other) noexcept = default;
Pages& Pages::operator=(Pages&& other) noexcept = default;
Pages::~Pages() = default;

core::Result<Pages> Pages::make(const About& about) {
    if (!has_fonts())
        return core::fail(core::ErrorCode::config_invalid,
                          about.title + " cannot be written: no font is installed; install fonts-dejavu-core");
    return Pages(std::make_unique<Work>(about));
}

void Pages::title(const std::string& text, const std::string& verdict, Ink ink) {
    Work& w = *work_;
    const double left = 0.68 * text_width;
    const double named = w.write(text, {title_size, true, Ink::plain, false}, margin, w.y, left);
    const double judged = w.write(verdict, {title_size, true, ink, true}, margin + left, w.y, text_width - left);
    w.y += std::max(named, judged) + block_gap;
}

void Pages::heading(const std::string& text) {
    Work& w = *work_;
    w.need(0.25 * page_height);
    w.y += 0.5 * block_gap;
    w.y += w.write(text, {heading_size, true, Ink::plain, false}, margin, w.y, text_width) + 0.5 * block_gap;
}

void Pages::paragraph(const std::string& text, Ink ink) {
    Work& w = *work_;
    const Layout layout = w.layout(text, {}, text_width);
    const double height = Work::height_of(layout.get());
    w.need(height);
    w.show(layout.get(), margin, w.y, ink);
    w.y += height + line_gap;
}

void Pages::facts(std::span<const std::pair<std::string, std::string>> facts) {
    Work& w = *work_;
    constexpr double name_share = 0.18, half = 0.5 * text_width;
    for (std::size_t i = 0; i < facts.size(); i += 2) {
        std::array<Layout, 4> texts;
        double height = 0.0;
        const std::size_t end = std::min(i + 2, facts.size());
        for (std::size_t k = i; k < end; ++k) {
            auto &name = texts[2 * (k - i)], &value = texts[2 * (k - i) + 1];
            name = w.layout(facts[k].first, {}, name_share * text_width);
            value = w.layout(facts[k].second, {}, half - name_share * text_width - cell_padding);
            height = std::max({height, Work::height_of(name.get()), Work::height_of(value.get())});
        }
        w.need(height);
        for (std::size_t k = i; k < end; ++k) {
            const double x = margin + static_cast<double>(k - i) * half;
            w.show(texts[2 * (k - i)].get(), x, w.y, Ink::soft);
            w.show(texts[2 * (k - i) + 1].get(), x + name_share * text_width, w.y, Ink::plain);
        }
        w.y += height + line_gap;
    }
    w.y += line_gap;
}

void Pages::table(std::span<const Column> columns, std::span<const std::vector<Cell>> rows) {
    Work& w = *work_;
    double sum = 0.0;
    for (const Column& column : columns)
        sum += column.share;
    std::vector<double> x(columns.size()), width(columns.size());
    double at = margin;
    for (std::size_t c = 0; c < columns.size(); ++c) {
        x[c] = at;
        width[c] = columns[c].share / sum * text_width - 2.0 * cell_padding;
        at += columns[c].share / sum * text_width;
    }
    const auto lay = [&](std::size_t c, const std::string& words, bool head) {
        return w.layout(words, {small_size, head, Ink::plain, columns[c].right}, width[c]);
    };
    const auto draw = [&](const std::vector<Layout>& cells, const std::vector<Ink>& inks) {
        for (std::size_t c = 0; c < cells.size(); ++c)
            w.show(cells[c].get(), x[c] + cell_padding, w.y + cell_padding, inks[c]);
        w.y += w.row_height(cells);
        w.rule(w.y);
    };
    std::vector<Layout> head;
    for (std::size_t c = 0; c < columns.size(); ++c)
        head.push_back(lay(c, columns[c].title, true));
    const std::vector<Ink> head_inks(columns.size(), Ink::soft);
    w.need(3.0 * w.row_height(head));
    draw(head, head_inks);
    for (const auto& row : rows) {
        std::vector<Layout> cells;
        std::vector<Ink> inks;
        for (std::size_t c = 0; c < columns.size() && c < row.size(); ++c) {
            cells.push_back(lay(c, row[c].text, false));
            inks.push_back(row[c].ink);
        }
        if (w.need(w.row_height(cells))) draw(head, head_inks);
        draw(cells, inks);
    }
    w.y += block_gap;
}

void Pages::pictures(std::span<const Picture> pictures, int beside) {
    Work& w = *work_;
    const double width = (text_width - picture_gap * (beside - 1)) / beside;
    const auto step = static_cast<std::size_t>(beside);
    for (std::size_t i = 0; i < pictures.size(); i += step) {
        std::vector<Svg> svgs;
        double height = 0.0;
        const std::size_t end = std::min(i + step, pictures.size());
        for (std::size_t k = i; k < end; ++k) {
            svgs.push_back(w.parse(pictures[k]));
            if (svgs.back()) height = std::max(height, width * proportion_of(svgs.back().get()));
        }
        const double most = bottom - margin - 2.0 * block_gap;
        height = std::min(height, most);
        constexpr double caption = small_size + 4.0 * line_gap;
        w.need(height + caption);
        for (std::size_t k = i; k < end; ++k) {
            if (!svgs[k - i]) continue;
            const double own = std::min(width * proportion_of(svgs[k - i].get()), height);
            w.draw_picture(pictures[k], svgs[k - i], margin + static_cast<double>(k - i) * (width + picture_gap), width,
                           own);
        }
        w.y += height + caption + line_gap;
    }
}

core::Result<std::string> Pages::finish() {
    Work& w = *work_;
    if (w.error) return tl::unexpected(*w.error);
    w.foot();
    cairo_show_page(w.cairo);
    cairo_surface_finish(w.surface);
    const auto status = cairo_surface_status(w.surface);
    if (status != CAIRO_STATUS_SUCCESS)
        return core::fail(core::ErrorCode::internal, std::string("PDF: ") + cairo_status_to_string(status));
    return std::move(w.bytes);
}

}  // namespace cmm::pdf
