// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "core/error.hpp"

/// A document on A4 pages, top to bottom, as PDF. Texts are UTF-8, pictures SVG.
namespace cmm::pdf {

enum class Ink { plain, soft, good, bad, open };

struct Cell {
    std::string text;
    Ink ink = Ink::plain;
};

struct Column {
    std::string title;
    double share = 1.0;  ///< of the page's width, relative to the other columns
    bool right = false;  ///< numbers end at the same place
};

struct Picture {
    std::string caption;
    std::string svg;  ///< with width and height or a viewBox; its proportions stay
};

/// What every page says at its foot, and what the file says about itself.
struct About {
    std::string title;
    std::string foot;
    std::string created_utc;  ///< "2026-03-01T10:00:00Z"; empty: not said
};

/// Grows from top to bottom; what does not fit any more begins a new page. One owner.
class Pages {
  public:
    /// Errors: config_invalid (this build writes no PDF, no font is installed).
    static core::Result<Pages> make(const About& about);
    Pages(Pages&& other) noexcept;
    Pages& operator=(Pages&& other) noexcept;
    ~Pages();

    void title(const std::string& text, const std::string& verdict, Ink ink);
    /// Begins a new page where less than a quarter of the page is left.
    void heading(const std::string& text);
    void paragraph(const std::string& text, Ink ink = Ink::plain);
    /// Name and value, two beside each other.
    void facts(std::span<const std::pair<std::string, std::string>> facts);
    /// Long texts are broken within their column; the head is repeated on every page.
    void table(std::span<const Column> columns, std::span<const std::vector<Cell>> rows);
    /// So many beside each other; one that is no SVG is refused at the end.
    void pictures(std::span<const Picture> pictures, int beside);

    /// The bytes of the file. Errors: internal (a picture that is no SVG, Cairo).
    core::Result<std::string> finish();

  private:
    struct Work;
    explicit Pages(std::unique_ptr<Work> work);
    std::unique_ptr<Work> work_;
};

}  // namespace cmm::pdf
